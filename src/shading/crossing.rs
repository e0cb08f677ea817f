//! Surfaces of transparent bodies: what lies behind them and how light divides there. One ray at a time.

use crate::bvh::TreeKernels;
use crate::geometry::{Hit, Ray, fresnel};
use crate::scene::{Material, MediumStack, Scene};
use glam::DVec3;

/// What a ray meets at the surface of a transparent body.
pub(super) enum Crossing {
    /// An opaque surface lies on it.
    Opaque(Hit),
    /// No change of medium.
    Nothing,
    /// A change of medium, and the product of all k_t.
    Surface(f64),
}

/// What there is at a hit with a transparent body of this material, when all surfaces that touch there are taken
/// together. `beyond`: the bodies before it, to become those behind it.
pub(super) fn cross<K: TreeKernels>(
    scene: &Scene,
    ray: &Ray,
    hit: &Hit,
    (material, entering): (u32, bool),
    beyond: &mut MediumStack,
    slack: f64,
) -> Crossing {
    let before = *beyond;
    beyond.cross(scene, hit.object, material, entering);
    let mut opaque: Option<Hit> = None;
    let mut transmit = scene.materials[material as usize].transmit;
    scene.coincident::<K>(ray, hit, slack, |other| {
        let material = scene.material_of(other.object, other.primitive);
        if scene.materials[material as usize].transmit > 0.0 {
            let entering = scene.facet::<K>(ray, &other).entering;
            transmit *= scene.materials[material as usize].transmit;
            beyond.cross(scene, other.object, material, entering);
        } else if opaque.is_none_or(|o| other.beats(&o)) {
            opaque = Some(other);
        }
    });
    match opaque {
        Some(hit) => Crossing::Opaque(hit),
        // The surface of a body inside of one that outranks it is not there.
        None if before != *beyond && before.filling(scene) == beyond.filling(scene) => Crossing::Nothing,
        None => Crossing::Surface(transmit),
    }
}

/// How far (in t) around a hit other surfaces are taken to touch it: rays that go on start up to this much behind it.
/// `normal` and `point_error`: of the facet that is hit.
pub(super) fn slack(ray: &Ray, hit: &Hit, normal: DVec3, point_error: f64) -> f64 {
    // The rounding of t, far from the camera much more than that of the point.
    let of_t = hit.reach() - hit.t;
    let slant = ray.direction.dot(normal).abs().max(GRAZING);
    (4.0 * point_error + of_t) / slant
}

/// Below this cosine a ray counts as this slanted: where it grazes, touching surfaces can not be told from near ones.
const GRAZING: f64 = 1e-3;

/// How light goes on at a surface: weights and what each ray needs.
pub(super) struct Split {
    /// The normal that both rays belong to: on the side of the viewer.
    pub normal: DVec3,
    /// Weight of the mirrored ray.
    pub reflect: f64,
    /// Weight and direction of the refracted ray.
    pub transmit: Option<(f64, DVec3)>,
}

/// Divides k_r and k_t between the mirrored and the refracted ray. `outside`: index before the
/// surface; `eta`: that over the one behind it, if light gets there.
#[inline(always)]
pub(super) fn split<K: TreeKernels>(
    material: &Material,
    ray: &Ray,
    normal: DVec3,
    facet: DVec3,
    (outside, eta): (f64, Option<f64>),
    entering: bool,
) -> Split {
    // Toward its silhouette a smooth surface may seem to face away.
    let normal = if ray.direction.dot(normal) < 0.0 { normal } else { facet };
    if let Some(eta) = eta {
        return split_glass::<K>(material, ray, normal, facet, eta, entering);
    }
    // Opaque: a mirror, or a varnish whose reflection follows Fresnel.
    let weight = if material.fresnel { fresnel_of(ray, normal, outside / material.ior) } else { 1.0 };
    Split { normal, reflect: material.reflect * weight, transmit: None }
}

/// The same where light gets behind the surface.
fn split_glass<K: TreeKernels>(
    material: &Material,
    ray: &Ray,
    normal: DVec3,
    facet: DVec3,
    eta: f64,
    entering: bool,
) -> Split {
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
