//! Description to scene.

use super::leaf::Leaf;
use super::object::canonical_scale;
use super::texture::Source;
use super::{
    Assets, Camera, Geometry, Imported, Light, Material, MediumStack, Mesh, Object, ObjectMaterial, Scene, Shape,
    Summary, Texture,
};
use crate::assets::{AssetError, Model, load_images, load_obj};
use crate::bvh::{Bvh, Isa};
use crate::description::{
    MaterialDesc, ObjectDesc, SceneDesc, ShapeDesc, Target, TextureDesc, TextureSource, builtin, printable,
};
use crate::geometry::Aabb;
use crate::math::Affine;
use glam::{DAffine3, DVec3};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::fmt;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Why a description cannot be compiled.
#[derive(Clone, Debug, PartialEq)]
pub enum CompileError {
    /// The camera has no view: position and target coincide, or `up` is parallel to the view.
    Camera,
    /// The transform of an object flattens it to nothing, or nearly.
    Singular {
        /// Which object.
        object: Part,
    },
    /// An object refers to a material that does not exist.
    UnknownMaterial {
        /// Which object.
        object: Part,
        /// The name it gives.
        material: String,
    },
    /// A model or picture cannot be used.
    Asset {
        /// What needs it.
        user: Part,
        /// The file's own error.
        error: AssetError,
    },
}

/// A part of the scene that cannot be compiled.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its entry in the description.
    pub entry: Target,
    /// Its name, for people: `object "ball"`.
    pub label: String,
}

impl CompileError {
    /// The entry of the description that cannot be compiled, and the keys of it that may be the reason, the likeliest
    /// first.
    pub fn place(&self) -> (Target, &'static [&'static str]) {
        match self {
            Self::Camera => (Target::Camera, &["look_at", "position", "up"]),
            Self::Singular { object } => (object.entry, &["scale", "size", "radius", "height", "data", "file"]),
            Self::UnknownMaterial { object, .. } => (object.entry, &["material"]),
            Self::Asset { user, .. } => (user.entry, &["file", "texture"]),
        }
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&printable(&self.label))
    }
}

impl fmt::Display for CompileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Camera => f.write_str(
                "the camera has no view: look_at must differ from position, and up must not be parallel to the view",
            ),
            Self::Singular { object } => write!(
                f,
                "{object}: the transform flattens it to nothing; give scale and size values that differ less and \
                 are not 0",
            ),
            Self::UnknownMaterial { object, material } => {
                write!(f, "{object}: there is no material named \"{}\"", printable(material))
            }
            Self::Asset { user, error } => write!(f, "{error} (needed by {user})"),
        }
    }
}

impl std::error::Error for CompileError {}

/// [`compile_for`] the instruction set that is the best here.
pub fn compile(desc: &SceneDesc, previous: Option<&Scene>) -> Result<Scene, CompileError> {
    compile_for(desc, previous, Isa::best())
}

/// Compiles a description for an instruction set that this processor has, sharing with `previous` every mesh, picture
/// and tree whose inputs are equal: editing a camera, a light or a material rebuilds nothing, moving an object only the
/// tree over the objects. Nothing is shared with a scene compiled for another instruction set.
///
/// # Panics
/// If the processor does not have `isa`.
pub fn compile_for(desc: &SceneDesc, previous: Option<&Scene>, isa: Isa) -> Result<Scene, CompileError> {
    compile_with(desc, previous, &[], isa)
}

/// [`compile_for`] the same instruction set after these files have `changed` on the disk: what was made of them is read
/// again, and nothing else. If that fails, they still count as changed the next time.
pub fn recompile(desc: &SceneDesc, previous: &Scene, changed: &[PathBuf]) -> Result<Scene, CompileError> {
    compile_with(desc, Some(previous), changed, previous.isa())
}

