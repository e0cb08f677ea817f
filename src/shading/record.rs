//! Who listens while rays are traced.

use super::media::Media;
use super::packet::{Level, Lighting};
use super::ray_tree::{Branch, Coefficients, Cut, End, LightTerm, Medium, Passed, RayKind, RayTree, SurfaceTerms};
use super::sampler::terms;
use crate::bvh::TreeKernels;
use crate::description::{SceneDesc, Target};
use crate::geometry::{Hit, SurfaceInteraction};
use crate::math::{Rgb, STEEPEST};
use crate::scene::{MediumStack, Scene, Shape};

/// Hears what the tracer does, in its order. `()` hears nothing and costs nothing: the tracer is compiled for each
/// recorder.
pub(super) trait Recorder {
    /// Whether it hears anything.
    const LISTENS: bool = true;

    /// A packet is about to be traced.
    fn begin<K: TreeKernels>(&mut self, _scene: &Scene, _kind: RayKind, _level: &Level, _media: &Media) {}
    /// A surface is passed that changes nothing.
    fn pass(&mut self, _scene: &Scene, _hit: &Hit) {}
    /// A ray ends on a surface of this colour; `ambient` is the first of its terms, `beyond` what light comes to behind
    /// it.
    fn meet(&mut self, _: &Scene, _: &SurfaceInteraction, _color: Rgb, _ambient: Rgb, _beyond: Option<&MediumStack>) {}
    /// How much of a light arrives is known.
    fn light<K: TreeKernels, const TERMS: u8>(&mut self, _scene: &Scene, _light: usize, _lighting: &Lighting) {}
    /// Rays are not followed.
    fn cut(&mut self, _cut: Cut) {}
    /// The packet that was begun last has come to its end.
    fn end(&mut self, _level: &Level) {}
}

impl Recorder for () {
    const LISTENS: bool = false;
}

/// Writes down the ray tree of a packet of one ray.
pub(super) struct TreeRecorder<'a> {
    /// What the scene was compiled from, if names are wanted.
    desc: Option<&'a SceneDesc>,
    /// From the eye to the ray that is being traced.
    open: Vec<RayTree>,
    whole: Option<RayTree>,
}

impl<'a> TreeRecorder<'a> {
    pub fn new(desc: &'a SceneDesc) -> Self {
        Self { desc: Some(desc), open: Vec::new(), whole: None }
    }

    /// One that leaves all names empty.
    pub fn without_names() -> Self {
        Self { desc: None, open: Vec::new(), whole: None }
    }

    /// The tree, when tracing is over.
    pub fn finish(&mut self) -> Option<RayTree> {
        self.whole.take()
    }

    fn surface(&mut self) -> Option<&mut SurfaceTerms> {
        match self.open.last_mut().map(|ray| &mut ray.end) {
            Some(End::Surface(surface)) => Some(surface),
            _ => None,
        }
    }

    fn object(&self, scene: &Scene, object: u32) -> String {
        let target = Target::Object(scene.objects()[object as usize].source as usize);
        self.desc.map_or(String::new(), |desc| target.label(desc))
    }

    fn medium(&self, scene: &Scene, media: Option<&MediumStack>) -> Medium {
        let object = media.and_then(|media| media.filling(scene)).map(|object| self.object(scene, object));
        Medium { object, ior: media.map_or(scene.world.ior, |media| media.ior(scene)) }
    }

    /// Name of the `[[material]]` or of the one in the model's file.
    fn material(&self, scene: &Scene, hit: &Hit) -> String {
        let Some(desc) = self.desc else { return String::new() };
        let object = &scene.objects()[hit.object as usize];
        let of_file = match &object.shape {
            Shape::Mesh(mesh) => mesh.materials.get(mesh.material_of(hit.primitive) as usize),
            _ => None,
        };
        let named = desc.objects.get(object.source as usize).and_then(|object| object.material.as_deref());
        let name = named.or(of_file.map(|material| material.name.as_str())).unwrap_or("the default");
        crate::description::printable(name).into_owned()
    }
}

