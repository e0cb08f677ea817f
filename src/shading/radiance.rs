//! The recursive function.

use super::local::local_radiance;
use crate::bvh::TreeKernels;
use crate::description::{Numerics, RenderDesc, Shading, Shadows};
use crate::geometry::{Classic, Fast, Hit, Ray, Reference, Robust, SurfaceInteraction, fresnel, reflect};
use crate::math::{Rgb, lowbias32};
use crate::scene::{Illumination, Material, MediumStack, Scene};
use glam::{DVec2, DVec3, Vec3};
use std::ops::AddAssign;
use std::sync::atomic::{AtomicBool, Ordering};

/// Rays by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// From the eye.
    pub camera: u64,
    /// To lights.
    pub shadow: u64,
    /// Mirrored.
    pub reflection: u64,
    /// Through glass.
    pub refraction: u64,
}

impl RayCounts {
    /// All kinds together.
    pub fn total(&self) -> u64 {
        self.camera + self.shadow + self.reflection + self.refraction
    }
}

impl AddAssign for RayCounts {
    fn add_assign(&mut self, o: Self) {
        self.camera += o.camera;
        self.shadow += o.shadow;
        self.reflection += o.reflection;
        self.refraction += o.refraction;
    }
}

/// What the camera sees through one point of the film.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Not finite where the arithmetic of `Classic` or `Fast` fails, or where light is beyond the range of f64.
    pub radiance: Rgb,
    /// Stands for the surface that the camera ray ends on; 0 where it meets nothing.
    pub surface: u32,
    /// Unit normal there in world space, on the viewer's side; 0 where it meets nothing.
    pub normal: Vec3,
    /// Hash of all surfaces that the ray tree meets, in order: samples of equal trees differ smoothly.
    pub tree: u32,
    /// Sum of the weights of paths that were not followed, for their depth or because they weigh next to nothing.
    pub cut: f64,
}

/// Traces what the camera sees through points of the film, in pixels from its upper left corner, into as many samples.
/// Counts the rays that it takes. What a sample is does not depend on what else is in the slice.
///
/// The flag ends it early: once it is set, no further ray is traced, and what is returned means nothing.
pub type Sampler = fn(&Scene, &[DVec2], &mut [Sample], &mut RayCounts, &AtomicBool);

/// The sampler for a scene's numerics and lighting model.
pub fn sampler(render: &RenderDesc) -> Sampler {
    match render.numerics {
        Numerics::Classic => with_kernels::<Classic>(render.shading),
        Numerics::Fast => with_kernels::<Fast>(render.shading),
        Numerics::Robust => with_kernels::<Robust>(render.shading),
        Numerics::Reference => with_kernels::<Reference>(render.shading),
    }
}

fn with_kernels<K: TreeKernels>(shading: Shading) -> Sampler {
    match shading {
        Shading::Lambert => sample_local::<K, false>,
        Shading::Phong => sample_local::<K, true>,
        Shading::Whitted => sample_whitted::<K>,
    }
}

/// Lambert and Phong: one ray, no others.
fn sample_local<K: TreeKernels, const HIGHLIGHTS: bool>(
    scene: &Scene,
    points: &[DVec2],
    samples: &mut [Sample],
    counts: &mut RayCounts,
    stop: &AtomicBool,
) {
    for (point, sample) in points.iter().zip(samples) {
        if stop.load(Ordering::Relaxed) {
            return;
        }
        counts.camera += 1;
        *sample = Sample::default();
        let ray = Ray { t_min: K::T_MIN, ..scene.camera.ray(point.x, point.y) };
        sample.radiance = local::<K, HIGHLIGHTS>(scene, &ray, sample);
    }
}

fn local<K: TreeKernels, const HIGHLIGHTS: bool>(scene: &Scene, ray: &Ray, sample: &mut Sample) -> Rgb {
    let Some(hit) = scene.intersect::<K>(ray) else { return scene.background(ray.direction) };
    let interaction = scene.interaction::<K>(ray, &hit);
    let material = &scene.materials[interaction.material as usize];
    let side = if interaction.entering { 1.0 } else { -1.0 };
    sample.meet(&interaction, 0);
    local_radiance::<K, HIGHLIGHTS>(
        scene,
        material,
        &interaction,
        interaction.shading_normal * side,
        -ray.direction,
        |_| 1.0,
    )
}

