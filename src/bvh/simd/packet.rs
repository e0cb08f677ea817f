//! Front-to-back traversal of rays that run alike: they share the nodes, not the blocks in the leaves (kernels.md, lesson 4).
//!
//! One test with intervals that hold all origins and directions finds the children that any ray may meet, eight at once; each
//! of those few is then tested against eight rays at a time. A subtree that few rays reach is finished ray by ray.

#![allow(clippy::needless_range_loop)] // Numbers of rays and axes run over several arrays at once.

use super::traverse::{STACK, walk};
#[cfg(target_arch = "x86_64")]
use super::x86::Avx2;
use super::{Isa, Lanes, LeafVisitor, Portable};
use crate::bvh::{BoxTest, Bvh, Child};
use crate::geometry::{PaddedSlab, Ray, Slab};
use std::mem::MaybeUninit;

/// Rays that are traversed together at most.
pub const PACKET: usize = 64;

/// Subtrees that no more rays reach are finished ray by ray; fewer rays are no packet.
const FEW: u32 = 12;

/// Rays whose directions differ by more than this, all axes together, are traced one by one: mirrored by a curved mesh they took
/// 1.09 times as long in packets, in random directions 1.16 times (`study kernel scenes/mesh.toml`).
const WIDEST: f64 = 0.5;

impl Bvh {
    /// Does for each ray what [`Bvh::traverse`] does with [`PaddedSlab`], in another order, and hands its number, whether its visitor
    /// ended it, and the visitor to `finish`. Does nothing and returns false where rays do not run alike.
    #[inline]
    pub fn traverse_packet<V: LeafVisitor, F: FnMut(usize, bool, V)>(
        &self,
        rays: &[Ray],
        sources: &[V::Source],
        finish: F,
    ) -> bool {
        if self.nodes.is_empty() || rays.len() <= FEW as usize || rays.len() > PACKET || sources.len() < rays.len() {
            return false;
        }
        match self.isa {
            Isa::Portable => traverse(Portable, self, rays, sources, finish),
            // SAFETY: a tree gets its instruction set from `Isa::best` or after `Isa::is_available` (`Bvh::build` checks).
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => unsafe { packet_avx2(self, rays, sources, finish) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => unsafe { packet_avx512(self, rays, sources, finish) },
            #[cfg(not(target_arch = "x86_64"))]
            _ => traverse(Portable, self, rays, sources, finish),
        }
    }
}

/// # Safety
/// The processor has what [`Isa::Avx2`] names.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn packet_avx2<V: LeafVisitor, F: FnMut(usize, bool, V)>(
    tree: &Bvh,
    rays: &[Ray],
    sources: &[V::Source],
    finish: F,
) -> bool {
    // SAFETY: this function's own condition.
    traverse(unsafe { Avx2::new() }, tree, rays, sources, finish)
}

/// # Safety
/// The processor has what [`Isa::Avx512`] names.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq,avx512bw")]
unsafe fn packet_avx512<V: LeafVisitor, F: FnMut(usize, bool, V)>(
    tree: &Bvh,
    rays: &[Ray],
    sources: &[V::Source],
    finish: F,
) -> bool {
    // SAFETY: this function's own condition.
    traverse(unsafe { Avx2::new() }, tree, rays, sources, finish)
}

/// A child that waits, with a lower bound of where the rays that reach it enter.
#[derive(Clone, Copy)]
struct Waiting {
    child: Child,
    distance: f32,
    /// A bit a ray.
    rays: u64,
}

/// Eight numbers a row, one a ray.
type Row = [[f32; 8]; PACKET / 8];

/// The numbers of [`PaddedSlab`]s, side by side.
struct Slabs {
    reciprocal: [Row; 3],
    near_reciprocal: [Row; 3],
    near: [Row; 3],
    far: [Row; 3],
    t_min: Row,
    limit: Row,
}

/// Intervals that hold the rays of a packet.
struct Beam<L: Lanes> {
    /// Row of the near plane of each axis; the far one is its neighbour, row ^ 1.
    rows: [usize; 3],
    /// Ends of the origins that are nearest to the near planes, and to the far planes.
    origin: [[L::V; 3]; 2],
    /// Least and greatest.
    reciprocal: [[L::V; 3]; 2],
    t_min: L::V,
}

