//! What is known of a surface where a ray meets it, and the directions in which rays leave it.

use super::kernels::Kernels;
use super::ray::{Hit, Ray};
use glam::DVec3;

/// A point of a shape in object space, projected onto its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// On the surface to within rounding of its coordinates.
    pub point: DVec3,
    /// Outward; unit length in object space.
    pub normal: DVec3,
}

/// Everything shading wants to know of a hit, in world space; built once, for the winner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceInteraction {
    /// On the surface.
    pub point: DVec3,
    /// Bound on the distance between `point` and the surface as later rays meet it.
    pub point_error: f64,
    /// Unit, out of the body.
    pub geometric_normal: DVec3,
    /// Unit, out of the body; differs from the geometric one on smooth meshes.
    pub shading_normal: DVec3,
    /// Start of shadow rays: `point`, lifted to the smooth surface where a flat triangle stands for one (Hanika,
    /// "Hacking the Shadow Terminator", Ray Tracing Gems II 2021, ch. 4).
    pub shadow_point: DVec3,
    /// What was hit; texture coordinates follow from it where they are wanted.
    pub hit: Hit,
    /// Index of the material in the scene.
    pub material: u32,
    /// Whether the ray goes into the body.
    pub entering: bool,
}

impl SurfaceInteraction {
    /// A ray that leaves the surface in this unit direction.
    #[inline]
    pub fn spawn_ray<K: Kernels>(&self, direction: DVec3) -> Ray {
        spawn_ray::<K>(self.point, self.geometric_normal, self.point_error, direction)
    }

    /// The side that the viewer is on: 1 outside of the body, -1 inside.
    #[inline]
    pub fn side(&self) -> f64 {
        if self.entering { 1.0 } else { -1.0 }
    }

    /// Where shadow rays start.
    #[inline]
    pub fn shadow_start(&self) -> ShadowStart {
        ShadowStart::new(self.shadow_point, self.geometric_normal, self.side(), self.point_error)
    }
}

/// A ray that leaves a surface in this unit direction, started off the surface by its error bound, on the side that it
/// goes to. The only maker of reflected and refracted rays. The numbers are those of [`SurfaceInteraction`].
#[inline(always)]
pub fn spawn_ray<K: Kernels>(point: DVec3, geometric_normal: DVec3, point_error: f64, direction: DVec3) -> Ray {
    let side = if direction.dot(geometric_normal) < 0.0 { -1.0 } else { 1.0 };
    let origin = point + geometric_normal * (side * point_error);
    Ray { t_min: K::T_MIN, ..Ray::new(origin, direction) }
}

/// Takes the normals of a triangle's corners (world space, unit, outward) for a smooth surface: the shading normal at a
/// point, and the point lifted for shadow rays. `weights` of the corners there; `entering`: into the body.
#[inline(always)]
pub fn smooth(
    point: DVec3,
    geometric_normal: DVec3,
    entering: bool,
    corners: [DVec3; 3],
    normals: [DVec3; 3],
    weights: [f64; 3],
) -> (DVec3, DVec3) {
    let mut normal = DVec3::ZERO;
    let mut lift = DVec3::ZERO;
    // The side that the ray comes from is the one that is lit.
    let side = if entering { 1.0 } else { -1.0 };
    for k in 0..3 {
        let n = normals[k] * side;
        normal += normals[k] * weights[k];
        // How far the point lies below the tangent plane of this corner.
        let below = (point - corners[k]).dot(n).min(0.0);
        lift -= n * (below * weights[k]);
    }
    (normal.normalize_or(geometric_normal), point + lift)
}

/// Where the shadow rays of a surface start, whatever light they go to: the only maker of shadow rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowStart(DVec3);

impl ShadowStart {
    /// Off the surface on the side that the viewer is on; the numbers are those of [`SurfaceInteraction`].
    #[inline(always)]
    pub fn new(shadow_point: DVec3, geometric_normal: DVec3, side: f64, point_error: f64) -> Self {
        Self(shadow_point + geometric_normal * (side * point_error))
    }

    /// A start that has been computed before.
    #[inline(always)]
    pub fn at(point: DVec3) -> Self {
        Self(point)
    }

    /// Where it is.
    #[inline(always)]
    pub fn point(self) -> DVec3 {
        self.0
    }

