//! Surfaces of transparent bodies: what lies behind them. One ray at a time.

use crate::bvh::TreeKernels;
use crate::geometry::{Hit, Ray};
use crate::scene::{MediumStack, Scene};
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
