//! Leaves of the tree over objects, and what is looked for in them.

use super::{Geometry, Object, Scene, Shape};
use crate::bvh::{BallBlock, BallTest, Lanes, LeafVisitor, TreeKernels};
use crate::geometry::{Hit, Ray};
use glam::DVec3;

/// What is at a place of the tree.
#[derive(Clone, Copy, Debug)]
pub(super) enum Leaf {
    /// One object.
    Object(u32),
    /// A block of [`Geometry::balls`].
    Balls(u32),
}

impl Leaf {
    /// The objects in it.
    pub fn objects(self, balls: &[BallBlock]) -> impl Iterator<Item = u32> {
        let (one, block) = match self {
            Self::Object(index) => (Some(index), None),
            Self::Balls(block) => (None, Some(&balls[block as usize])),
        };
        one.into_iter().chain(block.into_iter().flat_map(BallBlock::ids))
    }
}

/// An object that a ray may meet, and all that is needed to meet it if it is a ball. The objects themselves are large and stand in
/// another order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub object: u32,
    /// Centre and radius, world space.
    ball: Option<(DVec3, f64)>,
}

impl Candidate {
    pub fn new(index: u32, object: &Object) -> Self {
        let ball = match object.shape {
            Shape::Ball { centre, radius } => Some((centre, radius)),
            _ => None,
        };
        Self { object: index, ball }
    }

    /// The ball in a lane.
    #[inline(always)]
    fn of(block: &BallBlock, lane: usize) -> Self {
        let (object, centre, radius) = block.ball(lane);
        Self { object, ball: Some((centre, radius)) }
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

    /// Whether a world-space ray meets it.
    #[inline(always)]
    pub fn occluded<K: TreeKernels>(&self, objects: &[Object], ray: &Ray) -> bool {
        match self.ball {
            Some((centre, radius)) => K::sphere(ray, centre, radius).is_some(),
            None => objects[self.object as usize].occluded::<K>(ray),
        }
    }
}

/// Finds the closest hit.
pub(super) struct Closest<'a, K: TreeKernels> {
    geometry: &'a Geometry,
    pub ray: Ray,
    pub best: Option<Hit>,
    balls: K::Balls,
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
                let t_max = hit.reach().min(self.ray.t_max);
                self.balls.shorten(t_max);
                t_max
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
        let geometry = &*scene.geometry;
        Self { geometry, ray: *ray, best, balls: K::Balls::new(ray, geometry.tree.extent()) }
    }

    #[inline(always)]
    fn visit<L: Lanes>(&mut self, lanes: L, block: u32, t_max: &mut f64) -> bool {
        match self.geometry.leaves[block as usize] {
            Leaf::Object(index) => *t_max = self.test(index, *t_max),
            Leaf::Balls(block) => {
                let block = &self.geometry.balls[block as usize];
                let mut candidates = self.balls.candidates(lanes.wide(), block);
                while candidates != 0 {
                    let ball = Candidate::of(block, candidates.trailing_zeros() as usize);
                    candidates &= candidates - 1;
                    let hit = ball.intersect::<K>(&[], &Ray { t_max: *t_max, ..self.ray });
                    *t_max = self.take(hit, *t_max);
                }
            }
        }
        false
    }

    #[inline(always)]
    fn found(self, _ended: bool) -> Option<Hit> {
        self.best
    }
}

/// Finds an object that a ray meets.
pub(super) struct AnyOccluder<'a, K: TreeKernels> {
    geometry: &'a Geometry,
    ray: Ray,
    occluder: Option<u32>,
    balls: K::Balls,
}

impl<'a, K: TreeKernels> LeafVisitor for AnyOccluder<'a, K> {
    type Source = &'a Geometry;
    type Found = Option<u32>;
    const ANY_HIT: bool = true;

    #[inline(always)]
    fn new(geometry: &'a Geometry, ray: &Ray) -> Self {
        Self { geometry, ray: *ray, occluder: None, balls: K::Balls::new(ray, geometry.tree.extent()) }
    }

    #[inline(always)]
    fn visit<L: Lanes>(&mut self, lanes: L, block: u32, _t_max: &mut f64) -> bool {
        match self.geometry.leaves[block as usize] {
            Leaf::Object(index) => {
                if self.geometry.objects[index as usize].occluded::<K>(&self.ray) {
                    self.occluder = Some(index);
                }
            }
            Leaf::Balls(block) => {
                let block = &self.geometry.balls[block as usize];
                let mut candidates = self.balls.candidates(lanes.wide(), block);
                while candidates != 0 {
                    let (index, centre, radius) = block.ball(candidates.trailing_zeros() as usize);
                    candidates &= candidates - 1;
                    if K::sphere(&self.ray, centre, radius).is_some() {
                        self.occluder = Some(index);
                        break;
                    }
                }
            }
        }
        self.occluder.is_some()
    }

    #[inline(always)]
    fn found(self, _ended: bool) -> Option<u32> {
        self.occluder
    }
}

/// Asks every object that a ray may meet, and ends at the first that says yes.
pub(super) struct AnyObject<'a, K: TreeKernels, F> {
    geometry: &'a Geometry,
    ask: &'a F,
    balls: K::Balls,
}

impl<'a, K: TreeKernels, F: Fn(&Candidate) -> bool> LeafVisitor for AnyObject<'a, K, F> {
    type Source = (&'a Geometry, &'a F);
    /// Whether one has said yes.
    type Found = bool;
    const ANY_HIT: bool = true;

    #[inline(always)]
    fn new((geometry, ask): Self::Source, ray: &Ray) -> Self {
        Self { geometry, ask, balls: K::Balls::new(ray, geometry.tree.extent()) }
    }

    #[inline(always)]
    fn visit<L: Lanes>(&mut self, lanes: L, block: u32, _t_max: &mut f64) -> bool {
        let leaf = self.geometry.leaves[block as usize];
        let mut candidates = match leaf {
            Leaf::Object(_) => 1,
            Leaf::Balls(block) => self.balls.candidates(lanes.wide(), &self.geometry.balls[block as usize]),
        };
        // Asked in one place, so that it is inlined.
        while candidates != 0 {
            let candidate = match leaf {
                Leaf::Object(object) => Candidate { object, ball: None },
                Leaf::Balls(block) => {
                    Candidate::of(&self.geometry.balls[block as usize], candidates.trailing_zeros() as usize)
                }
            };
            candidates &= candidates - 1;
            if (self.ask)(&candidate) {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn found(self, ended: bool) -> bool {
        ended
    }
}
