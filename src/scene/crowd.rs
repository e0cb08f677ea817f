//! Rays that run alike through the tree over many objects.
//!
//! They share its nodes. A ball is met by eight rays at a time where several come near to it, other shapes as in small
//! scenes (see `front`), meshes by the packets of their own trees.
//!
//! What a ray finds is what it finds alone. In chains of ties the order in which objects are asked decides (see
//! [`Hit::beats`]), so rays that have met a tie of two objects are traced again, alone. Without a tie there is no
//! chain: whatever lies within reach of the nearest hit is compared with it, or with something that is farther away by
//! less than the reach.
//!
//! Shadow rays go on past glass, and what they pass is counted (see `through`).

#![allow(clippy::needless_range_loop)] // Numbers of rays run over several arrays at once.

use super::body::{Ball, with_body};
use super::front::{DONE, Front, Keep};
use super::leaf::Leaf;
use super::packet::{Packet, Way, meet_shape, runs};
use super::through::{Passage, Passing, passage};
use super::{Inside, Scene, Shape};
use crate::bvh::{BallRows, Beam, Ends, Near, PACKET, PacketVisitor, RaySet, Room, Slabs, TreeKernels, Wide, each_bit};
use crate::geometry::{Hit, Ray, leaves_sphere};
use glam::DVec3;
use std::cell::{RefCell, RefMut};
use std::marker::PhantomData;

/// The closest hit is looked for.
pub(super) const CLOSEST: u8 = 0;
/// Any hit ends a ray.
pub(super) const ANY: u8 = 1;
/// Any hit with an opaque object ends a ray; what it passes of others is counted.
pub(super) const OPAQUE: u8 = 2;

/// What rays are traced with.
pub(super) struct Source<'a> {
    pub scene: &'a Scene,
    pub packet: RefCell<&'a mut Packet>,
    /// What each ray is inside of, for [`OPAQUE`].
    pub inside: &'a [Inside],
}

/// What is found for a ray.
pub(super) struct Found {
    /// The closest hit.
    pub hit: Option<Hit>,
    /// Whether another object has been in the same place as a hit.
    pub tied: bool,
    /// Whether a hit has ended the ray.
    pub ended: bool,
    /// What is in the way of its light.
    pub way: Way,
}

/// A packet on its way.
pub(super) struct Crowd<'a, K, const SEARCH: u8> {
    scene: &'a Scene,
    /// The rays, in the order of the packet.
    packet: RefMut<'a, &'a mut Packet>,
    /// What each ray is inside of.
    inside: &'a [Inside],
    /// Rays with something in the way that may let light through, it is not known how much.
    glass: RaySet,
    /// No ray starts farther away.
    farthest: f64,
    kernels: PhantomData<K>,
}

/// More than rounding to f32 takes away.
const LONGER: f64 = 1.0 + 4.0 / 16_777_216.0;

/// Rays that start farther apart than this part of the tree's extent share little of it. Shadow rays past glass are
/// taken all the same, since each has much to do alone: 0.92 of the time on the field of glass.
const APART: f64 = 0.2;

/// Rays that start farther away, in extents of the tree, are traced alone.
const FAR: f64 = 8.0;

/// So many rays of eight meet a ball one after the other.
const ALONE: u32 = 2;