impl Recorder for TreeRecorder<'_> {
    fn begin<K: TreeKernels>(&mut self, scene: &Scene, kind: RayKind, level: &Level, media: &Media) {
        let [path] = &*level.paths else { return };
        let ray = level.rays.ray(0);
        self.open.push(RayTree {
            kind,
            origin: ray.origin.to_array(),
            direction: ray.direction.to_array(),
            share: path.share,
            weight: path.weight,
            medium: self.medium(scene, media.get(path.media)),
            visits: scene.visits::<K>(&ray, false),
            passed: Vec::new(),
            end: End::Background,
            radiance: Rgb::BLACK,
        });
    }

    fn pass(&mut self, scene: &Scene, hit: &Hit) {
        let passed = Passed { object: self.object(scene, hit.object), t: hit.t };
        if let Some(ray) = self.open.last_mut() {
            ray.passed.push(passed);
        }
    }

    fn meet(
        &mut self,
        scene: &Scene,
        interaction: &SurfaceInteraction,
        color: Rgb,
        ambient: Rgb,
        beyond: Option<&MediumStack>,
    ) {
        let hit = &interaction.hit;
        let material = &scene.materials[interaction.material as usize];
        let side = if interaction.entering { 1.0 } else { -1.0 };
        let surface = SurfaceTerms {
            object: self.object(scene, hit.object),
            primitive: hit.primitive,
            t: hit.t,
            error: interaction.point_error,
            point: interaction.point.to_array(),
            normal: (interaction.shading_normal * side).to_array(),
            entering: interaction.entering,
            beyond: beyond.map(|media| self.medium(scene, Some(media))),
            material: self.material(scene, hit),
            coefficients: Coefficients {
                k_a: material.ambient,
                k_d: material.diffuse,
                k_s: material.specular,
                shininess: material.shininess,
                k_r: material.reflect,
                k_t: material.transmit,
                ior: material.ior,
            },
            color,
            ambient,
            lights: Vec::new(),
            branches: Vec::new(),
        };
        if let Some(ray) = self.open.last_mut() {
            ray.end = End::Surface(Box::new(surface));
        }
    }

    fn light<K: TreeKernels, const TERMS: u8>(&mut self, scene: &Scene, light: usize, lighting: &Lighting) {
        let Lighting { lit, beams, asked, unasked, .. } = lighting;
        // A surface on which no light can fall has no such terms.
        if lit.count == 0 || !lit.get(0).responds::<TERMS>() {
            return;
        }
        let name = self.desc.map_or(String::new(), |desc| {
            let shining = (0..desc.lights.len()).filter(|light| desc.lights[*light].visible).nth(light);
            Target::Light(shining.unwrap_or(light)).label(desc)
        });
        let doubt = unasked.first().map(|(_, doubt)| *doubt);
        let beam = (doubt.is_some() || !asked.is_empty()).then(|| beams.get(0));
        let shadow_ray = (TERMS & terms::SHADOWS != 0 && !asked.is_empty()).then(|| beams.shadow_rays.ray(0));
        let blocked = shadow_ray.filter(|_| beam.is_some_and(|beam| beam.part < 1.0));
        let blocker = blocked.and_then(|ray| scene.intersect::<K>(&ray));
        let shadow_of = blocker.map(|hit| self.object(scene, hit.object));
        let (surface, mut terms) = (lit.get(0), [Rgb::BLACK; 3]);
        if let Some(beam) = beam.filter(|beam| beam.part != 0.0) {
            let specular = if surface.shines::<TERMS>() { surface.highlight::<K>(&beam) } else { 0.0 };
            let arriving = |factor: Rgb| beam.radiance * factor * beam.part;
            terms =
                [arriving(surface.diffuse(&beam)), arriving(Rgb::grey(specular)), surface.response::<K, TERMS>(&beam)];
        }
        let [diffuse, specular, sum] = terms;
        let term = LightTerm {
            light: name,
            behind: beam.is_none(),
            part: beam.map_or(0.0, |beam| beam.part),
            unasked: doubt.map(|doubt| doubt * STEEPEST),
            shadow_of,
            cosine: beam.map_or(0.0, |beam| beam.cosine),
            diffuse,
            specular,
            sum,
            visits: shadow_ray.map_or(0, |ray| scene.visits::<K>(&ray, true)),
        };
        if let Some(surface) = self.surface() {
            surface.lights.push(term);
        }
    }

    fn cut(&mut self, cut: Cut) {
        if let Some(surface) = self.surface().filter(|_| cut.weight > 0.0) {
            surface.branches.push(Branch::Cut(cut));
        }
    }

    fn end(&mut self, level: &Level) {
        if level.rays.len() != 1 {
            return;
        }
        let Some(mut ray) = self.open.pop() else { return };
        ray.radiance = level.sums[0];
        match self.surface() {
            Some(surface) => surface.branches.push(Branch::Ray(Box::new(ray))),
            None => self.whole = Some(ray),
        }
    }
}
