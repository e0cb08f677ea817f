//! Who listens while rays are traced.

use super::packet::{Level, Lighting};
use super::ray_tree::{Branch, Coefficients, Cut, End, LightTerm, Medium, Passed, RayKind, RayTree, SurfaceTerms};
use super::sampler::terms;
use crate::bvh::TreeKernels;
use crate::description::{SceneDesc, Target};
use crate::geometry::{Hit, SurfaceInteraction};
use crate::math::{Rgb, STEEPEST};
use crate::scene::{MediumStack, Scene, Shape, SurfaceRows};

/// Hears what the tracer does, in its order. `()` hears nothing and costs nothing: the tracer is compiled for each
/// recorder.
pub(super) trait Recorder {
    /// Whether it hears anything.
    const LISTENS: bool = true;

    /// A packet is about to be traced.
    fn begin<K: TreeKernels>(&mut self, _scene: &Scene, _level: &Level) {}
    /// A ray of it passes a surface that changes nothing.
    fn pass(&mut self, _scene: &Scene, _ray: usize, _hit: &Hit) {}
    /// A ray ends on a surface.
    fn meet(&mut self, _scene: &Scene, _ray: usize, _end: SurfaceEnd) {}
    /// How much of a light arrives is known.
    fn light<K: TreeKernels, const TERMS: u8>(
        &mut self,
        _scene: &Scene,
        _light: usize,
        _lighting: &Lighting,
        _rows: &SurfaceRows,
    ) {
    }
    /// Rays from where a ray ends are not followed.
    fn cut(&mut self, _ray: usize, _cut: Cut) {}
    /// The packet that was begun last has come to its end.
    fn end(&mut self, _level: &Level) {}
}

/// Where a ray ends.
pub(super) struct SurfaceEnd<'a> {
    pub interaction: SurfaceInteraction,
    /// C
    pub color: Rgb,
    /// The first of its terms.
    pub ambient: Rgb,
    /// What light comes to behind it.
    pub beyond: Option<&'a MediumStack>,
}

impl Recorder for () {
    const LISTENS: bool = false;
}

/// Writes down the ray tree of one camera ray.
pub(super) struct TreeRecorder<'a> {
    /// What the scene was compiled from, if names are wanted.
    desc: Option<&'a SceneDesc>,
    /// All rays, each after the one that it comes from.
    rays: Vec<Recorded>,
    /// Where those of the packets that are being traced stand, the last one's last.
    packets: Vec<Vec<usize>>,
}

struct Recorded {
    /// Without the rays that follow.
    tree: RayTree,
    /// Which one it comes from.
    parent: Option<usize>,
}

impl<'a> TreeRecorder<'a> {
    pub fn new(desc: &'a SceneDesc) -> Self {
        Self { desc: Some(desc), rays: Vec::new(), packets: Vec::new() }
    }

    /// One that leaves all names empty.
    pub fn without_names() -> Self {
        Self { desc: None, rays: Vec::new(), packets: Vec::new() }
    }

    /// The tree, when tracing is over.
    pub fn finish(mut self) -> Option<RayTree> {
        while let Some(Recorded { mut tree, parent }) = self.rays.pop() {
            if let End::Surface(surface) = &mut tree.end {
                surface.branches.sort_by_key(Branch::kind);
            }
            let Some(parent) = parent else { return Some(tree) };
            if let End::Surface(surface) = &mut self.rays[parent].tree.end {
                surface.branches.push(Branch::Ray(Box::new(tree)));
            }
        }
        None
    }

    /// A ray of the packet that is being traced.
    fn ray(&mut self, number: usize) -> Option<&mut RayTree> {
        let index = *self.packets.last()?.get(number)?;
        self.rays.get_mut(index).map(|recorded| &mut recorded.tree)
    }