impl<K: TreeKernels, const SEARCH: u8> Crowd<'_, K, SEARCH> {
    /// Whether an object may let light through, if that matters.
    #[inline(always)]
    fn is_glass(&self, object: u32) -> bool {
        SEARCH == OPAQUE && self.scene.may_transmit(object)
    }

    /// Notes how a ray passes a body that may let light through.
    #[inline(always)]
    fn note(&mut self, i: usize, body: u32, transmit: f64, passage: Passage) {
        if !self.packet.tally.note(i, body, transmit, passage) {
            self.glass.insert(i);
        }
    }

    /// Finds out how a ray passes a body that it meets.
    #[inline(never)]
    fn pass_one(&mut self, i: usize, ray: &Ray, body: u32) {
        let object = &self.scene.objects()[body as usize];
        match self.scene.slack_of(body, self.farthest) {
            Some(slack) => {
                let passage = with_body!(object, |body| passage::<K, _>(&body, ray, slack));
                self.note(i, body, self.scene.transmit_of(body), passage);
            }
            None => self.glass.insert(i),
        }
    }

    /// Finds out how some rays of a group pass a body that is no ball. `slack`: the body's.
    #[inline(never)]
    fn pass(&mut self, index: u32, slack: f64, at: usize, lanes: usize, mut asked: u32) {
        let scene = self.scene;
        let (object, transmit) = (&scene.objects()[index as usize], scene.transmit_of(index));
        let (range, kernels) = (at..at + lanes, PhantomData::<K>);
        let Packet { front, passages, .. } = &mut **self.packet;
        with_body!(object, |body| {
            scene.geometry.tree.run(Passing { range, body, slack, kernels }, front, passages);
        });
        while asked != 0 {
            let i = at + asked.trailing_zeros() as usize;
            asked &= asked - 1;
            let passage = self.packet.passages[i];
            self.note(i, index, transmit, passage);
        }
    }

    /// Meets an object that is neither a ball nor a mesh with some groups of rays, and takes those from `rays` that are
    /// ended.
    fn meet_groups<W: Wide>(&mut self, slabs: &mut Slabs, index: u32, mut groups: u32, rays: &mut RaySet) {
        let (scene, is_glass) = (self.scene, self.is_glass(index));
        let (object, tree) = (&scene.objects()[index as usize], &scene.geometry.tree);
        let slack = if is_glass { scene.slack_of(index, self.farthest) } else { None };
        while groups != 0 {
            let group = groups.trailing_zeros() as usize % (PACKET / W::LANES);
            groups &= groups - 1;
            let (at, left) = (group * W::LANES, rays.group::<W>(group));
            let range = at..at + W::LANES;
            if let Some(slack) = slack {
                self.pass(index, slack, at, W::LANES, left & !self.glass.group::<W>(group));
                continue;
            }
            let Packet { front, met, .. } = &mut **self.packet;
            meet_shape::<K>(tree, object, range.clone(), front, met);
            if is_glass {
                let met = range.fold(0, |lanes, i| lanes | u32::from(!met.t[i].is_nan()) << (i - at));
                self.glass.set_group::<W>(group, self.glass.group::<W>(group) | (left & met));
            } else if SEARCH == CLOSEST {
                tree.run(Keep::<false> { range: range.clone(), object: index }, met, front);
                for i in range {
                    slabs.limit.0[i] = slabs.limit.0[i].min((front.limit[i] * LONGER) as f32);
                }
            } else {
                tree.run(Keep::<true> { range: range.clone(), object: index }, met, front);
                let done = range.fold(0, |lanes, i| lanes | u32::from(front.limit[i] == DONE) << (i - at));
                rays.set_group::<W>(group, left & !done);
            }
        }
    }

    /// Meets a mesh or a plane with some rays, and takes those from `rays` that are ended.
    fn meet(&mut self, filled: usize, slabs: &mut Slabs, index: u32, rays: &mut RaySet) {
        let (scene, is_glass) = (self.scene, self.is_glass(index));
        let object = &scene.objects()[index as usize];
        let asked = if is_glass { rays.without(&self.glass) } else { *rays };
        let packet: &mut Packet = &mut self.packet;
        let filled = filled.min(PACKET);
        for i in 0..filled {
            packet.near[i] = asked.contains(i).into();
        }
        let (tree, mut through) = (&scene.geometry.tree, RaySet::NONE);
        match &object.shape {
            Shape::Mesh(mesh) if is_glass => {
                packet.look_along_mesh::<K>(tree, filled, object, mesh, |i| through.insert(i));
            }
            Shape::Mesh(mesh) if SEARCH == CLOSEST => {
                packet.meet_mesh::<K, false>(tree, filled, (index, object), mesh);
            }
            Shape::Mesh(mesh) => packet.meet_mesh::<K, true>(tree, filled, (index, object), mesh),
            _ => {
                let Packet { front, near, met, .. } = packet;
                runs(&near[..filled], |range| {
                    meet_shape::<K>(tree, object, range.clone(), front, met);
                    if is_glass {
                        range.filter(|&i| !met.t[i].is_nan()).for_each(|i| through.insert(i));
                    } else if SEARCH == CLOSEST {
                        tree.run(Keep::<false> { range, object: index }, met, front);
                    } else {
                        tree.run(Keep::<true> { range, object: index }, met, front);
                    }
                });
            }
        }
        self.glass = self.glass.with(&through);
        for i in 0..filled {
            let limit = self.packet.front.limit[i];
            if SEARCH == CLOSEST {
                slabs.limit.0[i] = slabs.limit.0[i].min((limit * LONGER) as f32);
            } else if limit == DONE {
                rays.remove(i);
            }
        }
    }

    /// Meets a ball with eight rays from number `at` on, a bit each. Returns those that it ends.
    #[inline(always)]
    fn meet_ball(
        &mut self,
        slabs: &mut Slabs,
        object: u32,
        (centre, radius): (DVec3, f64),
        at: usize,
        mut eight: u8,
    ) -> u8 {
        let mut ended = 0;
        let mut t = [f64::NAN; 8];
        let front = &self.packet.front;
        // Most of them come from this very ball.
        eight &= !leave_ball(front, at, (centre, radius));
        if eight.count_ones() > ALONE {
            for k in 0..8 {
                #[allow(clippy::manual_unwrap_or)] // `Option::unwrap_or` is not inlined always.
                let met = match K::sphere(&front.ray(at + k), centre, radius) {
                    Some(t) => t,
                    None => f64::NAN,
                };
                t[k] = met;
            }
        } else {
            each_bit(eight.into(), |k| {
                let k = k & 7;
                #[allow(clippy::manual_unwrap_or)] // As above.
                let met = match K::sphere(&front.ray(at + k), centre, radius) {
                    Some(t) => t,
                    None => f64::NAN,
                };
                t[k] = met;
            });
        }
        each_bit(eight.into(), |k| {
            let k = k & 7;
            let hit = Hit { t: t[k], object, primitive: 0, u: 0.0, v: 0.0 };
            if !t[k].is_nan() && self.take(slabs, at + k, hit) {
                ended |= 1 << k;
            }
        });
        ended
    }

    /// Takes a hit of one ray. Whether that ends it.
    #[inline(always)]
    fn take(&mut self, slabs: &mut Slabs, i: usize, hit: Hit) -> bool {
        if SEARCH == CLOSEST {
            self.packet.offer(i, hit);
            slabs.limit.0[i] = slabs.limit.0[i].min((self.packet.front.limit[i] * LONGER) as f32);
            return false;
        }
        self.packet.front.limit[i] = DONE;
        true
    }

    /// Finds out how some rays of a group pass a ball.
    #[inline(always)]
    fn pass_balls<W: Wide>(&mut self, object: u32, ball: (DVec3, f64), slack: Option<f64>, at: usize, near: Near) {
        let Near { maybe, surely, through } = near;
        let Some(slack) = slack else {
            let mut met = surely;
            for part in 0..W::LANES / 8 {
                let at = at + 8 * part;
                let eight = (maybe >> (8 * part)) as u8 & !leave_ball(&self.packet.front, at, ball);
                if eight != 0 {
                    let passages = self.eight(at, ball, 0.0);
                    each_bit(eight.into(), |k| {
                        met |= u32::from(passages[k & 7] != Passage::Misses) << (8 * part + k);
                    });
                }
            }
            while met != 0 {
                self.glass.insert(at + met.trailing_zeros() as usize);
                met &= met - 1;
            }
            return;
        };
        let transmit = self.scene.transmit_of(object);
        for part in 0..W::LANES / 8 {
            let at = at + 8 * part;
            each_bit(u64::from((through >> (8 * part)) as u8), |k| {
                self.note(at + k, object, transmit, Passage::Passes)
            });
            let mut eight = ((maybe & !through) >> (8 * part)) as u8;
            if eight != 0 {
                eight &= !leave_ball(&self.packet.front, at, ball);
            }
            if eight != 0 {
                let passages = self.eight(at, ball, slack);
                each_bit(eight.into(), |k| self.note(at + k, object, transmit, passages[k & 7]));
            }
        }
    }

    /// How eight rays pass a ball.
    #[inline(always)]
    fn eight(&self, at: usize, (centre, radius): (DVec3, f64), slack: f64) -> [Passage; 8] {
        let (body, front) = (Ball { centre, radius }, &self.packet.front);
        let mut passages = [Passage::Misses; 8];
        for k in 0..8 {
            passages[k] = passage::<K, _>(&body, &front.ray(at + k), slack);
        }
        passages
    }
}