    /// The shadow ray to a point; `None` if it is that point.
    #[inline(always)]
    pub fn ray_to<K: Kernels>(self, target: DVec3) -> Option<Ray> {
        K::ray_to(self.0, target)
    }

    /// The shadow ray toward a light that is infinitely far in this unit direction.
    #[inline(always)]
    pub fn ray_along<K: Kernels>(self, direction: DVec3) -> Ray {
        Ray { t_min: K::T_MIN, ..Ray::new(self.0, direction) }
    }
}

/// A reflected ray that would enter a smooth surface is turned to this sine above the facet.
const GRAZING: f64 = 1.0 / 1024.0;

/// `direction` mirrored at a unit normal.
#[inline(always)]
pub fn mirror(direction: DVec3, normal: DVec3) -> DVec3 {
    (direction - normal * (2.0 * direction.dot(normal))).normalize_or(normal)
}

/// `direction` mirrored at the shading normal, kept above the facet: smooth normals can point it below (Keller et al.,
/// "The Iray Light Transport Simulation", 2017, appendix A.3 states the problem). Both normals unit, on the side that
/// `direction` comes from.
#[inline(always)]
pub fn reflect(direction: DVec3, shading_normal: DVec3, geometric_normal: DVec3) -> DVec3 {
    let mirrored = direction - shading_normal * (2.0 * direction.dot(shading_normal));
    let above = mirrored.dot(geometric_normal);
    if above >= GRAZING || shading_normal == geometric_normal {
        return mirrored.normalize_or(geometric_normal);
    }
    (mirrored + geometric_normal * (GRAZING - above)).normalize_or(geometric_normal)
}

/// Snell's law: the direction behind a surface, or `None` for total internal reflection. `direction` and `normal` unit,
/// `normal` on the side that `direction` comes from, `eta` the index before the surface over the one behind it.
#[inline(always)]
pub fn refract(direction: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    if eta == 1.0 {
        return Some(direction); // Index-matched: not bent, not even by rounding.
    }
    let cos_in = -direction.dot(normal);
    // The tangential part keeps the digits of the sine near normal incidence.
    let tangential = (direction + normal * cos_in) * eta;
    let cos2_out = 1.0 - tangential.length_squared();
    (cos2_out >= 0.0).then(|| (tangential - normal * cos2_out.sqrt()).normalize_or(direction))
}

/// Fresnel's reflectance of unpolarised light, exact. `cos_in` and `cos_out` are the cosines on either side, `eta` as
/// in [`refract`].
#[inline(always)]
pub fn fresnel(cos_in: f64, cos_out: f64, eta: f64) -> f64 {
    if eta == 1.0 {
        return 0.0;
    }
    let (s, p) =
        ((eta * cos_in - cos_out) / (eta * cos_in + cos_out), (cos_in - eta * cos_out) / (cos_in + eta * cos_out));
    ((s * s + p * p) / 2.0).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_incidence_reflects_the_textbook_fraction() {
        assert!((fresnel(1.0, 1.0, 1.0 / 1.5) - 0.04).abs() < 1e-15);
    }

    #[test]
    fn refraction_obeys_snell_and_turns_total_past_the_critical_angle() {
        for i in 1..900 {
            let angle = f64::from(i) / 10.0;
            let (sin, cos) = angle.to_radians().sin_cos();
            let d = DVec3::new(sin, -cos, 0.0);
            let into = refract(d, DVec3::Y, 1.0 / 1.5).unwrap();
            assert!((into.x - sin / 1.5).abs() < 1e-15 && into.y < 0.0);
            match refract(d, DVec3::Y, 1.5) {
                Some(out) => assert!((out.x - sin * 1.5).abs() < 1e-14),
                None => assert!(sin * 1.5 > 1.0),
            }
        }
    }

    #[test]
    fn a_mirrored_ray_never_goes_below_the_facet() {
        let shading = DVec3::new(0.6, 0.8, 0.0);
        let d = DVec3::new(0.999, -0.02, 0.0).normalize();
        let plain = d - shading * (2.0 * d.dot(shading));
        assert!(reflect(d, shading, DVec3::Y).y > 0.0 && plain.is_finite());
    }
}
