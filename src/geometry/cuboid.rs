//! The cube [-1, 1]³.

use super::interaction::SurfacePoint;
use super::interval::Interval;
use super::ray::Ray;
use glam::{DVec2, DVec3};

/// The first hit and its face, in f64.
#[inline(always)]
pub fn cuboid_intersect(ray: &Ray) -> Option<(f64, u32)> {
    let mut inside = Interval::ALL;
    for axis in 0..3 {
        inside.clip_slab(ray.origin[axis], ray.direction[axis], 2 * axis as u32, 2 * axis as u32 + 1);
    }
    inside.first_on(ray, 0.0)
}

/// The slab test with swapped planes in f32.
#[inline(always)]
pub(super) fn cuboid_intersect_f32(ray: &Ray) -> Option<(f64, u32)> {
    let (o, d) = (ray.origin.as_vec3(), ray.direction.as_vec3());
    let (mut enter, mut exit) = (f32::NEG_INFINITY, f32::INFINITY);
    let (mut enter_face, mut exit_face) = (0, 0);
    for axis in 0..3 {
        let (low, high) = (2 * axis as u32, 2 * axis as u32 + 1);
        let (mut t0, mut t1) = ((-1.0 - o[axis]) / d[axis], (1.0 - o[axis]) / d[axis]);
        let mut faces = (low, high);
        if t0 > t1 {
            std::mem::swap(&mut t0, &mut t1);
            faces = (high, low);
        }
        if t0 > enter {
            (enter, enter_face) = (t0, faces.0);
        }
        if t1 < exit {
            (exit, exit_face) = (t1, faces.1);
        }
    }
    if enter > exit {
        return None;
    }
    let (enter, exit) = (f64::from(enter), f64::from(exit));
    if ray.contains(enter) { Some((enter, enter_face)) } else { ray.contains(exit).then_some((exit, exit_face)) }
}

/// Axis of a face, and on which side of it.
#[inline(always)]
fn side_of(face: u32) -> (u32, f64) {
    (face / 2, if face.is_multiple_of(2) { -1.0 } else { 1.0 })
}

/// The surface of face `face` near `p` (object space).
#[inline(always)]
pub fn cuboid_surface(p: DVec3, face: u32) -> SurfacePoint {
    let (axis, side) = side_of(face);
    let within = p.clamp(DVec3::NEG_ONE, DVec3::ONE);
    // Coordinate by coordinate, so that loops over points become vector code.
    let on = |k: u32, other: f64| if k == axis { side } else { other };
    SurfacePoint {
        point: DVec3::new(on(0, within.x), on(1, within.y), on(2, within.z)),
        normal: DVec3::new(on(0, 0.0), on(1, 0.0), on(2, 0.0)),
    }
}

/// Texture coordinates at point `p` of face `face`. Pictures stand upright on every face, seen from outside.
#[inline(always)]
pub fn cuboid_uv(p: DVec3, face: u32) -> DVec2 {
    let (axis, side) = side_of(face);
    let (s, t) = match axis {
        0 => (-side * p.z, p.y),
        1 => (p.x, -side * p.z),
        _ => (side * p.x, p.y),
    };
    DVec2::new(0.5 + 0.5 * s, 0.5 + 0.5 * t)
}
