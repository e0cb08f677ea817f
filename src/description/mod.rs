//! What the user wrote: names, numbers and paths. A few kilobytes, cheap to clone and compare, because models and
//! pictures are paths.
//!
//! [`parse`] reads it from a scene file; every default of the scene language is a `Default` here.

mod builtin;
mod diagnostic;
pub mod edit;
mod escape;
mod expression;
mod history;
mod interval;
mod names;
pub mod parameter;
mod parse;
mod save;
mod target;

pub use builtin::{DEMO, builtin};
pub use diagnostic::Diagnostic;
pub use escape::printable;
pub use expression::Expression;
pub use history::History;
pub use interval::Interval;
pub use parse::{color_code, files_named, parse, parse_color, point_out};
pub use save::{SaveError, Source, save, says_where_to_end};
pub use target::{Refused, Target};

use crate::math::Rgb;
use glam::{DVec2, DVec3};
use std::path::PathBuf;
use std::sync::Arc;

/// A whole scene as written. Paths are already resolved against the scene file's directory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneDesc {
    /// Picture size.
    pub film: FilmDesc,
    /// Eye and view.
    pub camera: CameraDesc,
    /// What surrounds the objects.
    pub world: WorldDesc,
    /// How the picture is computed.
    pub render: RenderDesc,
    /// Light sources.
    pub lights: Vec<LightDesc>,
    /// Optical properties by name.
    pub materials: Vec<MaterialDesc>,
    /// Things in the scene.
    pub objects: Vec<ObjectDesc>,
}

/// `[film]`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmDesc {
    /// Pixels across, at least 1.
    pub width: u32,
    /// Pixels down, at least 1.
    pub height: u32,
}

/// `[camera]`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraDesc {
    /// Eye, world space.
    pub position: DVec3,
    /// The point in the middle of the picture, world space; differs from `position`.
    pub look_at: DVec3,
    /// Upward direction, not parallel to the view.
    pub up: DVec3,
    /// How space is mapped to the picture.
    pub projection: Projection,
}

/// How space is mapped to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// `fov`: vertical angle of view in degrees, inside 0..180.
    Perspective {
        /// Degrees.
        fov: f64,
    },
    /// `projection = "orthographic"`, `view_height`: height of the view in scene units.
    Orthographic {
        /// Scene units, above 0.
        view_height: f64,
    },
}

/// `[world]`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldDesc {
    /// I_a, the ambient light.
    pub ambient: Rgb,
    /// What rays see that meet nothing.
    pub background: Background,
    /// Refractive index of the space between the objects.
    pub ior: f64,
}

/// What rays see that meet nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// One colour.
    Solid(Rgb),
    /// Blended by the angle of the ray to the camera's `up` at rest, world +y: straight down `bottom`, straight up
    /// `top`, linear in the y of the unit direction.
    Gradient {
        /// Colour at the zenith.
        top: Rgb,
        /// Colour at the nadir.
        bottom: Rgb,
    },
}

/// `[render]`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderDesc {
    /// Lighting model.
    pub shading: Shading,
    /// How many times a ray may be reflected or refracted (0: none), at most 64.
    pub max_depth: u32,
    /// Samples a pixel, at least 1; with `error` the most that a pixel may get.
    pub samples: u32,
    /// Root mean square of the sampling error, in 8-bit codes, at which rendering ends: samples go where the error is.
    /// `None`: every pixel gets `samples`.
    pub error: Option<f64>,
    /// How samples make a pixel.
    pub filter: Filter,
    /// What glass does to shadow rays.
    pub shadows: Shadows,
    /// Which arithmetic finds the hits.
    pub numerics: Numerics,
}

/// `shading`: which terms of the lighting equation are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shading {
    /// Ambient and diffuse. A local model: no shadows, no secondary rays.
    Lambert,
    /// Lambert and highlights. A local model: no shadows, no secondary rays.
    Phong,
    /// Phong with shadows, reflection and refraction.
    Whitted,
}

/// `filter`: the weight of the film around the middle of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The square of the pixel: the mean of what is seen through it.
    Box,
    /// A pyramid two pixels wide: softer, with weaker moire.
    Tent,
}

/// `shadows`: what a transparent object does to a shadow ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shadows {
    /// It blocks the light, as everything does.
    Opaque,
    /// It lets through the part k_t of the light at every surface, unbent.
    Filtered,
}

/// `numerics`: which arithmetic finds the hits. Presets, not knobs; see `geometry`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Numerics {
    /// The coursework's formulas in f32 as published, with a fixed epsilon: kept to be compared with.
    Classic,
    /// Quick usual practice: f32, Moeller-Trumbore, an offset relative to the size of the numbers.
    Fast,
    /// The default: f64 rays over f32 boxes, watertight triangles, offsets from error bounds.
    Robust,
    /// Everything in f64, boxes too: the yardstick.
    Reference,
}

