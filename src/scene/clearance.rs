//! How far objects are from each other: where nothing comes near a body of glass, no faces can coincide with its own, and rays
//! that cross them need not look for any (1.37 times the frames a second on a field of glass balls and boxes).

use super::{Geometry, Object, Shape};
use crate::geometry::Aabb;
use glam::{DVec3, Vec3};

/// Objects farther away than this part of an object's reach are not looked for.
const HORIZON: f64 = 1.0 / 1024.0;

impl Geometry {
    /// For each object a distance within which there is no other; 0 where that is not known. Computed when first asked for.
    pub(super) fn clearances(&self) -> &[f64] {
        self.clearances.get_or_init(|| (0..self.objects.len() as u32).map(|index| self.clearance(index)).collect())
    }

    fn clearance(&self, index: u32) -> f64 {
        let object = &self.objects[index as usize];
        let Some(bounds) = object.bounds() else { return 0.0 };
        let mut clearance = HORIZON * object.reach;
        for &plane in &self.unbounded {
            clearance = clearance.min(above(&self.objects[plane as usize], &bounds));
        }
        let pad = Vec3::splat(clearance as f32);
        let around = Aabb { lower: bounds.lower - pad, upper: bounds.upper + pad };
        self.tree.overlapping(&around, |block| {
            let other = self.bounded[block as usize];
            if other != index
                && let Some(other) = self.objects[other as usize].bounds()
            {
                clearance = clearance.min(bounds.distance(&other));
            }
            clearance == 0.0
        });
        clearance
    }
}

/// How far a box is from a plane; 0 if they meet.
fn above(plane: &Object, bounds: &Aabb) -> f64 {
    debug_assert!(matches!(plane.shape, Shape::Plane));
    let normal = (plane.map.normal * DVec3::Y).normalize_or(DVec3::Y);
    let (lower, upper) = (bounds.lower.as_dvec3(), bounds.upper.as_dvec3());
    let (centre, half) = ((lower + upper) / 2.0, (upper - lower) / 2.0);
    let height = normal.dot(centre - plane.map.forward.translation).abs();
    (height - normal.abs().dot(half)).max(0.0)
}