/// Tells which of eight rays do not meet a ball since they come from it.
#[inline(always)]
fn leave_ball(front: &Front, at: usize, (centre, radius): (DVec3, f64)) -> u8 {
    let mut leaving = [false; 8];
    for k in 0..8 {
        leaving[k] = leaves_sphere(&front.ray(at + k), centre, radius);
    }
    (0..8).fold(0, |bits, k| bits | u8::from(leaving[k]) << k)
}

impl<'a, K: TreeKernels, const SEARCH: u8> PacketVisitor for Crowd<'a, K, SEARCH> {
    type Source = &'a Source<'a>;
    type Rows = BallRows;
    type Found = Found;
    const ANY_HIT: bool = SEARCH != CLOSEST;
    /// 4 and 16 are alike for the field of glass; so are 8, 12 and 16 for the closest hits.
    const LEAST: u32 = if SEARCH == OPAQUE { 8 } else { 16 };
    const SLACK: f32 = 0.0;

    #[inline(always)]
    fn is_fit(ray: &Ray, extent: f64) -> bool {
        BallRows::is_fit(ray, extent)
    }

    #[inline(always)]
    fn new(source: &'a Source<'a>) -> Self {
        let Source { scene, packet, inside } = source;
        let (packet, glass) = (packet.borrow_mut(), RaySet::NONE);
        Self { scene, packet, inside, glass, farthest: 0.0, kernels: PhantomData }
    }

