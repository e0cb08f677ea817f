//! Rays against the whole scene.

use super::front::passes;
use super::leaf::{AnyObject, AnyOccluder, Closest, Leaf};
use super::{Geometry, Object, Scene, Shape};
use crate::bvh::{LeafVisitor, TreeKernels};
use crate::geometry::{Hit, Ray};
use glam::DVec3;

impl Object {
    /// The closest hit of a world-space ray with this object alone. `index` is its own.
    pub fn intersect<K: TreeKernels>(&self, ray: &Ray, index: u32) -> Option<Hit> {
        let local = || ray.transformed(&self.map.inverse);
        let face = |(t, primitive): (f64, u32)| Hit { t, object: index, primitive, u: 0.0, v: 0.0 };
        let whole = |t: f64| face((t, 0));
        match &self.shape {
            Shape::Ball { centre, radius } => K::sphere(ray, *centre, *radius).map(whole),
            Shape::Ellipsoid => K::sphere(&local(), DVec3::ZERO, 1.0).map(whole),
            Shape::Cuboid => K::cuboid(&local()).map(face),
            Shape::Cylinder => K::cylinder(&local()).map(face),
            Shape::Cone => K::cone(&local()).map(face),
            Shape::Plane => K::plane(&local()).map(whole),
            Shape::Quad => K::quad(&local()).map(whole),
            Shape::Mesh(mesh) => {
                let hit = mesh.intersect::<K>(&local())?;
                Some(Hit { t: hit.t, object: index, primitive: hit.triangle, u: hit.u, v: hit.v })
            }
        }
    }

    /// Whether a world-space ray meets this object, if that can be said without going through a tree; else `false`.
    pub(super) fn is_occluded_quickly<K: TreeKernels>(&self, ray: &Ray) -> bool {
        !matches!(self.shape, Shape::Mesh(_)) && self.occluded::<K>(ray)
    }

    /// Whether a world-space ray meets this object.
    pub(super) fn occluded<K: TreeKernels>(&self, ray: &Ray) -> bool {
        match &self.shape {
            Shape::Mesh(mesh) => mesh.occluded::<K>(&ray.transformed(&self.map.inverse)),
            _ => self.intersect::<K>(ray, 0).is_some(),
        }
    }
}

impl Scene {
    /// The closest hit of a world-space ray; of several in the same place that of the smallest object (see
    /// [`Hit::beats`]).
    pub fn intersect<K: TreeKernels>(&self, ray: &Ray) -> Option<Hit> {
        let geometry = &*self.geometry;
        if self.is_simple() {
            // One after the other, as packets do: of three objects in a chain of ties the order decides (see
            // `Hit::beats`), and where the boxes of a tree may lose hits it would find something else.
            let mut closest = Closest::<K>::new((self, None), ray);
            self.near(ray).fold(ray.t_max, |t_max, index| closest.test(index, t_max));
            return closest.best;
        }
        let mut unbounded = Closest::<K>::new((self, None), ray);
        let t_max = geometry.unbounded.iter().fold(ray.t_max, |t_max, &index| unbounded.test(index, t_max));
        let best = unbounded.best;
        geometry.tree.traverse::<K::Boxes, Closest<K>>(&Ray { t_max, ..*ray }, (self, best))
    }

    /// Whether a world-space ray meets anything before its end.
    pub fn occluded<K: TreeKernels>(&self, ray: &Ray) -> bool {
        self.occluder::<K>(ray).is_some()
    }

    /// Something that a world-space ray meets before its end: of several the one that is found first.
    pub(super) fn occluder<K: TreeKernels>(&self, ray: &Ray) -> Option<u32> {
        let geometry = &*self.geometry;
        let occludes = |index: u32| geometry.objects[index as usize].occluded::<K>(ray);
        if self.is_simple() {
            return self.near(ray).find(|&index| occludes(index));
        }
        let plane = geometry.unbounded.iter().copied().find(|&index| occludes(index));
        plane.or_else(|| geometry.tree.traverse::<K::Boxes, AnyOccluder<K>>(ray, geometry))
    }

    /// Asks the objects that a ray may meet until one says yes.
    fn any_object<K: TreeKernels, F: Fn(&Leaf) -> bool>(&self, ray: &Ray, ask: &F) -> bool {
        let geometry = &*self.geometry;
        let ask_one = |index: u32| ask(&Leaf::new(index, &geometry.objects[index as usize]));
        if self.is_simple() {
            return self.near(ray).any(ask_one);
        }
        geometry.unbounded.iter().any(|&index| ask_one(index))
            || geometry.tree.traverse::<K::Boxes, AnyObject<F>>(ray, (&geometry.leaves, ask))
    }

    /// The objects whose bounding spheres a ray passes.
    fn near(&self, ray: &Ray) -> impl Iterator<Item = u32> {
        let Geometry { objects, spheres, .. } = &*self.geometry;
        (0..).zip(spheres.iter().zip(objects)).filter_map(move |(index, (&(centre, radius), object))| {
            (radius == f64::INFINITY || passes(ray, centre, radius, object.error_scale)).then_some(index)
        })
    }

    /// Whether an opaque object is in the way of a ray. If not, `hits` gets the first hit with each object that may let
    /// light through.
    pub fn blocked<K: TreeKernels>(&self, ray: &Ray, hits: &mut Vec<Hit>) -> bool {
        hits.clear();
        let hits = std::cell::RefCell::new(hits);
        self.any_object::<K, _>(ray, &|leaf| {
            let objects = self.objects();
            if !self.may_transmit(leaf.object) {
                return objects[leaf.object as usize].occluded::<K>(ray);
            }
            hits.borrow_mut().extend(leaf.intersect::<K>(objects, ray));
            false
        })
    }

    /// Gives `hits` the first hit with each object that may let light through, in the order of [`Scene::blocked`].
    pub fn glass_along<K: TreeKernels>(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        hits.clear();
        let hits = std::cell::RefCell::new(hits);
        self.any_object::<K, _>(ray, &|leaf| {
            if self.may_transmit(leaf.object) {
                hits.borrow_mut().extend(leaf.intersect::<K>(self.objects(), ray));
            }
            false
        });
    }

    /// Hits of the ray with other objects that lie where `hit` does, to within `slack` in t: faces that touch. Rays
    /// that start behind one of them start behind all of them, so a crossing has to deal with them together.
    pub fn coincident<K: TreeKernels>(&self, ray: &Ray, hit: &Hit, slack: f64, visit: impl FnMut(Hit)) {
        // Twice, because hits and boxes are where they are to within less than the slack.
        if 2.0 * slack * ray.direction.length() < self.geometry.clearances()[hit.object as usize].distance {
            return;
        }
        let near = Ray { t_min: (hit.t - slack).max(ray.t_min), t_max: hit.t + slack, ..*ray };
        let visit = std::cell::RefCell::new(visit);
        self.any_object::<K, _>(&near, &|leaf| {
            if leaf.object != hit.object
                && let Some(other) = leaf.intersect::<K>(self.objects(), &near)
            {
                visit.borrow_mut()(other);
            }
            false
        });
    }
}