/// `[[light]]`
#[derive(Clone, Debug, PartialEq)]
pub struct LightDesc {
    /// For people; unique or empty.
    pub name: String,
    /// Where the light comes from.
    pub kind: LightKind,
    /// Colour of the light.
    pub color: Rgb,
    /// Factor on the colour, at least 0.
    pub intensity: f64,
    /// Whether it shines: `visible = false` turns it off.
    pub visible: bool,
}

/// Where a light shines from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// From a point, in every direction.
    Point {
        /// World space.
        position: DVec3,
        /// How it weakens with distance.
        falloff: Falloff,
    },
    /// From infinitely far.
    Directional {
        /// The way the light travels, world space, not zero.
        direction: DVec3,
    },
}

/// `falloff` of a point light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Falloff {
    /// As bright at any distance, as in the coursework.
    None,
    /// By the square of the distance in scene units, 1 at distance 1.
    InverseSquare,
}

/// `[[material]]`: the coefficients of
/// I = k_a I_a C + k_d sum I_i (n, l_i) C + k_s sum I_i (v, r_i)^s + k_r I_r + k_t I_t.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDesc {
    /// Unique; objects refer to it.
    pub name: String,
    /// C, unless there is a texture.
    pub color: Rgb,
    /// C from a picture or a pattern.
    pub texture: Option<TextureDesc>,
    /// k_a
    pub ambient: f64,
    /// k_d
    pub diffuse: f64,
    /// k_s
    pub specular: f64,
    /// s
    pub shininess: f64,
    /// k_r
    pub reflect: f64,
    /// k_t
    pub transmit: f64,
    /// Refractive index inside.
    pub ior: f64,
    /// Whether k_r + k_t is divided between the two rays by Fresnel's equations instead of as written.
    pub fresnel: bool,
    /// Where bodies overlap, the one of the higher priority is there; of equals, the smaller one.
    pub priority: i32,
}

/// `texture = { .. }`
#[derive(Clone, Debug, PartialEq)]
pub struct TextureDesc {
    /// What is looked up.
    pub source: TextureSource,
    /// Repeats along u and v: the surface's uv is multiplied by it.
    pub scale: DVec2,
    /// Added to uv after scaling.
    pub offset: DVec2,
}

/// What a texture is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum TextureSource {
    /// A picture file, sRGB, bilinear; v runs upward.
    Image {
        /// Resolved path.
        file: PathBuf,
        /// Outside of 0..1.
        wrap: Wrap,
    },
    /// Squares of side `size` in uv, the first colour at the origin.
    Checker {
        /// The two colours.
        colors: [Rgb; 2],
        /// Side of a square, uv units (scene units on a plane).
        size: f64,
    },
}

/// `wrap`: what a picture shows outside of 0..1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Wrap {
    /// Itself, again and again.
    Repeat,
    /// Its edge.
    Clamp,
    /// Itself, every other time mirrored.
    Mirror,
}

/// `[[object]]`: a shape, its material, and world from object = translate · rotate · scale.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectDesc {
    /// For people; unique or empty.
    pub name: String,
    /// Form, in object space.
    pub shape: ShapeDesc,
    /// Name of a material; `None`: the default one, or for a mesh the file's own.
    pub material: Option<String>,
    /// Scene units.
    pub translate: DVec3,
    /// Degrees, about x, then y, then z.
    pub rotate: DVec3,
    /// Factors along the object's axes, none of them 0.
    pub scale: DVec3,
    /// Whether it is there for any ray: `visible = false` takes it out of the picture and keeps it in the file.
    pub visible: bool,
}

/// `shape` of an object. All are centred on the object's origin; the axis of cylinder and cone is y, plane and quad
/// look along +y. u and v of every shape are stated in `geometry`.
#[derive(Clone, Debug)]
pub enum ShapeDesc {
    /// `radius`
    Sphere {
        /// Scene units.
        radius: f64,
    },
    /// `size`: the edges along x, y and z.
    Cuboid {
        /// Scene units.
        size: DVec3,
    },
    /// `radius`, `height`, capped.
    Cylinder {
        /// Scene units.
        radius: f64,
        /// Scene units.
        height: f64,
    },
    /// `radius` of the base (at -height/2), `height`, capped.
    Cone {
        /// Scene units.
        radius: f64,
        /// Scene units.
        height: f64,
    },
    /// Infinite, y = 0; as a body of glass or water it is the half-space below.
    Plane,
    /// `size` along x and z; has no inside.
    Quad {
        /// Scene units along x and z.
        size: DVec2,
    },
    /// `file`: a model.
    Mesh {
        /// Resolved path of an OBJ file.
        file: PathBuf,
        /// Edges sharper than this, in degrees, stay sharp where the file has no normals; 0: all of them.
        crease: f64,
    },
    /// `data`: many spheres with one material, each `[x, y, z, radius]`, inline or from a file of such lines.
    Spheres {
        /// Centre and radius.
        data: Arc<[[f64; 4]]>,
    },
}

