//! How shadow rays pass bodies of glass, found together with everything else that is in their way.
//!
//! What gets past transparent surfaces is the product of their k_t, one after the other along the ray (see
//! `shading::local`). A convex body that nothing else comes near is crossed on the way in and on the way out with no
//! other surface between, and both change the medium. So where all bodies are such and of one k_t, it is enough to
//! count. Rays that graze one or start in several bodies at once are left to be followed from surface to surface.

#![allow(clippy::needless_range_loop)] // Numbers of rays run over several arrays at once.

use super::front::{CAPACITY, Front};
use super::packet::Way;
use super::{Inside, Scene};
use crate::bvh::{Task, TreeKernels};
use crate::geometry::{Hit, Ray, leaves_sphere};
use glam::{DAffine3, DVec3};
use std::marker::PhantomData;
use std::ops::Range;

/// What a ray does with a convex body.
pub(super) type Pass = u8;

/// It does not meet it.
pub(super) const MISSES: Pass = 0;
/// It starts inside.
pub(super) const LEAVES: Pass = 1;
/// It ends inside.
pub(super) const ENTERS: Pass = 2;
/// It goes in and out again.
pub(super) const PASSES: Pass = 3;
/// It can not be told: it grazes the surface, or is inside for too short a way.
pub(super) const GRAZES: Pass = 4;

/// Cosines to the normal below this are grazing, so that the sign of no other is in doubt.
const GRAZING: f64 = 1.0 / 256.0;

/// What rays have passed so far.
#[derive(Debug)]
pub(super) struct Tally {
    /// Surfaces, by ray.
    crossed: [u16; CAPACITY],
    /// The k_t of all of them.
    transmit: [f64; CAPACITY],
    /// What the ray starts in and has not left.
    pub inside: [Inside; CAPACITY],
}

impl Tally {
    pub const NEW: Self =
        Self { crossed: [0; CAPACITY], transmit: [0.0; CAPACITY], inside: [Inside::Nothing; CAPACITY] };

    /// Forgets the rays before.
    #[inline(always)]
    pub fn clear(&mut self, count: usize) {
        self.crossed[..count.min(CAPACITY)].fill(0);
    }

    /// Notes that a ray passes a body of this k_t. False if what gets through can not be told any more.
    #[inline(always)]
    pub fn note(&mut self, i: usize, body: u32, transmit: f64, pass: Pass) -> bool {
        let i = i % CAPACITY;
        let crossed = match pass {
            MISSES => return true,
            LEAVES | ENTERS => 1,
            PASSES => 2,
            _ => return false,
        };
        if self.crossed[i] == 0 {
            self.transmit[i] = transmit;
        } else if self.transmit[i] != transmit || self.crossed[i] > 1000 {
            return false;
        }
        self.crossed[i] += crossed;
        if pass == LEAVES && self.inside[i] == Inside::One(body) {
            self.inside[i] = Inside::Nothing;
        }
        true
    }

    /// What is in the way of a ray, where nothing opaque is and all that it passes has been noted.
    #[inline(always)]
    pub fn way(&self, i: usize) -> Way {
        let i = i % CAPACITY;
        match (self.crossed[i], self.inside[i]) {
            (0, _) => Way::Clear,
            // Surfaces are multiplied as they are one after the other.
            (crossed, Inside::Nothing) => Way::Part((0..crossed).fold(1.0, |part, _| part * self.transmit[i])),
            _ => Way::Glass,
        }
    }
}

/// Tells how eight rays pass a ball. `slack`: ways inside that are shorter count as grazing.
#[inline(always)]
#[allow(clippy::manual_unwrap_or, clippy::manual_unwrap_or_default)] // `Option::map` and the like are not inlined always.
pub(super) fn pass_ball<K: TreeKernels>(
    front: &Front,
    at: usize,
    (centre, radius): (DVec3, f64),
    slack: f64,
) -> [Pass; 8] {
    let (mut near, mut far, mut side) = ([0.0; 8], [0.0; 8], [0.0; 8]);
    for k in 0..8 {
        near[k] = match K::sphere(&front.ray(at + k), centre, radius) {
            Some(t) => t,
            None => f64::NAN,
        };
    }
    for k in 0..8 {
        let ray = front.ray(at + k);
        far[k] = match K::sphere(&Ray { t_min: near[k], ..ray }, centre, radius) {
            Some(t) => t,
            None => f64::NAN,
        };
        side[k] = (ray.at(near[k]) - centre).dot(ray.direction);
    }
    let mut passes = [GRAZES; 8];
    for k in 0..8 {
        let (way, steep) = (far[k] - near[k], 2.0 * GRAZING * radius);
        passes[k] = if near[k].is_nan() {
            MISSES
        } else if !far[k].is_nan() {
            if way > slack && way > steep { PASSES } else { GRAZES }
        } else if side[k] > steep {
            LEAVES
        } else if side[k] < -steep {
            ENTERS
        } else {
            GRAZES
        };
    }
    passes
}

