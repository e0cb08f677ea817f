//! The presets of arithmetic: one type each, chosen once a render.

use super::interaction::refract;
use super::ray::Ray;
use super::{cone, cuboid, cylinder, plane, sphere};
use crate::math::pow;
use glam::DVec3;

/// How shapes are met and how rays start from surfaces; boxes and triangles follow in `bvh`. The methods of one preset
/// belong together: offsets are as large as the errors of its hit points.
///
/// The provided methods are those of [`Robust`]: f64 in the forms that do not cancel.
pub trait Kernels: Copy + Send + Sync + 'static {
    /// `t_min` of rays that start on a surface. Nothing but [`Classic`] needs one.
    const T_MIN: f64 = 0.0;

    /// See [`sphere_intersect`](super::sphere_intersect).
    #[inline(always)]
    fn sphere(ray: &Ray, centre: DVec3, radius: f64) -> Option<f64> {
        sphere::sphere_intersect(ray, centre, radius)
    }

    /// See [`cuboid_intersect`](super::cuboid_intersect).
    #[inline(always)]
    fn cuboid(ray: &Ray) -> Option<(f64, u32)> {
        cuboid::cuboid_intersect(ray)
    }

    /// See [`cylinder_intersect`](super::cylinder_intersect).
    #[inline(always)]
    fn cylinder(ray: &Ray) -> Option<(f64, u32)> {
        cylinder::cylinder_intersect(ray)
    }

    /// See [`cone_intersect`](super::cone_intersect).
    #[inline(always)]
    fn cone(ray: &Ray) -> Option<(f64, u32)> {
        cone::cone_intersect(ray)
    }

    /// See [`plane_intersect`](super::plane_intersect).
    #[inline(always)]
    fn plane(ray: &Ray) -> Option<f64> {
        plane::plane_intersect(ray)
    }

    /// See [`quad_intersect`](super::quad_intersect).
    #[inline(always)]
    fn quad(ray: &Ray) -> Option<f64> {
        plane::quad_intersect(ray)
    }

    /// The point where rays from this hit start, and how far along the normal they must be moved off the surface.
    /// `on_surface` is the hit projected onto the surface, `bound` the error bound of that projection (world space).
    #[inline(always)]
    fn surface_point(_ray: &Ray, _t: f64, on_surface: DVec3, bound: f64) -> (DVec3, f64) {
        (on_surface, bound)
    }

    /// The ray from `origin` up to just before `target`; `None` if they are the same point.
    #[inline(always)]
    fn ray_to(origin: DVec3, target: DVec3) -> Option<Ray> {
        let way = target - origin;
        let distance = way.length();
        // Ends one part in 2^40 before the target: a blocker on the light itself does not count.
        let t_max = distance * (1.0 - 2f64.powi(-40));
        (distance > 0.0).then(|| Ray { origin, direction: way / distance, t_min: Self::T_MIN, t_max })
    }

    /// The refracted direction, `None` for total internal reflection; see [`refract`]. `entering`: into the body.
    #[inline(always)]
    fn refract(direction: DVec3, normal: DVec3, eta: f64, _entering: bool) -> Option<DVec3> {
        refract(direction, normal, eta)
    }

    /// (v, r)^s, 0 where the two point away from each other.
    #[inline(always)]
    fn highlight(cosine: f64, shininess: f64) -> f64 {
        let within = if cosine > f64::MIN_POSITIVE { cosine } else { f64::MIN_POSITIVE };
        let power = pow(if within < 1.0 { within } else { 1.0 }, shininess);
        if cosine > 0.0 { power } else { 0.0 }
    }
}

/// The default: f64 rays over f32 boxes with proven pads, watertight triangles, error bounds instead of epsilons.
#[derive(Clone, Copy, Debug)]
pub struct Robust;

impl Kernels for Robust {}

/// The yardstick: as [`Robust`], and the boxes in f64 as well.
#[derive(Clone, Copy, Debug)]
pub struct Reference;

impl Kernels for Reference {}

/// The quick usual practice: school formulas in f32, Möller-Trumbore, an offset of 8 f32 ulp of the largest number.
#[derive(Clone, Copy, Debug)]
pub struct Fast;

/// The kernels in f32 that [`Fast`] and [`Classic`] share.
macro_rules! single_precision_shapes {
    () => {
        #[inline(always)]
        fn sphere(ray: &Ray, centre: DVec3, radius: f64) -> Option<f64> {
            sphere::sphere_intersect_f32(ray, centre, radius)
        }

        #[inline(always)]
        fn cuboid(ray: &Ray) -> Option<(f64, u32)> {
            cuboid::cuboid_intersect_f32(ray)
        }

        #[inline(always)]
        fn cylinder(ray: &Ray) -> Option<(f64, u32)> {
            cylinder::cylinder_intersect_f32(ray)
        }

        #[inline(always)]
        fn cone(ray: &Ray) -> Option<(f64, u32)> {
            cone::cone_intersect_f32(ray)
        }

        #[inline(always)]
        fn plane(ray: &Ray) -> Option<f64> {
            plane::plane_intersect_f32(ray)
        }

        #[inline(always)]
        fn quad(ray: &Ray) -> Option<f64> {
            plane::quad_intersect_f32(ray)
        }
    };
}

impl Kernels for Fast {
    single_precision_shapes!();

    #[inline(always)]
    fn surface_point(ray: &Ray, t: f64, _on_surface: DVec3, _bound: f64) -> (DVec3, f64) {
        let point = (ray.origin.as_vec3() + ray.direction.as_vec3() * t as f32).as_dvec3();
        let size = point.length().max(ray.origin.length()).max(t);
        (point, 8.0 * f64::from(f32::EPSILON) * size)
    }
}

/// The coursework's formulas as published, mistakes included: f32, determinants up to 1e-6 taken for parallel, epsilon
/// 1e-4 along rays of any length, shadow rays not normalised, the ratio of indices never inverted, total internal
/// reflection not noticed, negative bases in the highlight. Kept to be compared with.
#[derive(Clone, Copy, Debug)]
pub struct Classic;

impl Kernels for Classic {
    single_precision_shapes!();

    const T_MIN: f64 = 1e-4;

    #[inline(always)]
    fn surface_point(ray: &Ray, t: f64, _on_surface: DVec3, _bound: f64) -> (DVec3, f64) {
        ((ray.origin.as_vec3() + ray.direction.as_vec3() * t as f32).as_dvec3(), 0.0)
    }

    #[inline(always)]
    fn ray_to(origin: DVec3, target: DVec3) -> Option<Ray> {
        Some(Ray { origin, direction: target - origin, t_min: Self::T_MIN, t_max: 1.0 })
    }

    #[inline(always)]
    fn refract(direction: DVec3, normal: DVec3, eta: f64, entering: bool) -> Option<DVec3> {
        let (d, n) = (direction.as_vec3(), normal.as_vec3());
        let eta = (if entering { eta } else { 1.0 / eta }) as f32;
        let cos = -d.dot(n);
        Some((d * eta + n * (eta * cos - (1.0 - eta * eta * (1.0 - cos * cos)).sqrt())).as_dvec3())
    }

    #[inline(always)]
    fn highlight(cosine: f64, shininess: f64) -> f64 {
        f64::from((cosine as f32).powf(shininess as f32))
    }
}
