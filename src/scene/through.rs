//! How shadow rays pass bodies of glass, found together with everything else that is in their way.
//!
//! What gets past transparent surfaces is the product of their k_t, one after the other along the ray (see
//! `shading::local`). A convex body that nothing else comes near is crossed on the way in and on the way out with no
//! other surface between, and both change the medium. So where all bodies are such and of one k_t, it is enough to
//! count. Rays that graze one or start in several bodies at once are left to be followed from surface to surface.

#![allow(clippy::needless_range_loop)] // Numbers of rays run over several arrays at once.

use super::body::{Body, with_body};
use super::front::{CAPACITY, Front};
use super::packet::{Packet, Way, runs};
use super::{Inside, Scene};
use crate::bvh::{Task, TreeKernels};
use crate::geometry::{Kernels, Ray};
use std::marker::PhantomData;
use std::ops::Range;

/// What a ray does with a convex body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Passage {
    /// It does not meet it.
    Misses,
    /// It starts inside.
    Leaves,
    /// It ends inside, or the body is a quad.
    Enters,
    /// It goes in and out again.
    Passes,
    /// It can not be told: it grazes the surface, or is inside for too short a way.
    Grazes,
}

/// Cosines to the normal below this are grazing, so that the sign of no other is in doubt.
const GRAZING: f64 = 1.0 / 256.0;

/// How a ray of unit direction passes a body. `slack`: ways inside that are shorter count as grazing.
#[inline(always)]
#[allow(clippy::manual_unwrap_or)] // `Option::unwrap_or` is not inlined always.
pub(super) fn passage<K: Kernels, B: Body>(body: &B, ray: &Ray, slack: f64) -> Passage {
    let (near, first) = match body.meet::<K>(ray) {
        Some(hit) => hit,
        None => (f64::NAN, 0),
    };
    // Where it would leave, were it long enough: a ray that touches an edge enters there and never leaves.
    let (far, last) = match body.meet::<K>(&Ray { t_min: near, t_max: f64::MAX, ..*ray }) {
        Some(hit) => hit,
        None => (f64::NAN, 0),
    };
    let (at_near, at_far) = (body.normal(ray, near, first), body.normal(ray, far, last));
    let (into, into_least) = (at_near.dot(ray.direction), GRAZING * at_near.length());
    let (out, out_least) = (at_far.dot(ray.direction), GRAZING * at_far.length());
    let enters = into < -into_least;
    let once = enters & ((far > ray.t_max) | (far.is_nan() & !B::IS_SOLID));
    let twice = enters & (out > out_least) & (far - near > slack) & (far <= ray.t_max);
    let leaves = (into > into_least) & far.is_nan();
    let passage = if twice { Passage::Passes } else { Passage::Grazes };
    let passage = if once { Passage::Enters } else { passage };
    let passage = if leaves { Passage::Leaves } else { passage };
    if near.is_nan() { Passage::Misses } else { passage }
}

/// Tells how a range of rays pass a body.
pub(super) struct Passing<B, K> {
    pub range: Range<usize>,
    pub body: B,
    /// See [`passage`].
    pub slack: f64,
    pub kernels: PhantomData<K>,
}

impl<B: Body, K: Kernels> Task for Passing<B, K> {
    type Input = Front;
    type Output = [Passage; CAPACITY];

    #[inline(always)]
    fn run(self, front: &Front, passages: &mut [Passage; CAPACITY]) {
        let Passing { range, body, slack, kernels: _ } = self;
        for i in range.start..range.end.min(CAPACITY) {
            passages[i] = passage::<K, B>(&body, &front.ray(i), slack);
        }
    }
}

/// What rays have passed so far.
#[derive(Debug)]
pub(super) struct Tally {
    /// Surfaces, by ray.
    crossed: [u16; CAPACITY],
    /// The k_t of all of them.
    transmit: [f64; CAPACITY],
    /// What the ray starts in and has not left: a body, [`NOTHING`] or [`SEVERAL`].
    inside: [u32; CAPACITY],
    /// 1 where what gets through can not be told.
    lost: [u8; CAPACITY],
}

const NOTHING: u32 = u32::MAX;
const SEVERAL: u32 = u32::MAX - 1;

/// More surfaces are not counted.
const MOST_CROSSED: u16 = 1000;

impl Tally {
    pub const NEW: Self =
        Self { crossed: [0; CAPACITY], transmit: [0.0; CAPACITY], inside: [NOTHING; CAPACITY], lost: [0; CAPACITY] };

    /// Begins with new rays.
    #[inline(always)]
    pub fn begin(&mut self, count: usize) {
        let count = count.min(CAPACITY);
        self.crossed[..count].fill(0);
        self.lost[..count].fill(0);
        self.inside[..count].fill(NOTHING);
    }

