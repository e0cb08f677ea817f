//! Triangles of f32 corners.

use super::interaction::SurfacePoint;
use super::ray::Ray;
use crate::math::Four;
use glam::{DVec3, DVec4, Vec3};

/// A ray prepared for the watertight triangle test of Woop, Benthin and Wald (JCGT 2(1) 2013), in f64 on f32 corners:
/// permuted and sheared so that it runs along its largest axis.
#[derive(Clone, Copy, Debug)]
pub struct TriangleRay {
    /// The axes called x, y and z here: z is the one of the largest component of the direction.
    pub axes: [usize; 3],
    /// Start of the ray along these axes.
    pub origin: [f64; 3],
    /// (dx / dz, dy / dz, 1 / dz).
    pub shear: [f64; 3],
    t_min: f64,
}

/// The other axes in cyclic order before the one called z: its sign does not matter, since edge functions are compared
/// with each other only. (Not a constant, of which the compiler makes a copy on the stack for every ray.)
static CYCLIC: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

impl TriangleRay {
    /// Prepares a ray of the mesh's space.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        // Arrays, since indexing a vector of glam is a chain of branches.
        let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
        let size = d.map(f64::abs);
        let z = if size[0] > size[1] {
            if size[0] > size[2] { 0 } else { 2 }
        } else if size[1] > size[2] {
            1
        } else {
            2
        };
        let axes = CYCLIC[z];
        let [x, y, z] = axes;
        let inverse = 1.0 / d[z];
        Self { axes, origin: [o[x], o[y], o[z]], shear: [d[x] * inverse, d[y] * inverse, inverse], t_min: ray.t_min }
    }

    /// Of the numbers that [`TriangleRay::new`] finds.
    #[inline(always)]
    pub fn from_parts(axes: [usize; 3], origin: [f64; 3], shear: [f64; 3], t_min: f64) -> Self {
        Self { axes, origin, shear, t_min }
    }

    /// [`TriangleRay::intersect_corners`] for corners in the order of space.
    #[inline(always)]
    pub fn intersect(&self, [a, b, c]: &[Vec3; 3], t_max: f64) -> Option<(f64, f64, f64)> {
        let axis = |k: usize| DVec4::new(a[k].into(), b[k].into(), c[k].into(), 0.0);
        self.intersect_corners(self.axes.map(axis), t_max)
    }

    /// [`TriangleRay::intersect_corners`] for corners that have their coordinates in the order of `axes`.
    #[inline(always)]
    pub fn intersect_permuted(&self, [a, b, c]: [[f32; 3]; 3], t_max: f64) -> Option<(f64, f64, f64)> {
        let axis = |k: usize| DVec4::new(a[k].into(), b[k].into(), c[k].into(), 0.0);
        self.intersect_corners([axis(0), axis(1), axis(2)], t_max)
    }

    /// `(t, u, v)` of the hit with t_min < t <= `t_max`, where u and v are the weights of the second and third corner.
    /// Takes the x of the corners, their y and their z (along `axes`), and a finite fourth that does not matter. (All
    /// corners at once: 2 to 7 % of robust rays against one number after the other, with the same bits.)
    ///
    /// Edges belong to both of their triangles: products of f64 differences round monotonically, so an edge function
    /// has the right sign or is 0, and 0 counts as inside. Neighbours compute the same two products and can not both
    /// reject. No fused multiply-add may be used here: it would break that symmetry.
    #[inline(always)]
    pub fn intersect_corners<F: Four>(&self, [x, y, z]: [F; 3], t_max: f64) -> Option<(f64, f64, f64)> {
        let [ox, oy, oz] = self.origin.map(|o| x.splat(o));
        let [sx, sy, sz] = self.shear;
        let z = z - oz;
        let x = (x - ox) - z * sx;
        let y = (y - oy) - z * sy;
        // cx by - cy bx, ax cy - ay cx, bx ay - by ax, and a product less itself.
        let edges = x.zxyw() * y.yzxw() - y.zxyw() * x.yzxw();
        // One branch for both signs: which of the edge functions is negative can not be predicted.
        let mixed = (edges.negative() != 0) & (edges.positive() != 0);
        let [u, v, w, _] = edges.to_array();
        let det = u + v + w;
        if mixed | (det == 0.0) {
            return None;
        }
        let inverse = 1.0 / det;
        let [uz, vz, wz, _] = (edges * z).to_array();
        let t = (uz + vz + wz) * sz * inverse;
        (t > self.t_min && t <= t_max).then_some((t, v * inverse, w * inverse))
    }
}

/// The surface at weights u, v of the second and third corner: on the facet's plane to within rounding.
#[inline(always)]
pub fn triangle_surface([a, b, c]: [DVec3; 3], u: f64, v: f64) -> SurfacePoint {
    let point = a + (b - a) * u + (c - a) * v;
    SurfacePoint { point, normal: (b - a).cross(c - a).normalize_or(DVec3::Y) }
}
