//! Triangles of f32 corners.

use super::ray::Ray;
use glam::Vec3;

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
        // Two axes in cyclic order: the sign of the largest component does not matter, since edge functions are compared
        // with each other only.
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][z];
        let [x, y, z] = axes;
        let inverse = 1.0 / d[z];
        Self { axes, origin: [o[x], o[y], o[z]], shear: [d[x] * inverse, d[y] * inverse, inverse], t_min: ray.t_min }
    }

    /// Of the numbers that [`TriangleRay::new`] finds.
    #[inline(always)]
    pub fn from_parts(axes: [usize; 3], origin: [f64; 3], shear: [f64; 3], t_min: f64) -> Self {
        Self { axes, origin, shear, t_min }
    }

    /// [`TriangleRay::intersect_permuted`] for corners in the order of space.
    #[inline(always)]
    pub fn intersect(&self, corners: &[Vec3; 3], t_max: f64) -> Option<(f64, f64, f64)> {
        let corners = corners.map(|p| p.to_array());
        self.intersect_permuted(corners.map(|p| self.axes.map(|k| p[k])), t_max)
    }

    /// `(t, u, v)` of the hit with t_min < t <= `t_max`, where u and v are the weights of the second and third corner. The
    /// corners have their coordinates in the order of `axes`.
    ///
    /// Edges belong to both of their triangles: products of f64 differences round monotonically, so an edge function has
    /// the right sign or is 0, and 0 counts as inside. Neighbours compute the same two products and can not both
    /// reject. No fused multiply-add may be used here: it would break that symmetry.
    #[inline(always)]
    pub fn intersect_permuted(&self, [a, b, c]: [[f32; 3]; 3], t_max: f64) -> Option<(f64, f64, f64)> {
        let [ox, oy, oz] = self.origin;
        let [sx, sy, sz] = self.shear;
        let (az, bz, cz) = (f64::from(a[2]) - oz, f64::from(b[2]) - oz, f64::from(c[2]) - oz);
        let (ax, ay) = ((f64::from(a[0]) - ox) - sx * az, (f64::from(a[1]) - oy) - sy * az);
        let (bx, by) = ((f64::from(b[0]) - ox) - sx * bz, (f64::from(b[1]) - oy) - sy * bz);
        let (cx, cy) = ((f64::from(c[0]) - ox) - sx * cz, (f64::from(c[1]) - oy) - sy * cz);
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        // One branch for both signs: which of the edge functions is negative can not be predicted.
        let negative = (u < 0.0) | (v < 0.0) | (w < 0.0);
        let positive = (u > 0.0) | (v > 0.0) | (w > 0.0);
        let det = u + v + w;
        if (negative & positive) | (det == 0.0) {
            return None;
        }
        let inverse = 1.0 / det;
        let t = (u * az + v * bz + w * cz) * sz * inverse;
        (t > self.t_min && t <= t_max).then_some((t, v * inverse, w * inverse))
    }
}