fn compile_with(
    desc: &SceneDesc,
    previous: Option<&Scene>,
    changed: &[PathBuf],
    isa: Isa,
) -> Result<Scene, CompileError> {
    let previous = previous.filter(|p| p.isa() == isa);
    let (width, height) = (desc.film.width, desc.film.height);
    let camera = Camera::new(&desc.camera, width, height).ok_or(CompileError::Camera)?;
    let start = Instant::now();
    let assets = load_assets(desc, previous.map(|p| p.assets.without(changed)), isa)?;
    let load_time = start.elapsed().saturating_sub(assets.build_time);
    let start = Instant::now();
    let geometry = match previous {
        Some(p) if same_places(&p.geometry.sources, &desc.objects) && p.geometry.is_made_of(&assets.assets) => {
            p.geometry.clone()
        }
        _ => Arc::new(Geometry::build(&desc.objects, &assets, previous.map(|p| &*p.geometry), isa)?),
    };
    let build_time = start.elapsed() + assets.build_time;
    let assets = assets.assets;
    let (materials, object_materials) = compile_materials(desc, &assets)?;
    let mut scene = Scene {
        width,
        height,
        render: desc.render,
        camera,
        world: desc.world,
        lights: desc.lights.iter().filter(|light| light.visible).map(Light::new).collect(),
        has_media: materials.iter().any(|m| m.transmit > 0.0),
        materials,
        described_materials: desc.materials.len(),
        largest_radiance: None,
        least_weight: 0.0,
        spare_light: 0.0,
        summary: Summary { load_time, build_time, ..Summary::default() },
        geometry,
        object_materials,
        assets,
        eye_media: MediumStack::default(),
        transmitting: Vec::new(),
    };
    if scene.has_media {
        let objects = 0..scene.objects().len() as u32;
        scene.transmitting = objects.map(|object| scene.transmits(object)).collect();
        scene.geometry.clearances(); // Now, so that no worker waits for another that computes them.
        scene.eye_media = scene.media_at(camera.position());
    }
    scene.largest_radiance = scene.bound_radiance();
    scene.least_weight = scene.bound_weight();
    scene.spare_light = scene.bound_spare_light();
    scene.describe(desc);
    Ok(scene)
}

/// An empty scene that lends this mesh to scenes compiled after it, as if it had been read from `file`: how models come
/// in that are in no file.
pub fn lender(file: &Path, crease: f64, model: Model) -> Result<Scene, CompileError> {
    let mut scene = compile(&SceneDesc::default(), None)?;
    let mesh = Arc::new(Mesh::new(model, Isa::best(), threads()));
    scene.assets.meshes.insert((file.to_path_buf(), crease.to_bits()), mesh);
    Ok(scene)
}

/// Assets with the time that went into trees while loading them.
struct Loaded {
    assets: Assets,
    build_time: Duration,
}

/// Models one after the other, each by all threads, for they may be large; then all pictures at once.
fn load_assets(desc: &SceneDesc, previous: Option<Assets>, isa: Isa) -> Result<Loaded, CompileError> {
    let mut assets = Assets::default();
    let mut build_time = Duration::ZERO;
    for (index, object) in desc.objects.iter().enumerate() {
        let ShapeDesc::Mesh { file, crease } = &object.shape else { continue };
        let key = (file.clone(), crease.to_bits());
        if assets.meshes.contains_key(&key) {
            continue;
        }
        let mesh = match previous.as_ref().and_then(|p| p.meshes.get(&key)) {
            Some(mesh) => mesh.clone(),
            None => {
                let model = load_obj(file, *crease, threads())
                    .map_err(|error| CompileError::Asset { user: part(index, &object.name), error })?;
                let start = Instant::now();
                let mesh = Arc::new(Mesh::new(model, isa, threads()));
                build_time += start.elapsed();
                mesh
            }
        };
        assets.meshes.insert(key, mesh);
    }
    let described = desc.materials.iter().enumerate().map(|(index, m)| {
        let label = format!("material \"{}\"", m.name);
        (m, Part { entry: Target::Material(index), label })
    });
    let of_meshes = assets.meshes.iter().flat_map(|((file, _), mesh)| {
        let uses = |o: &ObjectDesc| matches!(&o.shape, ShapeDesc::Mesh { file: used, .. } if used == file);
        let entry = Target::Object(desc.objects.iter().position(uses).unwrap_or_default());
        mesh.materials.iter().map(move |m| {
            let label = format!("material \"{}\" of {}", m.name, file.display());
            (m, Part { entry, label })
        })
    });
    let (mut seen, mut missing) = (HashSet::new(), Vec::new());
    for (material, user) in described.chain(of_meshes) {
        let Some(TextureDesc { source: TextureSource::Image { file, .. }, .. }) = &material.texture else { continue };
        if let Some(image) = previous.as_ref().and_then(|p| p.images.get(file)) {
            assets.images.insert(file.clone(), image.clone());
        } else if seen.insert(file) {
            missing.push((file, user));
        }
    }
    let files: Vec<&Path> = missing.iter().map(|(file, _)| file.as_path()).collect();
    for ((file, user), image) in missing.into_iter().zip(load_images(&files, threads())) {
        let image = image.map_err(|error| CompileError::Asset { user, error })?;
        assets.images.insert(file.clone(), Arc::new(image));
    }
    Ok(Loaded { assets, build_time })
}