impl<L: Lanes> Beam<L> {
    /// The intervals; `None` if the rays are of different octants, spread too widely or not finite.
    #[inline(always)]
    fn new(lanes: L, rays: &[Ray], slabs: &Slabs, extent: f64) -> Option<Self> {
        let mut rows = [0; 3];
        let zero = lanes.splat(0.0);
        let mut beam = Self { rows, origin: [[zero; 3]; 2], reciprocal: [[zero; 3]; 2], t_min: zero };
        let mut spread = 0.0;
        for axis in 0..3 {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            let (mut left, mut right) = (low, high);
            let mut sum = 0.0;
            for ray in rays {
                let (o, d) = (ray.origin[axis], ray.direction[axis]);
                (low, high) = (if o < low { o } else { low }, if o > high { o } else { high });
                (left, right) = (if d < left { d } else { left }, if d > right { d } else { right });
                sum += o;
            }
            spread += right - left;
            let (mut least, mut greatest) = (lanes.splat(f32::INFINITY), lanes.splat(f32::NEG_INFINITY));
            for row in &slabs.reciprocal[axis] {
                let row = lanes.load(row);
                (least, greatest) = (lanes.min(row, least), lanes.max(row, greatest));
            }
            let (least, greatest) = (lanes.store(least), lanes.store(greatest));
            let (mut first, mut last) = (least[0], greatest[0]);
            for k in 1..8 {
                first = if least[k] < first { least[k] } else { first };
                last = if greatest[k] > last { greatest[k] } else { last };
            }
            let negative = last < 0.0;
            if !((negative || first > 0.0) && (first - last).is_finite() && f64::is_finite(sum)) {
                return None;
            }
            rows[axis] = 2 * axis + usize::from(negative);
            // Two roundings of the origin and its difference to a plane, and what `PaddedSlab` pads for components that are
            // almost zero; what else is rounded is relative to t and made up for below.
            let pad = (low.abs().max(high.abs()) + extent) * 2f64.powi(-21);
            let (low, high) = ((low - pad) as f32, (high + pad) as f32);
            let (to_near, to_far) = if negative { (low, high) } else { (high, low) };
            beam.origin[0][axis] = lanes.splat(to_near);
            beam.origin[1][axis] = lanes.splat(to_far);
            beam.reciprocal[0][axis] = lanes.splat(first);
            beam.reciprocal[1][axis] = lanes.splat(last);
        }
        beam.rows = rows;
        (spread <= WIDEST * rays[0].direction.length()).then_some(beam)
    }

    /// Which children any ray may meet, a bit each, and lower bounds of where they are entered.
    #[inline(always)]
    fn entries(&self, lanes: L, planes: &[[f32; 8]; 6], limit: f32) -> (u32, L::V) {
        let [r0, r1] = &self.reciprocal;
        let (mut enter, mut exit) = (self.t_min, lanes.splat(limit));
        for axis in 0..3 {
            // SAFETY: `new` makes rows below 6.
            let (near, far) =
                unsafe { (planes.get_unchecked(self.rows[axis]), planes.get_unchecked(self.rows[axis] ^ 1)) };
            let near = lanes.sub(lanes.load(near), self.origin[0][axis]);
            let far = lanes.sub(lanes.load(far), self.origin[1][axis]);
            enter = lanes.max(lanes.min(lanes.mul(near, r0[axis]), lanes.mul(near, r1[axis])), enter);
            exit = lanes.min(lanes.max(lanes.mul(far, r0[axis]), lanes.mul(far, r1[axis])), exit);
        }
        let enter = lanes.mul(enter, lanes.splat(PaddedSlab::ENTRY_FACTOR as f32));
        let exit = lanes.mul(exit, lanes.splat((2.0 - PaddedSlab::ENTRY_FACTOR) as f32));
        (lanes.bits(lanes.le(enter, exit)), enter)
    }
}

impl Slabs {
    /// Which rays of a group of eight meet one box, a bit each.
    #[inline(always)]
    fn meet<L: Lanes>(&self, lanes: L, group: usize, rows: [usize; 3], planes: &[[f32; 8]; 6], child: usize) -> u32 {
        let mut enter = lanes.load(&self.t_min[group]);
        let mut exit = lanes.load(&self.limit[group]);
        for axis in 0..3 {
            // SAFETY: rows are below 6 (`Beam::new`).
            let (near, far) = unsafe { (planes.get_unchecked(rows[axis]), planes.get_unchecked(rows[axis] ^ 1)) };
            let row = |rows: &[Row; 3]| lanes.load(&rows[axis][group]);
            let near = lanes.mul_sub(lanes.splat(near[child]), row(&self.near_reciprocal), row(&self.near));
            let far = lanes.mul_sub(lanes.splat(far[child]), row(&self.reciprocal), row(&self.far));
            (enter, exit) = (lanes.max(near, enter), lanes.min(far, exit));
        }
        lanes.bits(lanes.le(enter, exit))
    }
}