fn sample_whitted<K: TreeKernels>(
    scene: &Scene,
    points: &[DVec2],
    samples: &mut [Sample],
    counts: &mut RayCounts,
    stop: &AtomicBool,
) {
    for (point, sample) in points.iter().zip(samples) {
        counts.camera += 1;
        *sample = Sample::default();
        let ray = Ray { t_min: K::T_MIN, ..scene.camera.ray(point.x, point.y) };
        let media = scene.media_at_start(ray.origin);
        let mut whitted = Whitted { scene, counts, stop, sample };
        sample.radiance = whitted.radiance::<K>(ray, media, Path { depth: 0, weight: 1.0 });
    }
}

impl Sample {
    /// Notes a surface that the ray tree meets at this depth.
    fn meet(&mut self, interaction: &SurfaceInteraction, depth: u32) {
        // The parts of a mesh are told apart by their normals.
        let surface = interaction.hit.object + 1;
        if depth == 0 {
            self.surface = surface;
            let side = if interaction.entering { 1.0 } else { -1.0 };
            self.normal = (interaction.shading_normal * side).as_vec3();
        }
        self.tree = lowbias32(self.tree.wrapping_mul(31).wrapping_add(surface));
    }
}

/// What lies between the eye and the start of a ray.
#[derive(Clone, Copy)]
struct Path {
    /// Reflections and refractions.
    depth: u32,
    /// Product of their weights.
    weight: f64,
}

/// Paths of less weight than this are not followed: what they bring is below the resolution of the film (Hall and
/// Greenberg 1983 cut at a visible weight; this only keeps ray trees from growing without end).
const NEGLIGIBLE: f64 = 1.0 / 1_048_576.0;

struct Whitted<'a> {
    scene: &'a Scene,
    counts: &'a mut RayCounts,
    stop: &'a AtomicBool,
    sample: &'a mut Sample,
}

/// What a ray meets at the surface of a transparent body.
enum Crossing {
    /// An opaque surface lies on it.
    Opaque(Hit),
    /// No change of medium; the bodies behind.
    Nothing(MediumStack),
    /// A change of medium; the bodies behind, and the product of all k_t.
    Surface(MediumStack, f64),
}

/// How light goes on at a surface: weights and what each ray needs.
struct Split {
    /// The normal that both rays belong to: on the side of the viewer.
    normal: DVec3,
    /// Weight of the mirrored ray.
    reflect: f64,
    /// Weight and direction of the refracted ray.
    transmit: Option<(f64, DVec3)>,
}