/// Scene materials: the described ones, then the default one, then those of the models.
fn compile_materials(desc: &SceneDesc, assets: &Assets) -> Result<(Vec<Material>, Vec<ObjectMaterial>), CompileError> {
    let material = |m: &MaterialDesc| Material::new(m, m.texture.as_ref().map(|t| compile_texture(t, assets)));
    let mut materials: Vec<Material> = desc.materials.iter().map(material).collect();
    let names: HashMap<&str, u32> = desc.materials.iter().zip(0..).map(|(m, i)| (m.name.as_str(), i)).collect();
    let default = materials.len() as u32;
    materials.push(material(&MaterialDesc::default()));
    let mut of_meshes: HashMap<(&PathBuf, u64), u32> = HashMap::new();
    let mut object_materials = Vec::with_capacity(desc.objects.len());
    for (index, object) in desc.objects.iter().enumerate() {
        let chosen = match (&object.material, &object.shape) {
            (Some(name), _) => match names.get(name.as_str()) {
                Some(&at) => ObjectMaterial::One(at),
                None => {
                    let object = part(index, &object.name);
                    return Err(CompileError::UnknownMaterial { object, material: name.clone() });
                }
            },
            (None, ShapeDesc::Mesh { file, crease }) => {
                let own = &assets.meshes[&(file.clone(), crease.to_bits())].materials;
                if own.is_empty() {
                    ObjectMaterial::One(default)
                } else {
                    let first = *of_meshes.entry((file, crease.to_bits())).or_insert_with(|| {
                        let first = materials.len() as u32;
                        materials.extend(own.iter().map(material));
                        first
                    });
                    ObjectMaterial::PerTriangle(first)
                }
            }
            (None, _) => ObjectMaterial::One(default),
        };
        object_materials.push(chosen);
    }
    Ok((materials, object_materials))
}

fn compile_texture(desc: &TextureDesc, assets: &Assets) -> Texture {
    let source = match &desc.source {
        TextureSource::Image { file, wrap } => Source::Image(assets.images[file].clone(), *wrap),
        TextureSource::Checker { colors, size } => Source::Checker { colors: *colors, size: *size },
    };
    Texture { source, scale: desc.scale, offset: desc.offset }
}

impl Assets {
    /// Those that none of these files is part of.
    fn without(&self, files: &[PathBuf]) -> Self {
        let mut kept = self.clone();
        if !files.is_empty() {
            kept.meshes.retain(|(file, _), mesh| {
                !files.contains(file) && !mesh.libraries.iter().any(|library| files.contains(library))
            });
            kept.images.retain(|file, _| !files.contains(file));
        }
        kept
    }
}

impl Geometry {
    /// Whether its meshes are these.
    fn is_made_of(&self, assets: &Assets) -> bool {
        self.objects.iter().all(|object| match &object.shape {
            Shape::Mesh(mesh) => assets.meshes.values().any(|known| Arc::ptr_eq(known, mesh)),
            _ => true,
        })
    }

