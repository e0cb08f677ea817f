//! Leaves of the tree over objects, and what is looked for in them.

use super::{Geometry, Object, Scene, Shape};
use crate::bvh::{Lanes, LeafVisitor, TreeKernels};
use crate::geometry::{Hit, Ray};
use glam::DVec3;
use std::marker::PhantomData;

/// One object, and all that is needed to meet it if it is a ball. The objects themselves are large and stand in another
/// order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    pub object: u32,
    /// Centre and radius, world space.
    pub ball: Option<(DVec3, f64)>,
}

impl Leaf {
    pub fn new(index: u32, object: &Object) -> Self {
        let ball = match object.shape {
            Shape::Ball { centre, radius } => Some((centre, radius)),
            _ => None,
        };
        Self { object: index, ball }
    }

    /// The closest hit of a world-space ray, as [`Object::intersect`] finds it.
    #[inline(always)]
    pub fn intersect<K: TreeKernels>(&self, objects: &[Object], ray: &Ray) -> Option<Hit> {
        let Some((centre, radius)) = self.ball else {
            return objects[self.object as usize].intersect::<K>(ray, self.object);
        };
        #[allow(clippy::manual_map)] // `Option::map` is not inlined always.
        match K::sphere(ray, centre, radius) {
            Some(t) => Some(Hit { t, object: self.object, primitive: 0, u: 0.0, v: 0.0 }),
            None => None,
        }
    }
}

/// Finds the closest hit.
pub(super) struct Closest<'a, K> {
    geometry: &'a Geometry,
    pub ray: Ray,
    pub best: Option<Hit>,
    kernels: PhantomData<K>,
}

impl<K: TreeKernels> Closest<'_, K> {
    /// Tests one object and returns where the ray ends now.
    pub fn test(&mut self, index: u32, t_max: f64) -> f64 {
        let object = &self.geometry.objects[index as usize];
        let hit = object.intersect::<K>(&Ray { t_max, ..self.ray }, index);
        self.take(hit, t_max)
    }

    /// Takes a hit if it is the best one, and returns where the ray ends now.
    #[inline(always)]
    fn take(&mut self, hit: Option<Hit>, t_max: f64) -> f64 {
        match hit {
            Some(hit) if self.best.is_none_or(|b| hit.beats(&b)) => {
                self.best = Some(hit);
                hit.reach().min(self.ray.t_max)
            }
            _ => t_max,
        }
    }
}

impl<'a, K: TreeKernels> LeafVisitor for Closest<'a, K> {
    type Source = (&'a Scene, Option<Hit>);
    type Found = Option<Hit>;
    const ANY_HIT: bool = false;

    #[inline(always)]
    fn new((scene, best): Self::Source, ray: &Ray) -> Self {
        Self { geometry: &scene.geometry, ray: *ray, best, kernels: PhantomData }
    }

    #[inline(always)]
    fn visit<L: Lanes>(&mut self, _lanes: L, block: u32, t_max: &mut f64) -> bool {
        let ray = Ray { t_max: *t_max, ..self.ray };
        let hit = self.geometry.leaves[block as usize].intersect::<K>(&self.geometry.objects, &ray);
        *t_max = self.take(hit, *t_max);
        false
    }

    #[inline(always)]
    fn found(self, _ended: bool) -> Option<Hit> {
        self.best
    }
}

/// Finds an object that a ray meets.
pub(super) struct AnyOccluder<'a, K> {
    geometry: &'a Geometry,
    ray: Ray,
    pub occluder: Option<u32>,
    kernels: PhantomData<K>,
}

impl<'a, K: TreeKernels> LeafVisitor for AnyOccluder<'a, K> {
    type Source = &'a Geometry;
    type Found = Option<u32>;
    const ANY_HIT: bool = true;

    #[inline(always)]
    fn new(geometry: &'a Geometry, ray: &Ray) -> Self {
        Self { geometry, ray: *ray, occluder: None, kernels: PhantomData }
    }

    #[inline(always)]
    fn visit<L: Lanes>(&mut self, _lanes: L, block: u32, _t_max: &mut f64) -> bool {
        let leaf = &self.geometry.leaves[block as usize];
        let met = match leaf.ball {
            Some(_) => leaf.intersect::<K>(&[], &self.ray).is_some(),
            None => self.geometry.objects[leaf.object as usize].occluded::<K>(&self.ray),
        };
        if met {
            self.occluder = Some(leaf.object);
        }
        met
    }

    #[inline(always)]
    fn found(self, _ended: bool) -> Option<u32> {
        self.occluder
    }
}

/// Asks every object, and ends at the first that says yes.
pub(super) struct AnyObject<'a, F> {
    leaves: &'a [Leaf],
    ask: &'a F,
}

impl<'a, F: Fn(&Leaf) -> bool> LeafVisitor for AnyObject<'a, F> {
    type Source = (&'a [Leaf], &'a F);
    /// Whether one has said yes.
    type Found = bool;
    const ANY_HIT: bool = true;

    #[inline(always)]
    fn new((leaves, ask): Self::Source, _ray: &Ray) -> Self {
        Self { leaves, ask }
    }

    #[inline(always)]
    fn visit<L: Lanes>(&mut self, _lanes: L, block: u32, _t_max: &mut f64) -> bool {
        (self.ask)(&self.leaves[block as usize])
    }

    #[inline(always)]
    fn found(self, ended: bool) -> bool {
        ended
    }
}