impl PartialEq for ShapeDesc {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Sphere { radius: a }, Self::Sphere { radius: b }) => a == b,
            (Self::Cuboid { size: a }, Self::Cuboid { size: b }) => a == b,
            (Self::Cylinder { radius: a, height: c }, Self::Cylinder { radius: b, height: d })
            | (Self::Cone { radius: a, height: c }, Self::Cone { radius: b, height: d }) => a == b && c == d,
            (Self::Plane, Self::Plane) => true,
            (Self::Quad { size: a }, Self::Quad { size: b }) => a == b,
            (Self::Mesh { file: a, crease: c }, Self::Mesh { file: b, crease: d }) => a == b && c == d,
            // Descriptions are compared with every edit, and there may be a million of spheres.
            (Self::Spheres { data: a }, Self::Spheres { data: b }) => Arc::ptr_eq(a, b) || a == b,
            _ => false,
        }
    }
}

impl Default for FilmDesc {
    fn default() -> Self {
        Self { width: 1280, height: 720 }
    }
}

impl Default for CameraDesc {
    fn default() -> Self {
        Self {
            position: DVec3::new(3.0, 2.0, 5.0),
            look_at: DVec3::ZERO,
            up: DVec3::Y,
            projection: Projection::Perspective { fov: limits::DEFAULT_FOV },
        }
    }
}

impl Default for WorldDesc {
    fn default() -> Self {
        Self { ambient: Rgb::WHITE, background: Background::Solid(Rgb::BLACK), ior: 1.0 }
    }
}

impl Default for RenderDesc {
    fn default() -> Self {
        Self {
            shading: Shading::Whitted,
            max_depth: 8,
            samples: 16,
            error: None,
            filter: Filter::Box,
            shadows: Shadows::Opaque,
            numerics: Numerics::Robust,
        }
    }
}

impl Default for LightDesc {
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: LightKind::Point { position: DVec3::new(4.0, 6.0, 3.0), falloff: Falloff::None },
            color: Rgb::WHITE,
            intensity: 1.0,
            visible: true,
        }
    }
}

impl Default for MaterialDesc {
    fn default() -> Self {
        Self {
            name: String::new(),
            color: Rgb::grey(0.6),
            texture: None,
            ambient: 0.1,
            diffuse: 0.8,
            specular: 0.2,
            shininess: 32.0,
            reflect: 0.0,
            transmit: 0.0,
            ior: 1.5,
            fresnel: false,
            priority: 0,
        }
    }
}

impl ObjectDesc {
    /// An object of this shape, unnamed, at the origin, unscaled, with the default material.
    pub fn new(shape: ShapeDesc) -> Self {
        Self {
            name: String::new(),
            shape,
            material: None,
            translate: DVec3::ZERO,
            rotate: DVec3::ZERO,
            scale: DVec3::ONE,
            visible: true,
        }
    }
}

/// Limits that the parser and every other maker of descriptions keep.
pub mod limits {
    /// Largest width or height of a film in pixels.
    pub const MAX_SIDE: u32 = 32_768;
    /// Largest `max_depth`.
    pub const MAX_DEPTH: u32 = 64;
    /// Largest number of samples a pixel.
    pub const MAX_SAMPLES: u32 = 1 << 20;
    /// The most samples that a pixel gets on the way to an error where no number is given.
    pub const ADAPTIVE_SAMPLES: u32 = 4096;
    /// Error that is aimed at where none is stated, 8-bit codes.
    pub const USUAL_ERROR: f64 = 0.5;
    /// Smallest and largest error that can be asked for, 8-bit codes.
    pub const ERROR: std::ops::RangeInclusive<f64> = 0.01..=64.0;
    /// Largest coordinate, radius, edge or factor of scale.
    pub const MAX_LENGTH: f64 = 1e12;
    /// Smallest radius, edge or factor of scale.
    pub const MIN_LENGTH: f64 = 1e-12;
    /// Largest angle of a rotation, degrees.
    pub const MAX_ANGLE: f64 = 1e6;
    /// Largest channel of a colour and largest intensity.
    pub const MAX_LIGHT: f64 = 1e9;
    /// Largest k_a, k_d and k_s.
    pub const MAX_COEFFICIENT: f64 = 1e6;
    /// Ranks of overlapping bodies.
    pub const PRIORITY: std::ops::RangeInclusive<i64> = -1000..=1000;
    /// Sine of the smallest angle between view and `up`.
    pub const MIN_UP_SINE: f64 = 1e-9;
    /// Vertical angle of view where none is given, degrees.
    pub const DEFAULT_FOV: f64 = 40.0;
    /// Crease angle where none is given, degrees.
    pub const DEFAULT_CREASE: f64 = 30.0;
}