    /// Places all objects and builds the tree over them. Those that stand where they stood in `previous` are not placed
    /// again: of 7,381 balls that took longer than the tree. The tree is always built anew, so that it does not depend
    /// on the edits that led here.
    fn build(sources: &[ObjectDesc], loaded: &Loaded, previous: Option<&Self>, isa: Isa) -> Result<Self, CompileError> {
        let mut objects = Vec::with_capacity(previous.map_or(sources.len(), |p| p.objects.len()));
        for (index, source) in sources.iter().enumerate().filter(|(_, source)| source.visible) {
            if let Some(placed) = previous.and_then(|p| p.placed(index, source)) {
                objects.extend_from_slice(placed);
                continue;
            }
            place(source, index, &loaded.assets, &mut objects)
                .ok_or_else(|| CompileError::Singular { object: part(index, &source.name) })?;
        }
        let (mut boxes, mut of_box, mut unbounded) = (Vec::new(), Vec::new(), Vec::new());
        for (index, object) in (0u32..).zip(&objects) {
            match (object.bounds(), &object.shape) {
                (Some(bounds), _) => {
                    boxes.push(bounds);
                    of_box.push(index);
                }
                (None, Shape::Plane) => unbounded.push(index),
                (None, _) => {} // A mesh without triangles.
            }
        }
        let (tree, slots) = Bvh::build(boxes.len(), |i| boxes[i], 1, isa, threads());
        let leaf = |index: u32| Leaf::new(index, &objects[index as usize]);
        let leaves = slots.iter().map(|&at| leaf(of_box[at as usize])).collect();
        let spheres = objects.iter().map(Object::bounding_sphere).collect();
        let stats = tree.stats();
        Ok(Self {
            sources: sources.to_vec(),
            objects,
            tree,
            stats,
            leaves,
            unbounded,
            spheres,
            clearances: OnceLock::new(),
        })
    }

    /// What the description with this index has become here, if it is the same one. Not of meshes: they may be others
    /// now.
    fn placed(&self, index: usize, source: &ObjectDesc) -> Option<&[Object]> {
        let here = self.sources.get(index).filter(|here| is_in_place(here, source))?;
        let is_mesh = matches!(here.shape, ShapeDesc::Mesh { .. });
        let start = self.objects.partition_point(|object| (object.source as usize) < index);
        let count = self.objects[start..].partition_point(|object| object.source as usize == index);
        (!is_mesh).then(|| &self.objects[start..start + count])
    }
}

/// Puts the objects that a description stands for into `objects`; `None` if a transform is singular or not finite.
fn place(source: &ObjectDesc, index: usize, assets: &Assets, objects: &mut Vec<Object>) -> Option<()> {
    let map = Affine::from_scale_rotate_translate(source.scale, source.rotate, source.translate)?;
    let scaled = |centre: DVec3, scale: DVec3| {
        Affine::new(map.forward * DAffine3::from_translation(centre) * DAffine3::from_scale(scale))
    };
    let sphere = |map: Affine| match map.uniform_scale() {
        Some(radius) => Object::new(Shape::Ball { centre: map.forward.translation, radius }, map, index as u32),
        None => Object::new(Shape::Ellipsoid, map, index as u32),
    };
    let shape = match &source.shape {
        ShapeDesc::Sphere { radius } => {
            objects.push(sphere(scaled(DVec3::ZERO, DVec3::splat(*radius))?));
            return Some(());
        }
        ShapeDesc::Spheres { data } => {
            for &[x, y, z, radius] in data.iter() {
                objects.push(sphere(scaled(DVec3::new(x, y, z), DVec3::splat(radius))?));
            }
            return Some(());
        }
        ShapeDesc::Cuboid { .. } => Shape::Cuboid,
        ShapeDesc::Cylinder { .. } => Shape::Cylinder,
        ShapeDesc::Cone { .. } => Shape::Cone,
        ShapeDesc::Plane => Shape::Plane,
        ShapeDesc::Quad { .. } => Shape::Quad,
        ShapeDesc::Mesh { file, crease } => {
            let mesh = assets.meshes[&(file.clone(), crease.to_bits())].clone();
            let map = scaled(mesh.centre, DVec3::ONE)?;
            objects.push(Object::new(Shape::Mesh(mesh), map, index as u32));
            return Some(());
        }
    };
    objects.push(Object::new(shape, scaled(DVec3::ZERO, canonical_scale(&source.shape))?, index as u32));
    Some(())
}

