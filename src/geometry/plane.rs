//! The plane y = 0 and the quad in it.

use super::interaction::SurfacePoint;
use super::ray::Ray;
use glam::{DVec2, DVec3};

/// The hit with the infinite plane, in f64. A ray inside of the plane meets nothing.
#[inline(always)]
pub fn plane_intersect(ray: &Ray) -> Option<f64> {
    let t = -ray.origin.y / ray.direction.y;
    if ray.contains(t) { Some(t) } else { None }
}

/// The hit with the quad [-1, 1]², in f64, edges included.
#[inline(always)]
pub fn quad_intersect(ray: &Ray) -> Option<f64> {
    let t = plane_intersect(ray)?;
    let inside = |o: f64, d: f64| (o + t * d).abs() <= 1.0;
    (inside(ray.origin.x, ray.direction.x) && inside(ray.origin.z, ray.direction.z)).then_some(t)
}

/// The hit with the plane in f32.
#[inline(always)]
pub(super) fn plane_intersect_f32(ray: &Ray) -> Option<f64> {
    let t = f64::from(-(ray.origin.y as f32) / (ray.direction.y as f32));
    if ray.contains(t) { Some(t) } else { None }
}

/// The hit with the quad in f32.
#[inline(always)]
pub(super) fn quad_intersect_f32(ray: &Ray) -> Option<f64> {
    let t = plane_intersect_f32(ray)?;
    let inside = |o: f64, d: f64| (o as f32 + t as f32 * d as f32).abs() <= 1.0;
    (inside(ray.origin.x, ray.direction.x) && inside(ray.origin.z, ray.direction.z)).then_some(t)
}

/// The surface of the plane or quad near `p` (object space).
#[inline(always)]
pub fn plane_surface(p: DVec3) -> SurfacePoint {
    SurfacePoint { point: DVec3::new(p.x, 0.0, p.z), normal: DVec3::Y }
}

/// Texture coordinates on the plane: scene units, v toward -z.
#[inline(always)]
pub fn plane_uv(p: DVec3) -> DVec2 {
    DVec2::new(p.x, -p.z)
}

/// Texture coordinates on the quad: the unit square, v toward -z.
#[inline(always)]
pub fn quad_uv(p: DVec3) -> DVec2 {
    DVec2::new(0.5 + 0.5 * p.x, 0.5 - 0.5 * p.z)
}
