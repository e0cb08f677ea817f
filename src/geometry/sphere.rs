//! The sphere: of any centre and radius, since balls that are only moved, turned and evenly scaled are met in world
//! space without a transform.

use super::interaction::SurfacePoint;
use super::quadratic::classic_roots_f32;
use super::ray::Ray;
use crate::math::atan2;
use glam::{DVec2, DVec3, Vec3};
use std::f64::consts::FRAC_1_PI;

/// The first root on the ray, in f64: discriminant from the vector of closest approach and roots in q-form (Haines,
/// Günther, Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems 2019, ch. 7). A ray
/// from afar is first advanced to its closest approach.
#[inline(always)]
pub fn sphere_intersect(ray: &Ray, centre: DVec3, radius: f64) -> Option<f64> {
    if leaves_sphere(ray, centre, radius) { None } else { first_root(ray, centre, radius) }
}

#[inline(always)]
fn first_root(ray: &Ray, centre: DVec3, radius: f64) -> Option<f64> {
    let d = ray.direction;
    let a = d.length_squared();
    let mut f = ray.origin - centre;
    let mut t0 = 0.0;
    if f.length_squared() > 64.0 * radius * radius {
        t0 = -f.dot(d) / a;
        f += d * t0;
    }
    let b = f.dot(d);
    // |f - (b/a) d| is the distance of the line from the centre.
    let disc = radius * radius - (f - d * (b / a)).length_squared();
    if disc < 0.0 {
        return None;
    }
    let distance = f.length();
    let c = (distance - radius) * (distance + radius);
    let (near, far) = super::quadratic::roots(a, b, c, (a * disc).sqrt());
    let (near, far) = (near + t0, far + t0);
    if ray.contains(near) { Some(near) } else { (near <= ray.t_min && ray.contains(far)).then_some(far) }
}

/// Whether a ray starts outside of a sphere and goes away from it, as most do from the ball that they come from: there
/// is no root then, and none of the divisions is needed.
///
/// With b > 0 and c >= 0 in [`first_root`], q is negative and so are both roots, or one is 0, however they are rounded;
/// with b = 0 the discriminant is negative. The factor is more than the rounding of squares, and square roots are
/// monotone.
#[inline(always)]
pub fn leaves_sphere(ray: &Ray, centre: DVec3, radius: f64) -> bool {
    let f = ray.origin - centre;
    let f2 = f.length_squared();
    // Those that are far away are advanced first.
    let near = f2 <= 64.0 * radius * radius;
    near & (f2 >= radius * radius * (1.0 + 8.0 * f64::EPSILON)) & (f.dot(ray.direction) >= 0.0) & (ray.t_min >= 0.0)
}

/// The school formula in f32.
#[inline(always)]
pub(super) fn sphere_intersect_f32(ray: &Ray, centre: DVec3, radius: f64) -> Option<f64> {
    let (o, d): (Vec3, Vec3) = ((ray.origin.as_vec3() - centre.as_vec3()), ray.direction.as_vec3());
    let r = radius as f32;
    let [near, far] = classic_roots_f32(d.dot(d), o.dot(d), o.dot(o) - r * r)?.map(f64::from);
    if ray.contains(near) { Some(near) } else { ray.contains(far).then_some(far) }
}

/// The surface of the unit sphere near `p` (object space).
#[inline(always)]
pub fn sphere_surface(p: DVec3) -> SurfacePoint {
    let n = p.normalize_or(DVec3::Y);
    SurfacePoint { point: n, normal: n }
}

/// Texture coordinates at a point in the direction `p` from the centre, which need not be of unit length: longitude and
/// latitude.
#[inline(always)]
pub fn sphere_uv(p: DVec3) -> DVec2 {
    // Not by the arc sine of the height, which next to the poles loses half of the digits.
    DVec2::new(longitude(p), 0.5 + atan2(p.y, (p.x * p.x + p.z * p.z).sqrt()) * FRAC_1_PI)
}

/// The part of a turn about the y axis from -z on, by way of -x. The axis itself is half-way: atan2(0, 0) is 0.
#[inline(always)]
pub(super) fn longitude(p: DVec3) -> f64 {
    0.5 + atan2(p.x, p.z) * (0.5 * FRAC_1_PI)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SplitMix64;

    #[test]
    fn a_ray_that_leaves_a_sphere_has_no_root_on_it() {
        let mut rng = SplitMix64(51);
        let (mut leaving, mut met) = (0, 0);
        for i in 0..2_000_000 {
            let size = 2f64.powi((rng.next_u64() % 40) as i32 - 20);
            let mut vector = || DVec3::new(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
            let (centre, radius) = (vector() * size, vector().x.abs() + 1e-9);
            // On the surface or a few ulps off it, in any direction or along it.
            let normal = vector().normalize();
            let off = 1.0 + [0.0, 1e-16, 3e-16, 1e-15, 2e-15, 1e-14, 1e-9, -1e-16, -1e-15][i % 9];
            let mut direction = vector().normalize();
            if i % 2 == 0 {
                let along = (direction - normal * direction.dot(normal)).normalize();
                direction = along + normal * [0.0, 1e-17, 1e-16, 1e-12, -1e-16][i % 5];
            }
            let ray = Ray::new(centre + normal * (radius * off), direction * [1.0, 1e-3, 7.0][i % 3]);
            let root = first_root(&ray, centre, radius);
            if leaves_sphere(&ray, centre, radius) {
                assert_eq!(root, None, "{ray:?} {centre:?} {radius:?}");
                leaving += 1;
            }
            met += u32::from(root.is_some());
        }
        assert!(leaving > 200_000 && met > 200_000, "{leaving} leave, {met} meet it");
    }
}
