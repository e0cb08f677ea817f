//! Rays that run alike through the tree over many objects.
//!
//! They share its nodes. A ball is met by eight rays at a time where several come near to it, other shapes as in small scenes (see
//! `front`), meshes by the packets of their own trees.
//!
//! What a ray finds is what it finds alone. In chains of ties the order in which objects are asked decides (see [`Hit::beats`]), so rays
//! that have met a tie of two objects are traced again, alone. Without a tie there is no chain: whatever lies within reach of the
//! nearest hit is compared with it, or with something that is farther away by less than the reach.

use super::front::{DONE, Keep};
use super::leaf::Leaf;
use super::packet::{Packet, meet_shape, runs};
use super::{Scene, Shape};
use crate::bvh::{BallBlock, BallRays, Beam, Ends, PACKET, PacketVisitor, Slabs, Together, TreeKernels, Wide};
use crate::geometry::{Hit, Ray};
use glam::DVec3;
use std::cell::{Cell, RefCell, RefMut};
use std::marker::PhantomData;

/// The closest hit is looked for.
pub(super) const CLOSEST: u8 = 0;
/// Any hit ends a ray.
pub(super) const ANY: u8 = 1;
/// Any hit with an opaque object ends a ray; hits with others are noted.
pub(super) const OPAQUE: u8 = 2;

/// What rays are traced with.
pub(super) struct Source<'a> {
    pub scene: &'a Scene,
    /// The best hits so far, by the numbers of the rays.
    pub hits: &'a [Cell<Option<Hit>>],
    pub room: RefCell<&'a mut Packet>,
}

/// What is found for a ray.
pub(super) struct Found {
    /// The closest hit.
    pub hit: Option<Hit>,
    /// Whether another object has been in the same place as a hit.
    pub tied: bool,
    /// Whether a hit has ended the ray.
    pub ended: bool,
    /// Whether there is something in the way that may let light through.
    pub glass: bool,
}

/// A packet on its way.
pub(super) struct Crowd<'a, K, const SEARCH: u8> {
    scene: &'a Scene,
    hits: &'a [Cell<Option<Hit>>],
    /// The rays, in the order of the packet.
    room: RefMut<'a, &'a mut Packet>,
    balls: BallRays,
    /// Rays with something in the way that may let light through, a bit each.
    glass: u64,
    kernels: PhantomData<K>,
}

/// More than rounding to f32 takes away.
const LONGER: f64 = 1.0 + 4.0 / 16_777_216.0;

/// So many rays of eight meet a ball one after the other.
const ALONE: u32 = 2;

