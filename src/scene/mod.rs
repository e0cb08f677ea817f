//! What rays meet: indices, boxes and trees, compiled from a description.

mod body;
mod bound;
mod camera;
mod clearance;
mod color;
mod compile;
mod crowd;
mod front;
mod leaf;
mod leaving;
mod light;
mod material;
mod media;
mod mesh;
mod object;
mod packet;
mod pick;
mod shell;
mod summary;
mod surface;
mod surfaces;
mod texture;
mod through;
mod traverse;
mod visits;

pub use camera::Camera;
pub use color::ColorRoom;
pub use compile::{CompileError, Part, compile, compile_for, lender, recompile};
pub use light::{Illumination, Light};
pub use material::Material;
pub use media::{Inside, MOST_BODIES, MediumStack};
pub use mesh::Mesh;
pub use object::{Object, Shape};
pub use packet::{PacketScratch, Way};
pub use pick::Pick;
pub use shell::Shell;
pub use summary::{Imported, Summary};
pub use surface::Facet;
pub use surfaces::{SLOTS, SurfaceRows, Surfaces};
pub use texture::Texture;

use crate::assets::Image;
use crate::bvh::{Bvh, BvhStats, Isa, Task};
use crate::description::{Background, ObjectDesc, RenderDesc, WorldDesc};
use crate::math::Rgb;
use clearance::Clearance;
use glam::DVec3;
use leaf::Leaf;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// A compiled scene: immutable, shared by all workers. Parts that cost time to make are shared with the scenes compiled
/// before and after it.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Picture size in pixels.
    pub width: u32,
    /// Picture size in pixels.
    pub height: u32,
    /// How the picture is computed.
    pub render: RenderDesc,
    /// Makes the primary rays.
    pub camera: Camera,
    /// Ambient light, background, refractive index.
    pub world: WorldDesc,
    /// Light sources.
    pub lights: Vec<Light>,
    /// Optical properties, by index: those of the description first, then the default one, then those of models.
    pub materials: Vec<Material>,
    /// How many of the materials are those of the description.
    described_materials: usize,
    /// What compiling found and took.
    pub summary: Summary,
    /// No ray sees more than this in any channel; `None` if the scene sets no such limit.
    pub largest_radiance: Option<f64>,
    /// Paths of less weight than this are not followed (Hall and Greenberg 1983).
    pub least_weight: f64,
    /// Radiance of a sample that may hang on shadow rays which are not traced; none without an error to reach.
    pub spare_light: f64,
    geometry: Arc<Geometry>,
    /// Material of each `[[object]]`.
    object_materials: Vec<ObjectMaterial>,
    assets: Assets,
    /// Media around the eye of a perspective camera.
    eye_media: MediumStack,
    has_media: bool,
    /// Whether light may get through an object somewhere, for each; empty if it does through none.
    transmitting: Vec<bool>,
}

/// The objects and the tree over them: what only moving, adding or removing objects changes.
#[derive(Debug)]
struct Geometry {
    /// What it was made from.
    sources: Vec<ObjectDesc>,
    objects: Vec<Object>,
    /// Objects with a box, in leaf order.
    tree: Bvh,
    stats: BvhStats,
    /// What is at each position of the tree.
    leaves: Vec<Leaf>,
    /// Planes.
    unbounded: Vec<u32>,
    /// What is free around each object, where that matters.
    clearances: OnceLock<Vec<Clearance>>,
    /// Centre and radius of a sphere around each object; infinite for planes.
    spheres: Vec<(DVec3, f64)>,
}

/// Where an object's material stands in [`Scene::materials`].
#[derive(Clone, Copy, Debug)]
enum ObjectMaterial {
    One(u32),
    /// A mesh with its file's own materials, from this index on.
    PerTriangle(u32),
}

/// Models and pictures, by path.
#[derive(Clone, Debug, Default)]
struct Assets {
    /// With the crease angle in bits, since it shapes the normals.
    meshes: BTreeMap<(PathBuf, u64), Arc<Mesh>>,
    images: BTreeMap<PathBuf, Arc<Image>>,
}

impl Scene {
    /// What a ray in this unit direction sees that meets nothing.
    pub fn background(&self, direction: DVec3) -> Rgb {
        match self.world.background {
            Background::Solid(color) => color,
            Background::Gradient { top, bottom } => bottom.lerp(top, 0.5 + 0.5 * direction.y),
        }
    }

    /// The compiled objects; [`Hit::object`](crate::geometry::Hit) is an index into them.
    pub fn objects(&self) -> &[Object] {
        &self.geometry.objects
    }

    /// Does a task with the instruction set that rays are traced with.
    pub fn run<T: Task>(&self, task: T, input: &T::Input, output: &mut T::Output) {
        self.geometry.tree.run(task, input, output);
    }

    /// The instruction set that rays are traced with.
    pub fn isa(&self) -> Isa {
        self.geometry.tree.isa()
    }

    /// Index of the material that a hit meets.
    pub fn material_of(&self, object: u32, primitive: u32) -> u32 {
        let object = &self.geometry.objects[object as usize];
        match (self.object_materials[object.source as usize], &object.shape) {
            (ObjectMaterial::One(index), _) => index,
            (ObjectMaterial::PerTriangle(first), Shape::Mesh(mesh)) => first + mesh.material_of(primitive),
            (ObjectMaterial::PerTriangle(first), _) => first,
        }
    }

    /// The same, if the object is of one material.
    fn only_material_of(&self, object: u32) -> Option<u32> {
        match self.object_materials[self.geometry.objects[object as usize].source as usize] {
            ObjectMaterial::One(index) => Some(index),
            ObjectMaterial::PerTriangle(_) => None,
        }
    }

    /// Whether light may get through an object somewhere.
    fn may_transmit(&self, object: u32) -> bool {
        self.transmitting.get(object as usize).is_some_and(|transmitting| *transmitting)
    }

    /// The k_t of an object that is of one material.
    fn transmit_of(&self, object: u32) -> f64 {
        self.materials[self.material_of(object, 0) as usize].transmit
    }

    /// Finds it out.
    fn transmits(&self, object: u32) -> bool {
        let object = &self.geometry.objects[object as usize];
        let transmits = |index: u32| self.materials[index as usize].transmit > 0.0;
        match (self.object_materials[object.source as usize], &object.shape) {
            (ObjectMaterial::One(index), _) => transmits(index),
            (ObjectMaterial::PerTriangle(first), Shape::Mesh(mesh)) => {
                (first..first + mesh.materials.len() as u32).any(transmits)
            }
            (ObjectMaterial::PerTriangle(first), _) => transmits(first),
        }
    }

    /// Whether any object lets light through, so that rays must keep track of media.
    pub fn has_media(&self) -> bool {
        self.has_media
    }

    /// The media around the start of a primary ray.
    pub fn media_at_start(&self, origin: DVec3) -> MediumStack {
        if !self.has_media {
            MediumStack::default()
        } else if self.camera.has_one_eye() {
            self.eye_media
        } else {
            self.media_at(origin)
        }
    }
}