#[inline(always)]
fn traverse<L: Lanes, V: LeafVisitor, F: FnMut(usize, bool, V)>(
    lanes: L,
    tree: &Bvh,
    rays: &[Ray],
    sources: &[V::Source],
    mut finish: F,
) -> bool {
    let row = [[0.0; 8]; PACKET / 8];
    let rows = [row; 3];
    let mut slabs = Slabs { reciprocal: rows, near_reciprocal: rows, near: rows, far: rows, t_min: row, limit: row };
    let mut tests = [MaybeUninit::<PaddedSlab>::uninit(); PACKET];
    let count = rays.len().min(PACKET);
    for i in 0..PACKET {
        // The first ray fills the last group up.
        let test = if i < count { PaddedSlab::new(&rays[i], tree.extent) } else { break };
        if test.start() != 0.0 {
            return false;
        }
        for axis in 0..3 {
            slabs.reciprocal[axis][i / 8][i % 8] = test.reciprocal[axis];
            slabs.near_reciprocal[axis][i / 8][i % 8] = test.near_reciprocal[axis];
            slabs.near[axis][i / 8][i % 8] = test.near[axis];
            slabs.far[axis][i / 8][i % 8] = test.far[axis];
        }
        slabs.t_min[i / 8][i % 8] = test.t_min;
        slabs.limit[i / 8][i % 8] = test.limit(rays[i].t_max);
        tests[i].write(test);
    }
    for i in count..PACKET {
        for axis in 0..3 {
            slabs.reciprocal[axis][i / 8][i % 8] = slabs.reciprocal[axis][0][0];
        }
    }
    let Some(beam) = Beam::new(lanes, rays, &slabs, tree.extent) else { return false };
    let mut visitors = [const { MaybeUninit::<V>::uninit() }; PACKET];
    let mut t_max = [0.0; PACKET];
    for i in 0..count {
        visitors[i].write(V::new(sources[i], &rays[i]));
        t_max[i] = rays[i].t_max;
    }
    // Rays that the visitors have not ended.
    let all = u64::MAX >> (PACKET - count);
    let mut alive = all;
    let mut stack = [MaybeUninit::<Waiting>::uninit(); STACK];
    stack[0].write(Waiting { child: Child(0), distance: 0.0, rays: all });
    let mut top = 1;
    while top > 0 {
        top -= 1;
        // SAFETY: entries below `top` have been written.
        let Waiting { child, distance, rays: mut active } = unsafe { stack.get_unchecked(top).assume_init() };
        active &= alive;
        let from = lanes.splat(distance);
        for group in 0..PACKET / 8 {
            let reached = lanes.bits(lanes.le(from, lanes.load(&slabs.limit[group])));
            active &= !(u64::from(!reached & 0xff) << (8 * group));
        }
        if active == 0 {
            continue;
        }
        if child.is_leaf() || active.count_ones() <= FEW {
            while active != 0 {
                let i = active.trailing_zeros() as usize & (PACKET - 1);
                active &= active - 1;
                // SAFETY: those of the first `count` rays have been written, and only they are active.
                let (test, visitor) = unsafe { (tests[i].assume_init_ref(), visitors[i].assume_init_mut()) };
                let before = t_max[i];
                let mut ended = false;
                if child.is_leaf() {
                    let (first, blocks) = child.blocks();
                    for block in first..first + blocks {
                        ended |= visitor.visit(lanes, block, &mut t_max[i]);
                    }
                } else {
                    ended = walk(lanes, tree, test, &test.prepare(lanes), visitor, &mut t_max[i], child);
                }
                if ended {
                    alive &= !(1 << i);
                } else if t_max[i] < before {
                    slabs.limit[i / 8][i % 8] = test.limit(t_max[i]);
                }
            }
            if alive == 0 {
                break;
            }
            continue;
        }
        // SAFETY: inner children are made by `collapse` from indices of nodes it has pushed (`Bvh::validate`).
        let node = unsafe { tree.nodes.get_unchecked(child.0 as usize) };
        let (mut mask, distances) = beam.entries(lanes, &node.planes, f32::INFINITY);
        let distances = lanes.store(distances);
        let bottom = top;
        while mask != 0 {
            let k = mask.trailing_zeros() as usize & 7;
            mask &= mask - 1;
            let mut reach = 0;
            for group in 0..PACKET / 8 {
                if (active >> (8 * group)) & 0xff != 0 {
                    reach |= u64::from(slabs.meet(lanes, group, beam.rows, &node.planes, k)) << (8 * group);
                }
            }
            reach &= active;
            if reach == 0 {
                continue;
            }
            let new = Waiting { child: node.children[k], distance: distances[k], rays: reach };
            let mut at = top;
            debug_assert!(top < STACK);
            // SAFETY: at most eight entries a level in place of one, MAX_DEPTH levels (`Bvh::validate`); entries below `top` have been
            // written. Nearest on top.
            unsafe {
                while !V::ANY_HIT && at > bottom && stack.get_unchecked(at - 1).assume_init().distance < new.distance {
                    let moved = *stack.get_unchecked(at - 1);
                    *stack.get_unchecked_mut(at) = moved;
                    at -= 1;
                }
                stack.get_unchecked_mut(at).write(new);
            }
            top += 1;
        }
    }
    for i in 0..count {
        // SAFETY: those of the first `count` rays have been written, and each is read once.
        let visitor = unsafe { visitors[i].assume_init_read() };
        finish(i, alive >> i & 1 == 0, visitor);
    }
    true
}
