//! New entries: in view, at a sensible size, of a sensible material.

use super::super::{
    Falloff, LightDesc, LightKind, MaterialDesc, ObjectDesc, Projection, Refused, SceneDesc, ShapeDesc, Target, limits,
    parse_color,
};
use super::place::{Axis, Bounds};
use super::{attempt, free_name, view_centre};
use crate::description::parameter::without_noise;
use crate::math::Rgb;
use glam::{DVec2, DVec3};
use std::path::PathBuf;

/// What can be added.
#[derive(Clone, Debug, PartialEq)]
pub enum New {
    /// A sphere.
    Sphere,
    /// A cuboid with equal edges.
    Cuboid,
    /// A cylinder.
    Cylinder,
    /// A cone.
    Cone,
    /// An infinite plane.
    Plane,
    /// A square.
    Quad,
    /// A model.
    Mesh {
        /// An OBJ file.
        file: PathBuf,
        /// Its box in the space of the file.
        bounds: Bounds,
    },
    /// A light that shines from a point.
    PointLight,
    /// A light from infinitely far.
    DirectionalLight,
    /// A material that nothing is made of yet.
    Material,
}

/// Share of the picture's height that a new object fills.
const FILL: f64 = 0.25;

/// Colours of new objects, one after the other.
const COLORS: [&str; 6] = ["#c8553d", "#3d7ea6", "#e0a030", "#588157", "#8d6a9f", "#b0b0b0"];

/// Adds an entry: what has a size stands on the point that the camera looks at (on y = 0 if that is in view below it),
/// fills a quarter of the picture's height and gets a material of its own, which it shares with nothing; planes lie
/// below everything; lights shine from above and beside the eye. Returns the new entry.
pub fn add(desc: &mut SceneDesc, new: New) -> Result<Target, Refused> {
    attempt(desc, |desc| {
        let (middle, distance) = view_centre(desc);
        let size = size_in_view(desc, distance);
        let half = size / 2.0;
        let stem = match &new {
            New::Sphere => "sphere",
            New::Cuboid => "cuboid",
            New::Cylinder => "cylinder",
            New::Cone => "cone",
            New::Plane => "plane",
            New::Quad => "quad",
            New::Mesh { file, .. } => {
                &file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
            }
            New::PointLight => return Ok(add_light(desc, "lamp", lamp(desc, middle, distance))),
            New::DirectionalLight => return Ok(add_light(desc, "sun", sun(desc))),
            New::Material => {
                let index = add_material(desc, "material");
                return Ok((Target::Material(index), vec![Target::Material(index)]));
            }
        };
        let stem = stem.to_owned();
        let (shape, translate, scale) = match new {
            New::Sphere => (ShapeDesc::Sphere { radius: half }, middle, DVec3::ONE),
            New::Cuboid => (ShapeDesc::Cuboid { size: DVec3::splat(size) }, middle, DVec3::ONE),
            New::Cylinder => (ShapeDesc::Cylinder { radius: half, height: size }, middle, DVec3::ONE),
            New::Cone => (ShapeDesc::Cone { radius: half, height: size }, middle, DVec3::ONE),
            New::Quad => (ShapeDesc::Quad { size: DVec2::splat(size) }, middle, DVec3::ONE),
            New::Plane => (ShapeDesc::Plane, middle - DVec3::Y * half, DVec3::ONE),
            New::Mesh { file, bounds } => {
                let edge = (bounds.upper - bounds.lower).max_element();
                let factor = if edge > 0.0 && edge.is_finite() { rounded(size / edge) } else { 1.0 };
                let shape = ShapeDesc::Mesh { file, crease: limits::DEFAULT_CREASE };
                (shape, middle - (bounds.lower + bounds.upper) / 2.0 * factor, DVec3::splat(factor))
            }
            New::PointLight | New::DirectionalLight | New::Material => unreachable!("they are added above"),
        };
        // A model brings its own materials, or gets the default one.
        let material = match &shape {
            ShapeDesc::Mesh { .. } => None,
            _ => Some(add_material(desc, &stem)),
        };
        let name = free_name(&stem, |name| desc.objects.iter().any(|object| object.name == name));
        let material_name = material.map(|index| desc.materials[index].name.clone());
        let object = ObjectDesc {
            name,
            material: material_name,
            translate: translate.map(rounded),
            scale,
            ..ObjectDesc::new(shape)
        };
        desc.objects.push(object);
        let target = Target::Object(desc.objects.len() - 1);
        let touched = std::iter::once(target).chain(material.map(Target::Material)).collect();
        Ok((target, touched))
    })
}

/// A round length that fills [`FILL`] of the picture's height at this distance.
fn size_in_view(desc: &SceneDesc, distance: f64) -> f64 {
    let height = match desc.camera.projection {
        Projection::Perspective { fov } => 2.0 * distance * (fov.to_radians() / 2.0).tan(),
        Projection::Orthographic { view_height } => view_height,
    };
    rounded((FILL * height).clamp(1e-9, 1e9))
}

/// To two digits: numbers that people like to see in a file.
fn rounded(v: f64) -> f64 {
    format!("{v:.1e}").parse().unwrap_or(v)
}

fn add_light(desc: &mut SceneDesc, stem: &str, kind: LightKind) -> (Target, Vec<Target>) {
    let name = free_name(stem, |name| desc.lights.iter().any(|light| light.name == name));
    desc.lights.push(LightDesc { name, kind, intensity: 0.5, ..LightDesc::default() });
    let target = Target::Light(desc.lights.len() - 1);
    (target, vec![target])
}

/// Above the eye and to its right, a little nearer.
fn lamp(desc: &SceneDesc, middle: DVec3, distance: f64) -> LightKind {
    let position = middle + toward_light(desc) * distance;
    LightKind::Point { position: position.map(rounded), falloff: Falloff::None }
}

fn sun(desc: &SceneDesc) -> LightKind {
    LightKind::Directional { direction: (-toward_light(desc)).map(|v| without_noise((v * 100.0).round() / 100.0)) }
}

fn toward_light(desc: &SceneDesc) -> DVec3 {
    let [right, up, forward] = [Axis::Right, Axis::Up, Axis::Forward].map(|axis| axis.direction(&desc.camera));
    (right * 0.5 + up * 0.8 - forward * 0.7).normalize_or(DVec3::Y)
}

/// A material of the next colour; returns its index.
fn add_material(desc: &mut SceneDesc, stem: &str) -> usize {
    let color = parse_color(COLORS[desc.materials.len() % COLORS.len()]).unwrap_or(Rgb::WHITE);
    let name = free_name(stem, |name| desc.materials.iter().any(|material| material.name == name));
    desc.materials.push(MaterialDesc { name, color, ..MaterialDesc::default() });
    desc.materials.len() - 1
}
