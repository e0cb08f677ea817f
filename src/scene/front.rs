//! Rays side by side in arrays, and the loops over them that the compiler makes vector code of.

#![allow(clippy::needless_range_loop)] // Numbers of rays and axes run over several arrays at once.

use super::body::Body;
use crate::bvh::{ExactRays, Task};
use crate::geometry::{Hit, Kernels, Ray};
use glam::{DAffine3, DVec3};
use std::marker::PhantomData;
use std::ops::Range;

/// Rays that are traced together at most.
pub(super) const CAPACITY: usize = 256;

/// Limit of a ray that needs no further hit.
pub(super) const DONE: f64 = f64::NEG_INFINITY;

/// Rays and what they have met, number by number.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct Front {
    pub origin: [[f64; CAPACITY]; 3],
    pub direction: [[f64; CAPACITY]; 3],
    pub t_min: [f64; CAPACITY],
    /// Hits beyond this do not count any more.
    pub limit: [f64; CAPACITY],
    /// Where the ray ends.
    pub t_max: [f64; CAPACITY],
    pub t: [f64; CAPACITY],
    /// `u32::MAX` for none.
    pub object: [u32; CAPACITY],
    pub primitive: [u32; CAPACITY],
    /// Which hits another object has been in the same place as.
    pub tied: [u8; CAPACITY],
}

impl Front {
    /// One of the rays, as long as it still is.
    #[inline(always)]
    pub fn ray(&self, i: usize) -> Ray {
        let [ox, oy, oz] = [self.origin[0][i], self.origin[1][i], self.origin[2][i]];
        let [dx, dy, dz] = [self.direction[0][i], self.direction[1][i], self.direction[2][i]];
        let (origin, direction) = (DVec3::new(ox, oy, oz), DVec3::new(dx, dy, dz));
        Ray { origin, direction, t_min: self.t_min[i], t_max: self.limit[i] }
    }

    /// The largest coordinate of the origins of the first rays; their number is rounded up to whole groups of eight.
    #[inline(always)]
    pub fn farthest(&self, count: usize) -> f64 {
        let mut largest = [0.0; 8];
        for axis in &self.origin {
            for coordinates in axis[..count.min(CAPACITY).next_multiple_of(8)].as_chunks::<8>().0 {
                for k in 0..8 {
                    let x = coordinates[k].abs();
                    largest[k] = if x > largest[k] { x } else { largest[k] };
                }
            }
        }
        largest.into_iter().fold(0.0, f64::max)
    }
}

/// Where rays meet one object.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct Met {
    /// NaN for those that do not.
    pub t: [f64; CAPACITY],
    pub primitive: [u32; CAPACITY],
}

impl Default for Met {
    fn default() -> Self {
        Self { t: [0.0; CAPACITY], primitive: [0; CAPACITY] }
    }
}

/// Which rays may meet an object: those that pass its bounding sphere and have not gone by it.
pub(super) struct Pass {
    pub count: usize,
    pub centre: DVec3,
    pub radius: f64,
    /// Relative error of the object's own test.
    pub error: f64,
}

impl Task for Pass {
    type Input = Front;
    type Output = [u8; CAPACITY];

    #[inline(always)]
    fn run(self, front: &Front, near: &mut [u8; CAPACITY]) {
        let Pass { count, centre, radius, error } = self;
        for i in 0..count.min(CAPACITY) {
            let ray = front.ray(i);
            near[i] = u8::from(passes(&ray, centre, radius, error) & (ray.t_max != DONE));
        }
    }
}

/// Whether a ray may meet an object: it passes the bounding sphere and has not gone by it. `error`: relative error of
/// the object's own test.
#[inline(always)]
pub(super) fn passes(ray: &Ray, centre: DVec3, radius: f64, error: f64) -> bool {
    let f = ray.origin - centre;
    let (n, f2, d2) = (f.cross(ray.direction), f.length_squared(), ray.direction.length_squared());
    // The last term covers the rounding of the cross product and of the object's own test, the factor all others.
    let reach2 = (radius * radius + error * error * f2) * 1.0001;
    let past = (f.dot(ray.direction) > 0.0) & (f2 > reach2);
    // NaN passes.
    !((n.length_squared() > reach2 * d2) | past)
}

/// Brings rays into the space of an object.
pub(super) struct ToObject {
    pub range: Range<usize>,
    pub inverse: DAffine3,
}

impl Task for ToObject {
    type Input = Front;
    type Output = ExactRays;

    #[inline(always)]
    fn run(self, front: &Front, rays: &mut ExactRays) {
        for i in self.range.start..self.range.end.min(CAPACITY) {
            rays.put(i, &front.ray(i).transformed(&self.inverse));
        }
    }
}

/// Finds where rays meet a shape.
pub(super) struct Meet<B, K> {
    pub range: Range<usize>,
    pub body: B,
    pub kernels: PhantomData<K>,
}

impl<B: Body, K: Kernels> Task for Meet<B, K> {
    type Input = Front;
    type Output = Met;

    #[inline(always)]
    fn run(self, front: &Front, met: &mut Met) {
        let Meet { range, body, kernels: _ } = self;
        for i in range.start..range.end.min(CAPACITY) {
            (met.t[i], met.primitive[i]) = match body.meet::<K>(&front.ray(i)) {
                Some((t, face)) => (t, face),
                None => (f64::NAN, 0),
            };
        }
    }
}

/// Takes the hits with an object that are the best so far; if any will do, ends the rays that have one.
pub(super) struct Keep<const ANY_HIT: bool> {
    pub range: Range<usize>,
    pub object: u32,
}

impl<const ANY_HIT: bool> Task for Keep<ANY_HIT> {
    type Input = Met;
    type Output = Front;

    #[inline(always)]
    fn run(self, met: &Met, front: &mut Front) {
        let Keep { range, object } = self;
        for i in range.start..range.end.min(CAPACITY) {
            let hit = Hit { t: met.t[i], object, primitive: met.primitive[i], u: 0.0, v: 0.0 };
            let old = Hit { t: front.t[i], object: front.object[i], primitive: front.primitive[i], u: 0.0, v: 0.0 };
            let wins = if ANY_HIT { !hit.t.is_nan() } else { hit.beats(&old) };
            let limit = if ANY_HIT { DONE } else { hit.reach().min(front.t_max[i]) };
            front.t[i] = if wins { hit.t } else { old.t };
            front.object[i] = if wins { object } else { old.object };
            front.primitive[i] = if wins { hit.primitive } else { old.primitive };
            front.limit[i] = if wins { limit } else { front.limit[i] };
            front.tied[i] |= u8::from(hit.ties(&old) & (old.object != u32::MAX));
        }
    }
}