impl<K: TreeKernels, const SEARCH: u8> Crowd<'_, K, SEARCH> {
    /// Whether an object may let light through, if that matters.
    #[inline(always)]
    fn is_glass(&self, object: u32) -> bool {
        SEARCH == OPAQUE && self.scene.may_transmit(object)
    }

    /// Meets an object that is no ball with some rays. Returns those that it ends.
    fn meet(&mut self, filled: usize, slabs: &mut Slabs, index: u32, rays: u64) -> u64 {
        let (scene, is_glass) = (self.scene, self.is_glass(index));
        let object = &scene.objects()[index as usize];
        let rays = if is_glass { rays & !self.glass } else { rays };
        let packet: &mut Packet = &mut self.room;
        let filled = filled.min(PACKET);
        for i in 0..filled {
            packet.near[i] = (rays >> i & 1) as u8;
        }
        let mut through = 0;
        match &object.shape {
            Shape::Mesh(mesh) if is_glass => packet.look_along_mesh::<K>(filled, object, mesh, |i| through |= 1 << i),
            Shape::Mesh(mesh) if SEARCH == CLOSEST => packet.meet_mesh::<K, false>(filled, index, object, mesh),
            Shape::Mesh(mesh) => packet.meet_mesh::<K, true>(filled, index, object, mesh),
            _ => {
                let Packet { front, near, met, .. } = packet;
                let tree = &scene.geometry.tree;
                runs(&near[..filled], |range| {
                    meet_shape::<K>(tree, object, range.clone(), front, met);
                    if is_glass {
                        range.for_each(|i| through |= u64::from(!met.t[i].is_nan()) << i);
                    } else if SEARCH == CLOSEST {
                        tree.run(Keep::<false> { range, object: index }, met, front);
                    } else {
                        tree.run(Keep::<true> { range, object: index }, met, front);
                    }
                });
            }
        }
        self.glass |= through & rays;
        let mut ended = 0;
        for i in 0..filled {
            let limit = self.room.front.limit[i];
            if SEARCH == CLOSEST {
                slabs.limit.0[i] = slabs.limit.0[i].min((limit * LONGER) as f32);
            } else {
                ended |= u64::from(limit == DONE) << i;
            }
        }
        ended & rays
    }

    /// Meets a ball with some rays. Returns those that it ends.
    #[inline(always)]
    fn meet_ball(&mut self, slabs: &mut Slabs, (index, centre, radius): (u32, DVec3, f64), rays: u64) -> u64 {
        let mut ended = 0;
        let mut t = [f64::NAN; 8];
        for at in (0..PACKET).step_by(8) {
            let mut eight = (rays >> at) as u8;
            if eight == 0 {
                continue;
            }
            let front = &self.room.front;
            if eight.count_ones() <= ALONE {
                for k in 0..8 {
                    if eight >> k & 1 != 0 {
                        #[allow(clippy::manual_unwrap_or)] // `Option::unwrap_or` is not inlined always.
                        let met = match K::sphere(&front.ray(at + k), centre, radius) {
                            Some(t) => t,
                            None => f64::NAN,
                        };
                        t[k] = met;
                    }
                }
            } else {
                for k in 0..8 {
                    #[allow(clippy::manual_unwrap_or)] // As above.
                    let met = match K::sphere(&front.ray(at + k), centre, radius) {
                        Some(t) => t,
                        None => f64::NAN,
                    };
                    t[k] = met;
                }
            }
            while eight != 0 {
                let k = eight.trailing_zeros() as usize & 7;
                eight &= eight - 1;
                let hit = Hit { t: t[k], object: index, primitive: 0, u: 0.0, v: 0.0 };
                if !t[k].is_nan() && self.take(slabs, at + k, hit) {
                    ended |= 1 << (at + k);
                }
            }
        }
        ended
    }

    /// Takes a hit of one ray. Whether that ends it.
    #[inline(always)]
    fn take(&mut self, slabs: &mut Slabs, i: usize, hit: Hit) -> bool {
        if SEARCH == CLOSEST {
            self.room.offer(i, hit);
            slabs.limit.0[i] = slabs.limit.0[i].min((self.room.front.limit[i] * LONGER) as f32);
            return false;
        }
        if self.is_glass(hit.object) {
            self.glass |= 1 << i;
            return false;
        }
        self.room.front.limit[i] = DONE;
        true
    }

    #[inline(always)]
    fn block(&self, block: u32) -> &BallBlock {
        &self.scene.geometry.balls[block as usize]
    }
}

impl<'a, K: TreeKernels, const SEARCH: u8> PacketVisitor for Crowd<'a, K, SEARCH> {
    type Source = &'a Source<'a>;
    type Found = Found;
    const ANY_HIT: bool = SEARCH != CLOSEST;
    const LEAST: u32 = 9;
    const SLACK: f32 = 0.0;

    #[inline(always)]
    fn is_fit(ray: &Ray, extent: f64) -> bool {
        BallRays::is_fit(ray, extent)
    }

    #[inline(always)]
    fn new(source: &'a Source<'a>) -> Self {
        let Source { scene, hits, room } = source;
        Self { scene, hits, room: room.borrow_mut(), balls: BallRays::new(), glass: 0, kernels: PhantomData }
    }