    /// Where such a ray ends.
    fn surface(&mut self, number: usize) -> Option<&mut SurfaceTerms> {
        match self.ray(number).map(|ray| &mut ray.end) {
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
    fn begin<K: TreeKernels>(&mut self, scene: &Scene, level: &Level) {
        let first = self.rays.len();
        for (number, path) in level.paths.iter().enumerate() {
            let ray = level.rays.ray(number);
            let parent = self.packets.last().map(|packet| packet[path.parent as usize]);
            let kind = match parent {
                None => RayKind::Camera,
                Some(_) if path.is_refracted() => RayKind::Refraction,
                Some(_) => RayKind::Reflection,
            };
            let tree = RayTree {
                kind,
                origin: ray.origin.to_array(),
                direction: ray.direction.to_array(),
                share: path.share,
                weight: path.weight,
                medium: self.medium(scene, level.media.get(number)),
                visits: scene.visits::<K>(&ray, false),
                passed: Vec::new(),
                end: End::Background,
                radiance: Rgb::BLACK,
            };
            self.rays.push(Recorded { tree, parent });
        }
        self.packets.push((first..self.rays.len()).collect());
    }

    fn pass(&mut self, scene: &Scene, ray: usize, hit: &Hit) {
        let passed = Passed { object: self.object(scene, hit.object), t: hit.t };
        if let Some(ray) = self.ray(ray) {
            ray.passed.push(passed);
        }
    }

    fn meet(&mut self, scene: &Scene, ray: usize, end: SurfaceEnd) {
        let SurfaceEnd { interaction, color, ambient, beyond } = end;
        let hit = &interaction.hit;
        let material = &scene.materials[interaction.material as usize];
        let surface = SurfaceTerms {
            object: self.object(scene, hit.object),
            primitive: hit.primitive,
            t: hit.t,
            error: interaction.point_error,
            point: interaction.point.to_array(),
            normal: (interaction.shading_normal * interaction.side()).to_array(),
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
        if let Some(ray) = self.ray(ray) {
            ray.end = End::Surface(Box::new(surface));
        }
    }

    fn light<K: TreeKernels, const TERMS: u8>(
        &mut self,
        scene: &Scene,
        light: usize,
        lighting: &Lighting,
        rows: &SurfaceRows,
    ) {
        let Lighting { lit, beams, asked, unasked, .. } = lighting;
        // A surface on which no light can fall has no such terms.
        for slot in (0..lit.count).filter(|&slot| lit.get(slot).responds::<TERMS>()) {
            let name = self.desc.map_or(String::new(), |desc| {
                let shining = (0..desc.lights.len()).filter(|light| desc.lights[*light].visible).nth(light);
                Target::Light(shining.unwrap_or(light)).label(desc)
            });
            let doubt = unasked.iter().find(|unasked| usize::from(unasked.0) == slot).map(|(_, doubt)| *doubt);
            let number = asked.iter().position(|asked| usize::from(*asked) == slot);
            let beam = (doubt.is_some() || number.is_some()).then(|| beams.get(slot));
            let shadow_ray = number.filter(|_| TERMS & terms::SHADOWS != 0).map(|k| beams.shadow_rays.ray(k));
            let blocked = shadow_ray.filter(|_| beam.is_some_and(|beam| beam.part < 1.0));
            let blocker = blocked.and_then(|ray| scene.intersect::<K>(&ray));
            let shadow_of = blocker.map(|hit| self.object(scene, hit.object));
            let (surface, mut terms) = (lit.get(slot), [Rgb::BLACK; 3]);
            if let Some(beam) = beam.filter(|beam| beam.part != 0.0) {
                let specular = if surface.shines::<TERMS>() { surface.highlight::<K>(&beam) } else { 0.0 };
                let arriving = |factor: Rgb| beam.radiance * factor * beam.part;
                let sum = surface.response::<K, TERMS>(&beam);
                terms = [arriving(surface.diffuse(&beam)), arriving(Rgb::grey(specular)), sum];
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
            if let Some(surface) = self.surface(usize::from(rows.ray[slot])) {
                surface.lights.push(term);
            }
        }
    }

    fn cut(&mut self, ray: usize, cut: Cut) {
        if let Some(surface) = self.surface(ray).filter(|_| cut.weight > 0.0) {
            surface.branches.push(Branch::Cut(cut));
        }
    }

    fn end(&mut self, level: &Level) {
        for (number, &sum) in level.sums.iter().enumerate() {
            if let Some(ray) = self.ray(number) {
                ray.radiance = sum;
            }
        }
        self.packets.pop();
    }
}
