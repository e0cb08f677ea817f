//! Triangles of f32 corners.

use super::ray::Ray;
use glam::{DVec3, Vec3};

/// A ray prepared for the watertight triangle test of Woop, Benthin and Wald (JCGT 2(1) 2013), in f64 on f32 corners:
/// permuted and sheared so that it runs along its largest axis.
#[derive(Clone, Copy, Debug)]
pub struct TriangleRay {
    /// Start of the ray.
    pub origin: DVec3,
    /// The axes called x, y and z here: z is the one of the largest component of the direction.
    pub axes: [usize; 3],
    /// (dx / dz, dy / dz, 1 / dz).
    pub shear: DVec3,
    t_min: f64,
}

impl TriangleRay {
    /// Prepares a ray of the mesh's space.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let z = d.abs().max_position();
        // Two axes in cyclic order: the sign of the largest component does not matter, since edge functions are compared
        // with each other only.
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        Self {
            origin: ray.origin,
            axes: [x, y, z],
            shear: DVec3::new(d[x] / d[z], d[y] / d[z], 1.0 / d[z]),
            t_min: ray.t_min,
        }
    }

    /// `(t, u, v)` of the hit with t_min < t <= `t_max`, where u and v are the weights of the second and third corner.
    ///
    /// Edges belong to both of their triangles: products of f64 differences round monotonically, so an edge function has
    /// the right sign or is 0, and 0 counts as inside. Neighbours compute the same two products and can not both
    /// reject. No fused multiply-add may be used here: it would break that symmetry.
    #[inline(always)]
    pub fn intersect(&self, corners: &[Vec3; 3], t_max: f64) -> Option<(f64, f64, f64)> {
        let [x, y, z] = self.axes;
        let [a, b, c] = corners.map(|p| p.as_dvec3() - self.origin);
        let (ax, ay) = (a[x] - self.shear.x * a[z], a[y] - self.shear.y * a[z]);
        let (bx, by) = (b[x] - self.shear.x * b[z], b[y] - self.shear.y * b[z]);
        let (cx, cy) = (c[x] - self.shear.x * c[z], c[y] - self.shear.y * c[z]);
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }
        let t = (u * a[z] + v * b[z] + w * c[z]) * self.shear.z / det;
        (t > self.t_min && t <= t_max).then(|| (t, v / det, w / det))
    }
}