impl Whitted<'_> {
    /// What a ray sees that starts inside of `media` at the end of `path`.
    fn radiance<K: TreeKernels>(&mut self, mut ray: Ray, mut media: MediumStack, path: Path) -> Rgb {
        let scene = self.scene;
        if self.stop.load(Ordering::Relaxed) {
            return Rgb::BLACK;
        }
        loop {
            let Some(hit) = scene.intersect::<K>(&ray) else { return scene.background(ray.direction) };
            let interaction = scene.interaction::<K>(&ray, &hit);
            let material = &scene.materials[interaction.material as usize];
            if material.transmit == 0.0 {
                return self.shade::<K>(&ray, &interaction, material, media, None, path);
            }
            let slack = slack(&ray, &hit, &interaction);
            match self.cross::<K>(&ray, &hit, &interaction, &media, slack) {
                Crossing::Opaque(hit) => {
                    let interaction = scene.interaction::<K>(&ray, &hit);
                    let material = &scene.materials[interaction.material as usize];
                    return self.shade::<K>(&ray, &interaction, material, media, None, path);
                }
                Crossing::Nothing(beyond) => {
                    // On with the same ray: nothing is computed anew.
                    ray.t_min = hit.t + slack;
                    media = beyond;
                }
                Crossing::Surface(beyond, _) => {
                    return self.shade::<K>(&ray, &interaction, material, media, Some(beyond), path);
                }
            }
        }
    }

    /// What there is at a hit with a transparent body, when all surfaces that touch there are taken together.
    fn cross<K: TreeKernels>(
        &self,
        ray: &Ray,
        hit: &Hit,
        interaction: &SurfaceInteraction,
        media: &MediumStack,
        slack: f64,
    ) -> Crossing {
        let scene = self.scene;
        let mut beyond = media.crossed(scene, hit.object, interaction.material, interaction.entering);
        let mut opaque: Option<Hit> = None;
        let mut transmit = scene.materials[interaction.material as usize].transmit;
        scene.coincident::<K>(ray, hit, slack, |other| {
            let material = scene.material_of(other.object, other.primitive);
            if scene.materials[material as usize].transmit > 0.0 {
                let entering = scene.interaction::<K>(ray, &other).entering;
                transmit *= scene.materials[material as usize].transmit;
                beyond = beyond.crossed(scene, other.object, material, entering);
            } else if opaque.is_none_or(|o| other.beats(&o)) {
                opaque = Some(other);
            }
        });
        match opaque {
            Some(hit) => Crossing::Opaque(hit),
            // The surface of a body inside of one that outranks it is not there.
            None if *media != beyond && media.filling(scene) == beyond.filling(scene) => Crossing::Nothing(beyond),
            None => Crossing::Surface(beyond, transmit),
        }
    }

    /// All five terms. `beyond`: the media behind the surface, if light gets there.
    fn shade<K: TreeKernels>(
        &mut self,
        ray: &Ray,
        interaction: &SurfaceInteraction,
        material: &Material,
        media: MediumStack,
        beyond: Option<MediumStack>,
        path: Path,
    ) -> Rgb {
        let scene = self.scene;
        self.sample.meet(interaction, path.depth);
        let side = if interaction.entering { 1.0 } else { -1.0 };
        let normal = interaction.shading_normal * side;
        let facet = interaction.geometric_normal * side;
        let mut sum = local_radiance::<K, true>(scene, material, interaction, normal, -ray.direction, |light| {
            self.visible_part::<K>(interaction, light, &media)
        });
        if material.reflect == 0.0 && material.transmit == 0.0 {
            return sum;
        }
        if path.depth >= scene.render.max_depth {
            self.sample.cut += path.weight * (material.reflect + material.transmit);
            return sum;
        }
        let eta = beyond.map(|b| media.ior(scene) / b.ior(scene));
        let split = split::<K>(material, ray, normal, facet, (media.ior(scene), eta), interaction.entering);
        // A material that gives back more than it gets is weighed by shares, or its ray tree would grow without end.
        let gain = (split.reflect + split.transmit.map_or(0.0, |(weight, _)| weight)).max(1.0);
        if let Some(path) = self.follow(path, split.reflect / gain) {
            self.counts.reflection += 1;
            let mirrored = interaction.spawn_ray::<K>(reflect(ray.direction, split.normal, facet));
            sum += self.radiance::<K>(mirrored, media, path) * split.reflect;
        }
        if let (Some((weight, direction)), Some(beyond)) = (split.transmit, beyond)
            && let Some(path) = self.follow(path, weight / gain)
        {
            self.counts.refraction += 1;
            let refracted = interaction.spawn_ray::<K>(direction);
            sum += self.radiance::<K>(refracted, beyond, path) * weight;
        }
        sum
    }

    /// The path with one more reflection or refraction of this weight, if it is worth following.
    fn follow(&mut self, path: Path, weight: f64) -> Option<Path> {
        let path = Path { depth: path.depth + 1, weight: path.weight * weight };
        let worth_it = path.weight >= NEGLIGIBLE;
        if !worth_it {
            self.sample.cut += path.weight;
        }
        worth_it.then_some(path)
    }

    /// The part of the light that gets through to the end of a ray past transparent surfaces: the product of their k_t.
    fn transmittance<K: TreeKernels>(&self, mut ray: Ray, mut media: MediumStack) -> f64 {
        let mut part = 1.0;
        while part > 0.0 {
            let Some(hit) = self.scene.intersect::<K>(&ray) else { break };
            let interaction = self.scene.interaction::<K>(&ray, &hit);
            if self.scene.materials[interaction.material as usize].transmit == 0.0 {
                return 0.0;
            }
            let slack = slack(&ray, &hit, &interaction);
            let beyond = match self.cross::<K>(&ray, &hit, &interaction, &media, slack) {
                Crossing::Opaque(_) => return 0.0,
                Crossing::Nothing(beyond) => beyond,
                Crossing::Surface(beyond, transmit) => {
                    part *= transmit;
                    beyond
                }
            };
            // The same ray goes on behind the hit: nothing is computed anew, so nothing is met twice or skipped.
            ray.t_min = hit.t + slack;
            media = beyond;
        }
        part
    }

    /// Which part of a light in front of the surface arrives.
    fn visible_part<K: TreeKernels>(
        &mut self,
        interaction: &SurfaceInteraction,
        light: &Illumination,
        media: &MediumStack,
    ) -> f64 {
        let ray = match light.position {
            Some(position) => interaction.shadow_ray_to::<K>(position),
            None => Some(interaction.shadow_ray_along::<K>(light.direction)),
        };
        let Some(ray) = ray else { return 0.0 };
        self.counts.shadow += 1;
        if self.scene.render.shadows == Shadows::Filtered && self.scene.has_media() {
            self.transmittance::<K>(ray, *media)
        } else if self.scene.occluded::<K>(&ray) {
            0.0
        } else {
            1.0
        }
    }
}