    /// Says what a ray starts in.
    #[inline(always)]
    pub fn start(&mut self, i: usize, inside: Inside) {
        self.inside[i % CAPACITY] = match inside {
            Inside::Nothing => NOTHING,
            Inside::One(body) => body,
            Inside::Several => SEVERAL,
        };
    }

    /// Notes how a ray passes a body of this k_t. False if what gets through can not be told any more.
    #[inline(always)]
    pub fn note(&mut self, i: usize, body: u32, transmit: f64, passage: Passage) -> bool {
        let i = i % CAPACITY;
        let before = self.crossed[i];
        let once = (passage == Passage::Leaves) | (passage == Passage::Enters);
        let surfaces = if once { 1 } else { 0 } + if passage == Passage::Passes { 2 } else { 0 };
        let other = (before != 0) & ((self.transmit[i] != transmit) | (before > MOST_CROSSED));
        self.lost[i] |= u8::from((passage == Passage::Grazes) | ((surfaces != 0) & other));
        self.transmit[i] = if surfaces != 0 { transmit } else { self.transmit[i] };
        self.crossed[i] = before + surfaces;
        let has_left = (passage == Passage::Leaves) & (self.inside[i] == body);
        self.inside[i] = if has_left { NOTHING } else { self.inside[i] };
        self.lost[i] == 0
    }

    /// What is in the way of a ray, where nothing opaque is and all that it passes has been noted.
    #[inline(always)]
    pub fn way(&self, i: usize) -> Way {
        let i = i % CAPACITY;
        match (self.lost[i], self.crossed[i], self.inside[i]) {
            (0, 0, _) => Way::Clear,
            (0, 1, NOTHING) => Way::Part(self.transmit[i]),
            // Surfaces are multiplied as they are one after the other.
            (0, crossed, NOTHING) => Way::Part((1..crossed).fold(self.transmit[i], |part, _| part * self.transmit[i])),
            _ => Way::Glass,
        }
    }
}

/// Notes how a range of rays pass a body.
struct Note {
    range: Range<usize>,
    body: u32,
    transmit: f64,
}

impl Task for Note {
    type Input = [Passage; CAPACITY];
    type Output = Tally;

    #[inline(always)]
    fn run(self, passages: &[Passage; CAPACITY], tally: &mut Tally) {
        let Note { range, body, transmit } = self;
        for i in range.start..range.end.min(CAPACITY) {
            tally.note(i, body, transmit, passages[i]);
        }
    }
}

impl Scene {
    /// What is in the way of the rays of a packet, of unit direction, in a scene of few objects. `inside`: what they
    /// start in.
    pub(super) fn look_along_few<K: TreeKernels>(
        &self,
        packet: &mut Packet,
        count: usize,
        inside: &[Inside],
        ways: &mut [Way],
    ) {
        packet.tally.begin(count);
        for (i, &inside) in inside.iter().enumerate() {
            packet.tally.start(i, inside);
        }
        let farthest = packet.front.farthest(count);
        // What ends a ray for good comes first.
        for transparent in [false, true] {
            for (index, object) in
                (0..).zip(self.objects()).filter(|(index, _)| self.may_transmit(*index) == transparent)
            {
                // Where what is found depends on the way to it, rays are followed through all glass.
                let slack = if transparent && K::CONSERVATIVE { self.slack_of(index, farthest) } else { None };
                match slack {
                    Some(slack) => self.pass::<K>(packet, count, index, slack),
                    None => self.meet::<K, true>(packet, count, index, object),
                }
            }
        }
        for (i, (way, &met)) in ways.iter_mut().zip(&packet.front.object).enumerate() {
            *way = match met {
                u32::MAX => packet.tally.way(i),
                object if self.may_transmit(object) => Way::Glass,
                _ => Way::Blocked,
            };
        }
    }

    /// Notes how the rays of a packet pass a body. `slack`: the body's.
    fn pass<K: TreeKernels>(&self, packet: &mut Packet, count: usize, index: u32, slack: f64) {
        let object = &self.objects()[index as usize];
        self.near_in_packet(packet, count, index, object);
        let (tree, transmit, kernels) = (&self.geometry.tree, self.transmit_of(index), PhantomData::<K>);
        let Packet { front, near, passages, tally, .. } = packet;
        runs(&near[..count], |range| {
            with_body!(object, |body| {
                tree.run(Passing { range: range.clone(), body, slack, kernels }, front, passages);
            });
            tree.run(Note { range, body: index, transmit }, passages, tally);
        });
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
