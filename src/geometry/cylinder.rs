//! The cylinder of radius 1 about the y axis, capped at y = ±1.

use super::interaction::SurfacePoint;
use super::interval::Interval;
use super::quadratic::{classic_roots_f32, roots};
use super::ray::Ray;
use super::sphere::longitude;
use glam::{DVec2, DVec3};

pub(super) const SIDE: u32 = 0;
pub(super) const BOTTOM: u32 = 1;
const TOP: u32 = 2;

/// Rays that start farther than this (squared) from the origin are advanced to their closest approach first: the
/// coefficients of the quadratics then stay of the size of the shape (numerics.md, section 2).
const FAR: f64 = 64.0;

/// `(t0, origin + t0 direction)`: the origin, advanced if it is far away.
#[inline(always)]
pub(super) fn advance(ray: &Ray) -> (f64, DVec3) {
    if ray.origin.length_squared() <= FAR {
        return (0.0, ray.origin);
    }
    let t0 = -ray.origin.dot(ray.direction) / ray.direction.length_squared();
    (t0, ray.at(t0))
}

/// The first hit and its face, in f64: the discriminant by Lagrange's identity, a - (o x d)_y², does not cancel.
#[inline(always)]
pub fn cylinder_intersect(ray: &Ray) -> Option<(f64, u32)> {
    let (t0, o) = advance(ray);
    let d = ray.direction;
    let mut inside = Interval::ALL;
    let a = d.x * d.x + d.z * d.z;
    let rho = (o.x * o.x + o.z * o.z).sqrt();
    let c = (rho - 1.0) * (rho + 1.0);
    let cross = o.x * d.z - o.z * d.x;
    let disc = a - cross * cross;
    // A line along the axis is beside the cylinder or bounded by the caps only.
    let missed = if a == 0.0 { c > 0.0 } else { disc < 0.0 };
    if missed {
        return None;
    }
    let (near, far) = roots(a, o.x * d.x + o.z * d.z, c, disc.sqrt());
    let (near, far) = if a == 0.0 { (f64::NEG_INFINITY, f64::INFINITY) } else { (near, far) };
    inside.clip(near, SIDE, far, SIDE);
    // Last, since it costs two divisions that a ray beside the cylinder need not pay for.
    inside.clip_slab(o.y, d.y, BOTTOM, TOP);
    inside.first_on(ray, t0)
}

/// The school formula in f32: side and caps on their own, nearest wins.
#[inline(always)]
pub(super) fn cylinder_intersect_f32(ray: &Ray) -> Option<(f64, u32)> {
    let (o, d) = (ray.origin.as_vec3(), ray.direction.as_vec3());
    let on_side = |t: f32| (o.y + t * d.y).abs() <= 1.0;
    let on_cap = |t: f32| (o.x + t * d.x).powi(2) + (o.z + t * d.z).powi(2) <= 1.0;
    let mut nearest = NearestF32::NONE;
    if let Some([t0, t1]) = classic_roots_f32(d.x * d.x + d.z * d.z, o.x * d.x + o.z * d.z, o.x * o.x + o.z * o.z - 1.0)
    {
        nearest.offer(ray, t0, SIDE, on_side(t0));
        nearest.offer(ray, t1, SIDE, on_side(t1));
    }
    let (bottom, top) = ((-1.0 - o.y) / d.y, (1.0 - o.y) / d.y);
    nearest.offer(ray, bottom, BOTTOM, on_cap(bottom));
    nearest.offer(ray, top, TOP, on_cap(top));
    nearest.hit()
}

/// The nearest candidate on a ray, found without branches, so that loops over rays become vector code.
#[derive(Clone, Copy)]
pub(super) struct NearestF32 {
    t: f64,
    face: u32,
}

impl NearestF32 {
    pub const NONE: Self = Self { t: f64::INFINITY, face: 0 };

    /// Takes a candidate if it is `valid`, on the ray and nearer.
    #[inline(always)]
    pub fn offer(&mut self, ray: &Ray, t: f32, face: u32, valid: bool) {
        let t = f64::from(t);
        let nearer = valid & (t > ray.t_min) & (t <= ray.t_max) & (t < self.t);
        (self.t, self.face) = if nearer { (t, face) } else { (self.t, self.face) };
    }

    #[inline(always)]
    pub fn hit(self) -> Option<(f64, u32)> {
        (self.t < f64::INFINITY).then_some((self.t, self.face))
    }
}

/// The surface of face `face` near `p` (object space).
#[inline(always)]
pub fn cylinder_surface(p: DVec3, face: u32) -> SurfacePoint {
    if face == SIDE {
        let n = DVec3::new(p.x, 0.0, p.z).normalize_or(DVec3::Z);
        SurfacePoint { point: DVec3::new(n.x, p.y.clamp(-1.0, 1.0), n.z), normal: n }
    } else {
        cap_surface(p, if face == BOTTOM { -1.0 } else { 1.0 })
    }
}

/// Texture coordinates at point `p` of face `face`: longitude and height on the side, the unit square on the caps.
#[inline(always)]
pub fn cylinder_uv(p: DVec3, face: u32) -> DVec2 {
    if face == SIDE { side_uv(p) } else { cap_uv(p, face) }
}

/// Texture coordinates on the side.
#[inline(always)]
pub(super) fn side_uv(p: DVec3) -> DVec2 {
    DVec2::new(longitude(p), 0.5 + 0.5 * p.y)
}

/// The unit disc at y = `side`, looking away from y = 0.
#[inline(always)]
pub(super) fn cap_surface(p: DVec3, side: f64) -> SurfacePoint {
    SurfacePoint { point: DVec3::new(p.x, side, p.z), normal: DVec3::Y * side }
}

/// Texture coordinates at point `p` of a cap of the cylinder or of the base of the cone: those of [`cylinder_uv`] and
/// [`cone_uv`], where there is nothing but these faces.
#[inline(always)]
pub fn cap_uv(p: DVec3, face: u32) -> DVec2 {
    let side = if face == BOTTOM { -1.0 } else { 1.0 };
    DVec2::new(0.5 + 0.5 * p.x, 0.5 - 0.5 * side * p.z)
}
