//! The cone with its base of radius 1 at y = -1 and its apex at y = 1.

use super::cylinder::{BOTTOM, NearestF32, SIDE, advance, cap_surface, cap_uv, side_uv};
use super::interaction::SurfacePoint;
use super::interval::Interval;
use super::quadratic::{classic_roots_f32, roots};
use super::ray::Ray;
use glam::{DVec2, DVec3};

/// Radius at distance w below the apex is `SLOPE * w`.
const SLOPE: f64 = 0.5;

/// Faces of the slab 0 <= w <= 2: the apex plane is never the surface, since the cone has no width there.
const APEX: u32 = SIDE;

/// The first hit and its face, in f64. With w = 1 - y, the solid is {x² + z² <= w²/4} cut to 0 <= w <= 2. The
/// discriminant is that of numerics.md row 4, k²((o x d)_x² + (o x d)_y²) - (o x d)_z² in the cone's own frame,
/// factored.
#[inline(always)]
pub fn cone_intersect(ray: &Ray) -> Option<(f64, u32)> {
    let (t0, o) = advance(ray);
    let d = ray.direction;
    let mut inside = Interval::ALL;
    inside.clip_slab(o.y, d.y, BOTTOM, APEX);
    let (ow, dw) = (1.0 - o.y, -d.y);
    // Not `hypot`: the library's took a sixth of the frame, and coordinates here are of the size of the shape.
    let norm = |x: f64, z: f64| (x * x + z * z).sqrt();
    let (rho, radius) = (norm(o.x, o.z), SLOPE * ow.abs());
    let c = (rho - radius) * (rho + radius);
    let (dr, dk) = (norm(d.x, d.z), SLOPE * dw.abs());
    let a = (dr - dk) * (dr + dk);
    let b = o.x * d.x + o.z * d.z - SLOPE * SLOPE * ow * dw;
    let swirl = (o.x * d.z - o.z * d.x).abs();
    let lean = SLOPE * norm(o.x * dw - ow * d.x, o.z * dw - ow * d.z);
    let disc = (lean - swirl) * (lean + swirl);
    // With a > 0 the line leaves the double cone at both ends: inside between the roots. With a < 0 it is inside
    // outside of the roots, once in each nappe; ours is the one with w >= 0. A negative discriminant is rounding at the
    // apex then, which such a line must pass. All cases in one piece, so that loops over rays become vector code.
    let missed = if a > 0.0 { disc < 0.0 } else { (a == 0.0) & (b == 0.0) & (c > 0.0) };
    if missed {
        return None;
    }
    let (near, far) = roots(a, b, c, disc.max(0.0).sqrt());
    let (near, far) = if a == 0.0 { (-c / (2.0 * b), -c / (2.0 * b)) } else { (near, far) };
    let begins = if a == 0.0 { b < 0.0 } else { dw > 0.0 };
    let ends = if a == 0.0 { b > 0.0 } else { dw <= 0.0 };
    let enter = if a > 0.0 { near } else { far };
    let exit = if a > 0.0 { far } else { near };
    let enter = if (a > 0.0) | begins { enter } else { f64::NEG_INFINITY };
    let exit = if (a > 0.0) | ends { exit } else { f64::INFINITY };
    inside.clip(enter, SIDE, exit, SIDE);
    inside.first_on(ray, t0)
}

/// The school formula in f32: side and base on their own, nearest wins.
#[inline(always)]
pub(super) fn cone_intersect_f32(ray: &Ray) -> Option<(f64, u32)> {
    let (o, d) = (ray.origin.as_vec3(), ray.direction.as_vec3());
    let (k2, ow, dw) = (0.25f32, 1.0 - o.y, -d.y);
    let on_side = |t: f32| (ow + t * dw >= 0.0) & (ow + t * dw <= 2.0);
    let on_base = |t: f32| (o.x + t * d.x).powi(2) + (o.z + t * d.z).powi(2) <= 1.0;
    let mut nearest = NearestF32::NONE;
    if let Some([t0, t1]) = classic_roots_f32(
        d.x * d.x + d.z * d.z - k2 * dw * dw,
        o.x * d.x + o.z * d.z - k2 * ow * dw,
        o.x * o.x + o.z * o.z - k2 * ow * ow,
    ) {
        nearest.offer(ray, t0, SIDE, on_side(t0));
        nearest.offer(ray, t1, SIDE, on_side(t1));
    }
    let base = (-1.0 - o.y) / d.y;
    nearest.offer(ray, base, BOTTOM, on_base(base));
    nearest.hit()
}

/// The surface of face `face` near `p` (object space). The apex looks along the axis.
pub fn cone_surface(p: DVec3, face: u32) -> SurfacePoint {
    cone_surface_at(p, p.x.hypot(p.z), face)
}

/// The same, where the distance from the axis is known: that takes a call, which loops over points can not make.
#[inline(always)]
pub fn cone_surface_at(p: DVec3, rho: f64, face: u32) -> SurfacePoint {
    if face == BOTTOM {
        return cap_surface(p, -1.0);
    }
    let y = p.y.clamp(-1.0, 1.0);
    if rho == 0.0 {
        return SurfacePoint { point: DVec3::new(0.0, y, 0.0), normal: DVec3::Y };
    }
    let (cos, sin) = (p.z / rho, p.x / rho);
    let radius = SLOPE * (1.0 - y);
    let normal = DVec3::new(sin, SLOPE, cos).normalize();
    SurfacePoint { point: DVec3::new(sin * radius, y, cos * radius), normal }
}

/// Texture coordinates at point `p` of face `face`: longitude and height on the side, the unit square on the base.
#[inline(always)]
pub fn cone_uv(p: DVec3, face: u32) -> DVec2 {
    if face == SIDE { side_uv(p) } else { cap_uv(p, face) }
}