/// How far (in t) around a hit other surfaces are taken to touch it: rays that go on start up to this much behind it.
fn slack(ray: &Ray, hit: &Hit, interaction: &SurfaceInteraction) -> f64 {
    // The rounding of t, far from the camera much more than that of the point.
    let of_t = hit.reach() - hit.t;
    let slant = ray.direction.dot(interaction.geometric_normal).abs().max(GRAZING);
    (4.0 * interaction.point_error + of_t) / slant
}

/// Below this cosine a ray counts as this slanted: where it grazes, touching surfaces can not be told from near ones.
const GRAZING: f64 = 1e-3;

/// Divides k_r and k_t between the mirrored and the refracted ray. `outside`: index before the
/// surface; `eta`: that over the one behind it, if light gets there.
fn split<K: TreeKernels>(
    material: &Material,
    ray: &Ray,
    normal: DVec3,
    facet: DVec3,
    (outside, eta): (f64, Option<f64>),
    entering: bool,
) -> Split {
    // Toward its silhouette a smooth surface may seem to face away.
    let normal = if ray.direction.dot(normal) < 0.0 { normal } else { facet };
    let Some(eta) = eta else {
        // Opaque: a mirror, or a varnish whose reflection follows Fresnel.
        let weight = if material.fresnel { fresnel_of(ray, normal, outside / material.ior) } else { 1.0 };
        return Split { normal, reflect: material.reflect * weight, transmit: None };
    };
    let total = Split { normal, reflect: material.reflect + material.transmit, transmit: None };
    // A smooth normal may bend the ray to the wrong side of the facet; the facet's own normal does not.
    let bent = K::refract(ray.direction, normal, eta, entering).map(|direction| {
        if direction.dot(facet) < 0.0 || normal == facet {
            Some((direction, normal))
        } else {
            K::refract(ray.direction, facet, eta, entering).map(|direction| (direction, facet))
        }
    });
    let Some(Some((direction, normal))) = bent else { return total };
    if !material.fresnel {
        return Split { normal, reflect: material.reflect, transmit: Some((material.transmit, direction)) };
    }
    let reflectance = fresnel(-ray.direction.dot(normal), -direction.dot(normal), eta);
    let energy = material.reflect + material.transmit;
    Split { normal, reflect: energy * reflectance, transmit: Some((energy * (1.0 - reflectance), direction)) }
}

/// Fresnel's reflectance for a ray that meets an opaque surface.
fn fresnel_of(ray: &Ray, normal: DVec3, eta: f64) -> f64 {
    let cos_in = -ray.direction.dot(normal);
    let cos2_out = 1.0 - eta * eta * (1.0 - cos_in * cos_in);
    if cos2_out < 0.0 { 1.0 } else { fresnel(cos_in, cos2_out.sqrt(), eta) }
}