/// Threads for building trees.
fn threads() -> NonZeroUsize {
    std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN)
}

fn same_places(a: &[ObjectDesc], b: &[ObjectDesc]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_in_place(a, b))
}

/// Whether two objects are equal but for name and material.
fn is_in_place(a: &ObjectDesc, b: &ObjectDesc) -> bool {
    let place = |o: &ObjectDesc| (o.translate, o.rotate, o.scale, o.visible);
    place(a) == place(b) && a.shape == b.shape
}

/// The object with this index: `object "ball"` or `object 3`.
fn part(index: usize, name: &str) -> Part {
    let label = if name.is_empty() { format!("object {}", index + 1) } else { format!("object \"{name}\"") };
    Part { entry: Target::Object(index), label }
}

impl Scene {
    /// The models, material libraries and pictures that it was made of.
    pub fn files(&self) -> BTreeSet<PathBuf> {
        let Assets { meshes, images } = &self.assets;
        let models = meshes.iter().flat_map(|((file, _), mesh)| mesh.libraries.iter().chain([file]));
        models.chain(images.keys()).filter(|file| builtin(file).is_none()).cloned().collect()
    }

    /// The box in world space of an object as it is described, which may be another place than it has here, with the
    /// models of this scene; `None` if it has no end, or its model is not known here.
    pub fn bounds_of(&self, object: &ObjectDesc) -> Option<Aabb> {
        if let ShapeDesc::Mesh { file, crease } = &object.shape
            && !self.assets.meshes.contains_key(&(file.clone(), crease.to_bits()))
        {
            return None;
        }
        let mut placed = Vec::new();
        place(object, 0, &self.assets, &mut placed)?;
        let boxes = placed.iter().map(Object::bounds).collect::<Option<Vec<_>>>()?;
        boxes.into_iter().reduce(Aabb::union)
    }

    /// Fills in the summary.
    fn describe(&mut self, desc: &SceneDesc) {
        let geometry = &self.geometry;
        let mesh_len = |o: &Object| if let Shape::Mesh(mesh) = &o.shape { mesh.len() } else { 0 };
        let meshes = self.assets.meshes.iter();
        let s = &mut self.summary;
        s.objects = desc.objects.len();
        s.primitives = geometry.objects.iter().filter(|o| !matches!(o.shape, Shape::Mesh(_))).count();
        s.triangles = meshes.clone().map(|(_, m)| m.len()).sum();
        s.instanced_triangles = geometry.objects.iter().map(mesh_len).sum();
        s.lights = desc.lights.len();
        s.materials = desc.materials.len();
        s.textures = self.assets.images.len();
        s.tree = geometry.stats;
        s.imports = meshes
            .map(|((path, _), mesh)| Imported { file: path.clone(), report: mesh.report.clone(), tree: mesh.stats() })
            .collect();
        s.warnings = warnings(desc);
        for Imported { file, report, .. } in &s.imports {
            s.warnings.extend(report.notes.iter().map(|note| format!("{}: {note}", file.display())));
        }
        // A model that is used with two crease angles was imported twice.
        let mut told = HashSet::new();
        s.warnings.retain(|warning| told.insert(warning.clone()));
    }
}

/// Things that are probably not meant.
fn warnings(desc: &SceneDesc) -> Vec<String> {
    let mut list = Vec::new();
    if desc.objects.is_empty() {
        list.push("the scene has no objects: only the background will be seen".to_string());
    }
    if desc.lights.is_empty() {
        list.push(
            "the scene has no lights: only ambient light, reflections and the background will be seen".to_string(),
        );
    }
    let used: HashSet<&str> = desc.objects.iter().filter_map(|o| o.material.as_deref()).collect();
    for material in &desc.materials {
        let name = printable(&material.name);
        if !used.contains(material.name.as_str()) {
            list.push(format!("material \"{name}\" is used by no object"));
        }
        if material.reflect + material.transmit > 1.0 {
            list.push(format!(
                "material \"{name}\" gives back more light than it gets: reflect + transmit is {:.3}, above 1",
                material.reflect + material.transmit
            ));
        }
    }
    list
}