    #[inline(always)]
    fn take(&mut self, together: &Together, _ends: &Ends, extent: f64) -> bool {
        if !self.balls.take(together, extent) {
            return false;
        }
        let filled = together.filled.min(PACKET);
        let front = &mut self.room.front;
        for axis in 0..3 {
            front.origin[axis][..filled].copy_from_slice(&together.origin[axis].0[..filled]);
            front.direction[axis][..filled].copy_from_slice(&together.direction[axis].0[..filled]);
        }
        front.t_min[..filled].copy_from_slice(&together.t_min.0[..filled]);
        front.t_max[..filled].copy_from_slice(&together.t_max.0[..filled]);
        front.limit[..filled].copy_from_slice(&together.t_max.0[..filled]);
        front.t[..filled].fill(f64::INFINITY);
        front.object[..filled].fill(u32::MAX);
        front.primitive[..filled].fill(u32::MAX);
        front.tied[..filled].fill(0);
        if SEARCH == CLOSEST {
            for i in 0..together.count.min(PACKET) {
                if let Some(hit) = self.hits[usize::from(together.number[i])].get() {
                    (front.t[i], front.object[i], front.primitive[i]) = (hit.t, hit.object, hit.primitive);
                }
            }
        }
        true
    }

    #[inline(always)]
    fn cull<E: Wide>(&mut self, e: E, beam: &Beam<E>, block: u32) -> u32 {
        match self.scene.geometry.leaves[block as usize] {
            Leaf::Object(_) => 1,
            Leaf::Balls(block) => self.block(block).cull(e, beam),
        }
    }

    #[inline(always)]
    fn visit_across<W: Wide>(
        &mut self,
        w: W,
        together: &Together,
        slabs: &mut Slabs,
        block: u32,
        mut slots: u32,
        rays: u64,
    ) -> u64 {
        let block = match self.scene.geometry.leaves[block as usize] {
            Leaf::Object(index) => return self.meet(together.filled, slabs, index, rays),
            Leaf::Balls(block) => block,
        };
        let mut ended = 0;
        while slots != 0 {
            let lane = slots.trailing_zeros() as usize & 7;
            slots &= slots - 1;
            let ball = self.block(block).ball(lane);
            let mut left = rays & !ended;
            if self.is_glass(ball.0) {
                left &= !self.glass;
            }
            let mut near = 0;
            for at in (0..PACKET).step_by(W::LANES) {
                if left >> at & ((1 << W::LANES) - 1) != 0 {
                    near |= u64::from(self.balls.near_ball(w, slabs, self.block(block), lane, at)) << at;
                }
            }
            ended |= self.meet_ball(slabs, ball, near & left);
        }
        ended
    }

    #[inline(always)]
    fn visit_one<E: Wide>(&mut self, e: E, _together: &Together, slabs: &mut Slabs, block: u32, i: usize) -> bool {
        let ray = self.room.front.ray(i & (PACKET - 1));
        let block = match self.scene.geometry.leaves[block as usize] {
            Leaf::Object(index) => {
                let object = &self.scene.objects()[index as usize];
                if SEARCH == CLOSEST {
                    return object.intersect::<K>(&ray, index).is_some_and(|hit| self.take(slabs, i, hit));
                }
                let hit = Hit { t: 0.0, object: index, primitive: 0, u: 0.0, v: 0.0 };
                return object.occluded::<K>(&ray) && self.take(slabs, i, hit);
            }
            Leaf::Balls(block) => block,
        };
        let mut near = self.balls.near_ray(e, slabs, self.block(block), i);
        while near != 0 {
            let (object, centre, radius) = self.block(block).ball(near.trailing_zeros() as usize);
            near &= near - 1;
            let ray = self.room.front.ray(i & (PACKET - 1));
            if let Some(t) = K::sphere(&ray, centre, radius)
                && self.take(slabs, i, Hit { t, object, primitive: 0, u: 0.0, v: 0.0 })
            {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn finish(&mut self, together: &Together, ended: u64, mut found: impl FnMut(usize, Found)) {
        for i in 0..together.count.min(PACKET) {
            let hit = if SEARCH == CLOSEST { self.room.hit(i, self.scene.objects()) } else { None };
            let of_ray = Found {
                hit,
                tied: self.room.front.tied[i] != 0,
                ended: ended >> i & 1 != 0,
                glass: self.glass >> i & 1 != 0,
            };
            found(usize::from(together.number[i]), of_ray);
        }
    }
}