/// Tells which of eight rays do not meet a ball since they come from it.
#[inline(always)]
pub(super) fn leave_ball(front: &Front, at: usize, (centre, radius): (DVec3, f64)) -> u8 {
    let mut leaving = [false; 8];
    for k in 0..8 {
        leaving[k] = leaves_sphere(&front.ray(at + k), centre, radius);
    }
    (0..8).fold(0, |bits, k| bits | u8::from(leaving[k]) << k)
}

/// Tells how a range of rays pass a cuboid.
pub(super) struct Walls<'a, K> {
    pub range: Range<usize>,
    pub inverse: DAffine3,
    /// Normals of its faces in world space.
    pub axes: &'a [DVec3; 3],
    /// Ways inside that are shorter count as grazing.
    pub slack: f64,
    pub kernels: PhantomData<K>,
}

impl<K: TreeKernels> Task for Walls<'_, K> {
    type Input = Front;
    type Output = [Pass; CAPACITY];

    #[inline(always)]
    #[allow(clippy::manual_unwrap_or, clippy::manual_unwrap_or_default)] // As above.
    fn run(self, front: &Front, passes: &mut [Pass; CAPACITY]) {
        let Walls { range, inverse, axes, slack, kernels: _ } = self;
        let axes = *axes;
        for i in range.start..range.end.min(CAPACITY) {
            let ray = front.ray(i);
            let local = ray.transformed(&inverse);
            let (near, first) = match K::cuboid(&local) {
                Some((t, face)) => (t, face),
                None => (f64::NAN, 0),
            };
            let (far, last) = match K::cuboid(&Ray { t_min: near, ..local }) {
                Some((t, face)) => (t, face),
                None => (f64::NAN, 0),
            };
            let outward = |face: u32| {
                let [x, y, z] = [ray.direction.dot(axes[0]), ray.direction.dot(axes[1]), ray.direction.dot(axes[2])];
                let along = if face < 2 {
                    x
                } else if face < 4 {
                    y
                } else {
                    z
                };
                if face & 1 == 0 { -along } else { along }
            };
            let (into, out) = (outward(first), outward(last));
            let through = (far - near > slack) & (into < -GRAZING) & (out > GRAZING);
            let one = if into > GRAZING {
                LEAVES
            } else if into < -GRAZING {
                ENTERS
            } else {
                GRAZES
            };
            let two = if through { PASSES } else { GRAZES };
            let met = if far.is_nan() { one } else { two };
            passes[i] = if near.is_nan() { MISSES } else { met };
        }
    }
}

impl Scene {
    /// Tells how one ray passes a convex body that it meets. `slack`: ways inside that are shorter count as grazing.
    pub(super) fn pass_one<K: TreeKernels>(&self, ray: &Ray, near: &Hit, slack: f64) -> Pass {
        let object = &self.objects()[near.object as usize];
        let cosine = |facet: &super::Facet| facet.normal.dot(ray.direction).abs();
        let first = self.facet::<K>(ray, near);
        if cosine(&first) < GRAZING {
            return GRAZES;
        }
        let Some(far) = object.intersect::<K>(&Ray { t_min: near.t, ..*ray }, near.object) else {
            return if first.entering { ENTERS } else { LEAVES };
        };
        let last = self.facet::<K>(ray, &far);
        let through = far.t - near.t > slack && first.entering && !last.entering && cosine(&last) >= GRAZING;
        if through { PASSES } else { GRAZES }
    }

    /// If nothing comes near a body: how far in t other surfaces are looked for around a place where a ray crosses it,
    /// or more. Rays start no farther away than `farthest`.
    pub(super) fn slack_of(&self, body: u32, farthest: f64) -> Option<f64> {
        let object = &self.objects()[body as usize];
        // `shading::crossing::slack` where no cosine counts for less than 0.001.
        let slack = 4.1e3 * object.error_scale * object.reach + 3e-11 * (2.0 * farthest + object.reach);
        let clearance = &self.geometry.clearances()[body as usize];
        (clearance.is_free() && 2.1 * slack < clearance.distance).then_some(slack)
    }
}
