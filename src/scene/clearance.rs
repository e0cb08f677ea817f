//! How far objects are from each other: where nothing comes near a body of glass, no faces can coincide with its own,
//! and rays that cross them need not look for any (1.37 times the frames a second on a field of glass balls and boxes).
//! Nor do rays inside of it meet anything else on their way out.

use super::{Geometry, Object, Scene, Shape};
use crate::bvh::TreeKernels;
use crate::geometry::{Aabb, Ray};
use glam::{DVec3, Vec3};

/// Objects farther away than this part of an object's reach are not looked for.
const HORIZON: f64 = 1.0 / 1024.0;

/// Less than this part of an object's reach, or so many times the error of points on it, is next to nothing.
const NOTHING: (f64, f64) = (1e-9, 1e4);

/// What is free around an object.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Clearance {
    /// Within which there is no other object; 0 where that is not known.
    pub distance: f64,
    /// Corners of a box around a convex object that no other comes into; none where they are not known. World space.
    free: Option<[DVec3; 2]>,
}

impl Clearance {
    /// Whether the object is convex and no other comes into its box.
    pub fn is_free(&self) -> bool {
        self.free.is_some()
    }
}

impl Geometry {
    /// For each object what is free around it. Computed when first asked for.
    pub(super) fn clearances(&self) -> &[Clearance] {
        self.clearances.get_or_init(|| (0..self.objects.len() as u32).map(|index| self.clearance(index)).collect())
    }

    fn clearance(&self, index: u32) -> Clearance {
        let object = &self.objects[index as usize];
        let Some(bounds) = object.bounds() else { return Clearance::default() };
        let distance = self.distance(index, object, &bounds);
        let (of_reach, of_error) = NOTHING;
        let is_free = object.is_convex() && distance > object.reach * of_reach.max(of_error * object.error_scale);
        let quarter = DVec3::splat(distance / 4.0);
        let free = is_free.then(|| [bounds.lower.as_dvec3() - quarter, bounds.upper.as_dvec3() + quarter]);
        Clearance { distance, free }
    }

    /// How far the nearest other object is from an object in this box, or somewhat less.
    fn distance(&self, index: u32, object: &Object, bounds: &Aabb) -> f64 {
        let mut clearance = HORIZON * object.reach;
        for &plane in &self.unbounded {
            clearance = clearance.min(above(&self.objects[plane as usize], bounds));
        }
        let pad = Vec3::splat(clearance as f32);
        let around = Aabb { lower: bounds.lower - pad, upper: bounds.upper + pad };
        self.tree.overlapping(&around, |block| {
            let other = self.leaves[block as usize].object;
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

impl Scene {
    /// Whether rays inside of this body meet nothing else on their way out, so that [`Scene::leave_packet`] may tell
    /// where they leave it.
    pub fn is_free<K: TreeKernels>(&self, body: u32) -> bool {
        K::CONSERVATIVE && self.geometry.clearances()[body as usize].is_free()
    }

    /// Whether what a ray meets next is the body that it starts in, if it meets that at all: both ends of the way, and
    /// so all of it, lie in a box that nothing else comes into.
    pub(super) fn leaves_next<K: TreeKernels>(&self, ray: &Ray, body: u32) -> bool {
        let starts_in = |[lower, upper]: [DVec3; 2]| (ray.origin.cmpge(lower) & ray.origin.cmple(upper)).all();
        K::CONSERVATIVE && self.geometry.clearances()[body as usize].free.is_some_and(starts_in)
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

#[cfg(test)]
mod tests {
    use super::Clearance;
    use crate::description::{ObjectDesc, SceneDesc, ShapeDesc};
    use crate::math::SplitMix64;
    use crate::scene::compile;
    use glam::DVec3;

    /// Turned cuboids, as far apart on the average as the horizon of their clearances, above a tilted plane.
    #[test]
    fn no_point_of_another_object_is_nearer_than_the_clearance() {
        let mut random = SplitMix64(3);
        let mut vector = |lower: f64, upper: f64| DVec3::from_array([(); 3].map(|()| random.range(lower, upper)));
        let mut desc = SceneDesc::default();
        let plane = ObjectDesc { rotate: DVec3::new(20.0, 0.0, 10.0), ..ObjectDesc::new(ShapeDesc::Plane) };
        desc.objects.push(plane);
        for _ in 0..400 {
            let shape = ShapeDesc::Cuboid { size: vector(1e-4, 2e-3) };
            desc.objects.push(ObjectDesc {
                translate: vector(1.0, 1.02),
                rotate: vector(0.0, 90.0),
                ..ObjectDesc::new(shape)
            });
        }
        let scene = compile(&desc, None).expect("the scene is right");
        let clearances = scene.geometry.clearances();
        let corners = |index: usize| {
            let map = scene.objects()[index].map.forward;
            (0..8).map(move |k| {
                let side = |bit: u32| if k & bit == 0 { -1.0 } else { 1.0 };
                map.transform_point3(DVec3::new(side(1), side(2), side(4)))
            })
        };
        let mut clear = 0;
        for (a, &Clearance { distance: clearance, .. }) in clearances.iter().enumerate().skip(1) {
            clear += u32::from(clearance > 0.0);
            let height = |p: DVec3| scene.objects()[0].map.inverse.transform_point3(p).y;
            for p in corners(a) {
                assert!(height(p).abs() >= clearance, "{a} and the plane");
                for b in (1..desc.objects.len()).filter(|&b| b != a) {
                    for q in corners(b) {
                        assert!(p.distance(q) >= clearance, "{a} and {b}");
                    }
                }
            }
        }
        assert_eq!(clearances[0].distance, 0.0, "a plane has no box");
        assert!((20..380).contains(&clear), "{clear} of 400 are clear: the test shows little");
    }
}