    #[inline(always)]
    fn take<W: Wide>(&mut self, _w: W, room: &mut Room<BallRows>, ends: &Ends, extent: f64) -> bool {
        let wide = |[x, y, z]: [[f64; 2]; 3]| (x[1] - x[0]).max(y[1] - y[0]).max(z[1] - z[0]);
        let farthest = ends.origin.iter().flatten().fold(0.0, |far: f64, v| v.abs().max(far));
        // From afar the pads of boxes would be as large as what is in them.
        let apart = if SEARCH == OPAQUE { f64::INFINITY } else { APART };
        if wide(ends.origin) > apart * extent || farthest > FAR * extent || !BallRows::take(room, extent) {
            return false;
        }
        let (rays, together) = (&room.rows.rays, &room.together);
        let filled = together.filled.min(PACKET);
        self.farthest = farthest;
        if SEARCH == OPAQUE {
            let tally = &mut self.packet.tally;
            tally.begin(filled);
            for i in 0..together.count.min(PACKET) {
                tally.start(i, self.inside[usize::from(together.number[i])]);
            }
        }
        let front = &mut self.packet.front;
        for axis in 0..3 {
            front.origin[axis][..filled].copy_from_slice(&rays.origin[axis].0[..filled]);
            front.direction[axis][..filled].copy_from_slice(&rays.direction[axis].0[..filled]);
        }
        front.t_min[..filled].copy_from_slice(&rays.t_min.0[..filled]);
        front.t_max[..filled].copy_from_slice(&rays.t_max.0[..filled]);
        front.limit[..filled].copy_from_slice(&rays.t_max.0[..filled]);
        front.t[..filled].fill(f64::INFINITY);
        front.object[..filled].fill(u32::MAX);
        front.primitive[..filled].fill(u32::MAX);
        front.tied[..filled].fill(0);
        true
    }

    #[inline(always)]
    fn begin(&mut self, room: &mut Room<BallRows>, rays: &mut RaySet) {
        // What ends a ray for good comes first.
        for through in [false, true] {
            for &plane in &self.scene.geometry.unbounded {
                if self.is_glass(plane) == through {
                    self.meet(room.together.filled, &mut room.slabs, plane, rays);
                }
            }
        }
    }

