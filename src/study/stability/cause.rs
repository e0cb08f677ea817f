//! Why two renderings of a pixel differ: both ray trees are walked side by side until they part.

use crate::bvh::TreeKernels;
use crate::geometry::{Hit, Ray, Reference, SurfaceInteraction, reflect};
use crate::scene::{MediumStack, Scene};
use glam::DVec3;
use serde::Serialize;

/// Why a pixel flips.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum Cause {
    /// A ray met the surface that it left.
    Acne,
    /// A ray went through a surface, well inside of its outline.
    Crack,
    /// The shadow of a smooth mesh's own facets.
    Terminator,
    /// One decided for total reflection.
    TotalReflection,
    /// The bodies around a ray were not the same.
    Media,
    /// One followed a path that the other cut.
    DepthCut,
    /// Two surfaces in the same place.
    Tie,
    /// The outline of a body or of a shadow passes through the sample.
    Edge,
    /// The same surfaces and lights, with other numbers.
    Rounding,
}

impl Cause {
    /// All of them, with names and colours.
    pub const ALL: [(Cause, &'static str, [u8; 3]); 9] = [
        (Self::Acne, "acne", [230, 25, 25]),
        (Self::Crack, "crack", [255, 0, 255]),
        (Self::Terminator, "terminator", [255, 150, 0]),
        (Self::TotalReflection, "total reflection", [0, 200, 255]),
        (Self::Media, "media", [0, 90, 255]),
        (Self::DepthCut, "depth cut", [150, 80, 255]),
        (Self::Tie, "tie", [255, 255, 0]),
        (Self::Edge, "edge", [60, 255, 60]),
        (Self::Rounding, "rounding", [255, 255, 255]),
    ];
}

/// One of the two renderings, at some ray of its tree.
#[derive(Clone, Copy)]
pub struct Side<'a> {
    pub scene: &'a Scene,
    pub ray: Ray,
    pub media: MediumStack,
    /// Lengths here over lengths in the other one's scene.
    pub scale: f64,
    /// The object that the ray left.
    pub left: Option<u32>,
}

impl Side<'_> {
    /// The primary ray of a pixel's centre.
    pub fn primary<K: TreeKernels>(scene: &Scene, (x, y): (u32, u32), scale: f64) -> Side<'_> {
        let ray = Ray { t_min: K::T_MIN, ..scene.camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5) };
        Side { scene, ray, media: scene.media_at_start(ray.origin), scale, left: None }
    }
}

/// Distances whose ratio is closer to 1 than this are the same place.
const SAME: f64 = 1e-6;

/// Part of the way to the next thing within which a ray that meets what it left has acne.
const NEAR: f64 = 1e-2;

/// The first reason for which two ray trees part; `None` if they do not. `b` is rendered by `K`, `a` by `A`.
pub fn parting<A: TreeKernels, K: TreeKernels>(a: Side, b: Side, depth: u32) -> Option<Cause> {
    let (hit_a, hit_b) = (a.scene.intersect::<A>(&a.ray), b.scene.intersect::<K>(&b.ray));
    let (hit_a, hit_b) = match (hit_a, hit_b) {
        (None, None) => return None,
        (Some(p), Some(q)) if p.object == q.object && same_place(&a, &p, &b, &q) => (p, q),
        (p, q) => return Some(missed(&a, p, &b, q)),
    };
    let (on_a, on_b) = (a.scene.interaction::<A>(&a.ray, &hit_a), b.scene.interaction::<K>(&b.ray, &hit_b));
    if on_a.entering != on_b.entering {
        return Some(Cause::Media);
    }
    if let Some(cause) = shadows::<A, K>(&a, &on_a, &b, &on_b) {
        return Some(cause);
    }
    let material = &a.scene.materials[on_a.material as usize];
    if depth >= a.scene.render.max_depth || (material.reflect == 0.0 && material.transmit == 0.0) {
        return None;
    }
    let normals = [&on_a, &on_b].map(|on| {
        let side = if on.entering { 1.0 } else { -1.0 };
        (on.shading_normal * side, on.geometric_normal * side)
    });
    let mut beyond = None;
    if material.transmit > 0.0 {
        let behind = |side: &Side, on: &SurfaceInteraction| {
            let mut media = side.media;
            media.cross(side.scene, on.hit.object, on.material, on.entering);
            media
        };
        let (behind_a, behind_b) = (behind(&a, &on_a), behind(&b, &on_b));
        if behind_a.filling(a.scene) != behind_b.filling(b.scene)
            || a.media.filling(a.scene) != b.media.filling(b.scene)
        {
            return Some(Cause::Media);
        }
        let bent_a = bent::<A>(&a, &on_a, behind_a, normals[0].0);
        let bent_b = bent::<K>(&b, &on_b, behind_b, normals[1].0);
        match (bent_a, bent_b) {
            (Some(p), Some(q)) if p.is_finite() && q.is_finite() => beyond = Some((p, behind_a, q, behind_b)),
            (None, None) => {}
            _ => return Some(Cause::TotalReflection),
        }
    }
    let object = Some(on_a.hit.object);
    if let Some((p, behind_a, q, behind_b)) = beyond {
        // Bent by the indices of other bodies: in a mirrored scene directions differ, their angles do not.
        let slant = |bent: DVec3, on: &SurfaceInteraction| bent.dot(on.geometric_normal);
        if (slant(p, &on_a) - slant(q, &on_b)).abs() > 1e-3 {
            return Some(Cause::Media);
        }
        let a = Side { ray: on_a.spawn_ray::<A>(p), media: behind_a, left: object, ..a };
        let b = Side { ray: on_b.spawn_ray::<K>(q), media: behind_b, left: object, ..b };
        if let Some(cause) = parting::<A, K>(a, b, depth + 1) {
            return Some(cause);
        }
    }
    if material.reflect > 0.0 || material.fresnel || (material.transmit > 0.0 && beyond.is_none()) {
        let mirrored = |side: &Side, (shading, facet): (DVec3, DVec3)| reflect(side.ray.direction, shading, facet);
        let (p, q) = (mirrored(&a, normals[0]), mirrored(&b, normals[1]));
        let a = Side { ray: on_a.spawn_ray::<A>(p), left: object, ..a };
        let b = Side { ray: on_b.spawn_ray::<K>(q), left: object, ..b };
        return parting::<A, K>(a, b, depth + 1);
    }
    None
}

fn bent<K: TreeKernels>(side: &Side, on: &SurfaceInteraction, behind: MediumStack, normal: DVec3) -> Option<DVec3> {
    K::refract(side.ray.direction, normal, side.media.ior(side.scene) / behind.ior(side.scene), on.entering)
}

fn same_place(a: &Side, p: &Hit, b: &Side, q: &Hit) -> bool {
    let (s, t) = (p.t * b.scale, q.t * a.scale);
    // A ray that starts on a surface may meet the next one where its own error is all there is.
    (s - t).abs() <= 1e-3 * s.max(t)
}

/// Why one ray sees another thing than the other one does.
fn missed(a: &Side, p: Option<Hit>, b: &Side, q: Option<Hit>) -> Cause {
    let far = |hit: Option<Hit>| hit.map_or(f64::INFINITY, |hit| hit.t);
    let (s, t) = (far(p) / a.scale, far(q) / b.scale);
    let (nearer, side, ratio) = if s < t { (p, a, s / t) } else { (q, b, t / s) };
    let Some(nearer) = nearer else { return Cause::Rounding };
    if side.left == Some(nearer.object) && ratio < NEAR {
        return Cause::Acne;
    }
    if ratio > 1.0 - SAME {
        return Cause::Tie;
    }
    // The rays all around it know whether an outline is near.
    let (u, v) = side.ray.direction.normalize_or(DVec3::Z).any_orthonormal_pair();
    let around = [u, v, -u, -v].into_iter().all(|way| {
        let direction = side.ray.direction + way * (1e-5 * side.ray.direction.length());
        let ray = Ray { direction, t_min: 0.0, ..side.ray };
        side.scene.intersect::<Reference>(&ray).is_some_and(|hit| hit.object == nearer.object)
    });
    if around { Cause::Crack } else { Cause::Edge }
}

/// Why a light reaches the point in one rendering and not in the other.
fn shadows<A: TreeKernels, K: TreeKernels>(
    a: &Side,
    on_a: &SurfaceInteraction,
    b: &Side,
    on_b: &SurfaceInteraction,
) -> Option<Cause> {
    let smooth = on_a.shading_normal != on_a.geometric_normal;
    for light in 0..a.scene.lights.len() {
        match (blocker::<A>(a, on_a, light), blocker::<K>(b, on_b, light)) {
            (Sight::Away, Sight::Away) | (Sight::Free, Sight::Free) | (Sight::Blocked(_), Sight::Blocked(_)) => {}
            (Sight::Blocked(object), Sight::Free) | (Sight::Free, Sight::Blocked(object)) => {
                let own = object == on_a.hit.object;
                return Some(match (own, smooth) {
                    (true, true) => Cause::Terminator,
                    (true, false) => Cause::Acne,
                    (false, _) => Cause::Edge,
                });
            }
            // Right at the grazing angle.
            _ => return Some(if smooth { Cause::Terminator } else { Cause::Edge }),
        }
    }
    None
}

/// What a light is to a point.
enum Sight {
    Away,
    Free,
    Blocked(u32),
}

fn blocker<K: TreeKernels>(side: &Side, on: &SurfaceInteraction, light: usize) -> Sight {
    let Some(light) = side.scene.lights[light].illuminate(on.point) else { return Sight::Away };
    let out = if on.entering { 1.0 } else { -1.0 };
    if (on.shading_normal * out).dot(light.direction) <= 0.0 {
        return Sight::Away;
    }
    let ray = match light.position {
        Some(position) => on.shadow_start().ray_to::<K>(position),
        None => Some(on.shadow_start().ray_along::<K>(light.direction)),
    };
    let hit = ray.and_then(|ray| side.scene.intersect::<K>(&ray));
    hit.map_or(Sight::Free, |hit| Sight::Blocked(hit.object))
}