    /// The leaf's own box has been met.
    #[inline(always)]
    fn cull<E: Wide>(&mut self, _e: E, _beam: &Beam<E>, _block: u32) -> u32 {
        1
    }

    #[inline(always)]
    fn visit_across<W: Wide>(
        &mut self,
        w: W,
        room: &mut Room<BallRows>,
        block: u32,
        _slots: u32,
        mut groups: u32,
        rays: &mut RaySet,
    ) {
        let Leaf { object, ball } = self.scene.geometry.leaves[block as usize];
        let Some(ball) = ball else {
            return match self.scene.objects()[object as usize].shape {
                Shape::Mesh(_) => self.meet(room.together.filled, &mut room.slabs, object, rays),
                _ => self.meet_groups::<W>(&mut room.slabs, object, groups, rays),
            };
        };
        let is_glass = self.is_glass(object);
        let slack = if is_glass { self.scene.slack_of(object, self.farthest) } else { None };
        while groups != 0 {
            let group = groups.trailing_zeros() as usize % (PACKET / W::LANES);
            groups &= groups - 1;
            let (at, left) = (group * W::LANES, rays.group::<W>(group));
            let Near { maybe, surely, through } = BallRows::near(w, room, ball, at);
            if is_glass {
                let asked = left & !self.glass.group::<W>(group);
                let near = Near { maybe: maybe & asked, surely: surely & asked, through: through & asked };
                self.pass_balls::<W>(object, ball, slack, at, near);
                continue;
            }
            let (mut maybe, surely) = (maybe & left, if SEARCH == CLOSEST { 0 } else { surely & left });
            maybe &= !surely;
            let mut ended = surely;
            for part in 0..W::LANES / 8 {
                let eight = (maybe >> (8 * part)) as u8;
                if eight != 0 {
                    let of_eight = self.meet_ball(&mut room.slabs, object, ball, at + 8 * part, eight);
                    ended |= u32::from(of_eight) << (8 * part);
                }
            }
            rays.set_group::<W>(group, left & !ended);
        }
    }

    #[inline(always)]
    fn visit_one<E: Wide>(&mut self, _e: E, room: &mut Room<BallRows>, block: u32, i: usize) -> bool {
        let leaf = &self.scene.geometry.leaves[block as usize];
        let (objects, ray) = (self.scene.objects(), self.packet.front.ray(i & (PACKET - 1)));
        if self.is_glass(leaf.object) {
            if !self.glass.contains(i) && leaf.intersect::<K>(objects, &ray).is_some() {
                self.pass_one(i, &ray, leaf.object);
            }
            return false;
        }
        let hit = if SEARCH == CLOSEST || leaf.ball.is_some() {
            leaf.intersect::<K>(objects, &ray)
        } else {
            let any = Hit { t: 0.0, object: leaf.object, primitive: 0, u: 0.0, v: 0.0 };
            objects[leaf.object as usize].occluded::<K>(&ray).then_some(any)
        };
        match hit {
            Some(hit) => self.take(&mut room.slabs, i, hit),
            None => false,
        }
    }

    #[inline(always)]
    fn finish<W: Wide>(
        &mut self,
        _w: W,
        room: &mut Room<BallRows>,
        ended: &RaySet,
        mut found: impl FnMut(usize, Found),
    ) {
        for i in 0..room.together.count.min(PACKET) {
            let hit = if SEARCH == CLOSEST { self.packet.hit(i, self.scene.objects()) } else { None };
            let of_ray = Found {
                hit,
                tied: self.packet.front.tied[i] != 0,
                // A shape is met by eight rays at a time, some of which were not asked for.
                ended: ended.contains(i) || (SEARCH != CLOSEST && self.packet.front.limit[i] == DONE),
                way: if SEARCH != OPAQUE || self.glass.contains(i) { Way::Glass } else { self.packet.tally.way(i) },
            };
            found(usize::from(room.together.number[i]), of_ray);
        }
    }
}
