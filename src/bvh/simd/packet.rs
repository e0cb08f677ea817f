//! Front-to-back traversal of rays that run alike: they share the nodes and, where many reach a leaf, the triangles
//! (kernels.md, lesson 4).
//!
//! One test with intervals that hold all origins and directions finds the children that any ray may meet, eight at once; each
//! of those few is then tested against as many rays at a time as there are lanes. A subtree that few rays reach is finished ray by ray.
//!
//! Rays of several octants are traced octant by octant: 12 to 37 % where rays end at a light or come from a mirror (interior and blobs100k S,
//! R). How far apart directions are does not matter then: with a limit mirrored rays took 1.1 to 1.4 times as long.

use super::beam::Beam;
use super::rays::{Ends, Slabs, Together};
use super::traverse::STACK;
use super::wide::{Wide, ones};
use super::{Isa, Portable};
#[cfg(target_arch = "x86_64")]
use super::{wide::Avx512, x86::Avx2};
use crate::bvh::{Bvh, Child};
use crate::geometry::Ray;
use std::mem::MaybeUninit;

/// Rays that are traversed together at most.
pub const PACKET: usize = 64;

/// Subtrees that no more rays reach are finished ray by ray. 6 to 16 are alike (interior, blobs100k, blobs1M).
const FEW: u32 = 8;

/// What is done with the leaves on the way of a packet.
pub trait PacketVisitor: Sized {
    /// What a visitor is made from.
    type Source: Copy;

    /// What it finds for a ray.
    type Found;

    /// Whether any hit ends a ray's search.
    const ANY_HIT: bool;

    /// Fewer rays are not worth a packet.
    const LEAST: u32;

    /// How far a hit may lie outside of the triangle's box, in units of 2^-24 times the largest coordinate of tree and origin.
    const SLACK: f32;

    /// Whether a ray can be taken at all. If not, [`PacketVisitor::take`] refuses it, and those that are with it.
    fn is_fit(ray: &Ray, extent: f64) -> bool;

    /// A visitor without rays.
    fn new(source: Self::Source) -> Self;

    /// Takes rays that lie within `ends`. False if it can not. (Not by `new`: kilobytes would be copied.)
    fn take(&mut self, together: &Together, ends: &Ends, extent: f64) -> bool;

    /// Meets what is in no box. Lowers limits; returns the rays that it has ended.
    #[inline(always)]
    fn begin(&mut self, _together: &Together, _slabs: &mut Slabs) -> u64 {
        0
    }

    /// Which slots of a block the rays of a beam may meet, a bit each. Called before a block is visited by several rays.
    fn cull<E: Wide>(&mut self, eight: E, beam: &Beam<E>, block: u32) -> u32;

    /// Tests some slots of a block against some rays, as many rays at a time as there are lanes. Lowers limits; returns the rays that
    /// it has ended.
    fn visit_across<W: Wide>(
        &mut self,
        wide: W,
        together: &Together,
        slabs: &mut Slabs,
        block: u32,
        slots: u32,
        rays: u64,
    ) -> u64;

    /// Tests a block against one ray. True ends it.
    fn visit_one<E: Wide>(&mut self, eight: E, together: &Together, slabs: &mut Slabs, block: u32, ray: usize) -> bool;

    /// Hands over what was found.
    fn finish(&mut self, together: &Together, ended: u64, found: impl FnMut(usize, Self::Found));
}

impl Bvh {
    /// Traces up to [`PACKET`] rays, those together that run alike, and hands to `found` the number of each and what the visitor has
    /// found for it. Returns the rays that are left, a bit each: those that no others run like, or that can not be taken.
    #[inline]
    pub fn traverse_packet<V: PacketVisitor>(
        &self,
        rays: &[Ray],
        source: V::Source,
        found: &mut impl FnMut(usize, V::Found),
    ) -> u64 {
        let rays = &rays[..rays.len().min(PACKET)];
        if self.nodes.is_empty() || rays.len() < V::LEAST as usize {
            return first(rays.len());
        }
        match self.isa {
            Isa::Portable => sort::<_, _, V>(Portable, Portable, self, rays, source, found),
            // SAFETY: a tree gets its instruction set from `Isa::best` or after `Isa::is_available` (`Bvh::build` checks).
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => unsafe { packet_avx2::<V>(self, rays, source, found) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => unsafe { packet_avx512::<V>(self, rays, source, found) },
            #[cfg(not(target_arch = "x86_64"))]
            _ => sort::<_, _, V>(Portable, Portable, self, rays, source, found),
        }
    }
}

/// # Safety
/// The processor has what [`Isa::Avx2`] names.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn packet_avx2<V: PacketVisitor>(
    tree: &Bvh,
    rays: &[Ray],
    source: V::Source,
    found: &mut impl FnMut(usize, V::Found),
) -> u64 {
    // SAFETY: this function's own condition.
    let eight = unsafe { Avx2::new() };
    sort::<_, _, V>(eight, eight, tree, rays, source, found)
}

/// # Safety
/// The processor has what [`Isa::Avx512`] names.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq,avx512bw")]
unsafe fn packet_avx512<V: PacketVisitor>(
    tree: &Bvh,
    rays: &[Ray],
    source: V::Source,
    found: &mut impl FnMut(usize, V::Found),
) -> u64 {
    // SAFETY: this function's own condition.
    let (eight, wide) = unsafe { (Avx2::new(), Avx512::new()) };
    sort::<_, _, V>(eight, wide, tree, rays, source, found)
}

/// A child that waits, with a lower bound of where the rays that reach it enter.
#[derive(Clone, Copy)]
struct Waiting {
    child: Child,
    distance: f32,
    /// A bit a ray.
    rays: u64,
}

/// The lowest `count` bits.
#[inline(always)]
fn first(count: usize) -> u64 {
    if count == 0 { 0 } else { u64::MAX >> (PACKET - count) }
}

/// Traces the rays of each octant together. Returns the rays that are left.
#[inline(always)]
fn sort<E: Wide, W: Wide, V: PacketVisitor>(
    eight: E,
    wide: W,
    tree: &Bvh,
    rays: &[Ray],
    source: V::Source,
    found: &mut impl FnMut(usize, V::Found),
) -> u64 {
    let count = rays.len();
    let mut left = first(count);
    let (mut any, mut all) = (0, 7);
    for ray in rays {
        let octant = octant_of(ray);
        (any, all) = (any | octant, all & octant);
    }
    // In most packets all are of one octant, and all can be taken.
    let mut octants = [0; 8];
    octants[0] = left;
    let mut sorted = false;
    if any != all {
        (octants, sorted) = (by_octant::<V>(rays, tree.extent), true);
    }
    let mut at = 0;
    // The one place where packets are traced: with two, half of what is in them was not inlined.
    while at < 8 {
        let which = octants[at];
        at += 1;
        if which.count_ones() < V::LEAST {
            continue;
        }
        if traverse::<_, _, V>(eight, wide, tree, rays, which, source, found) {
            left &= !which;
        } else if !sorted {
            // Without those that can not be taken, if that is why.
            let fit = by_octant::<V>(rays, tree.extent);
            if fit.iter().fold(0, |all, octant| all | octant) != which {
                (octants, sorted, at) = (fit, true, 0);
            }
        }
    }
    left
}

/// The rays that can be taken, by octant of their directions, a bit each.
#[inline(always)]
fn by_octant<V: PacketVisitor>(rays: &[Ray], extent: f64) -> [u64; 8] {
    let mut octants = [0; 8];
    for (i, ray) in rays.iter().enumerate() {
        octants[octant_of(ray)] |= u64::from(V::is_fit(ray, extent)) << i;
    }
    octants
}

/// Signs of the direction, a bit an axis.
#[inline(always)]
fn octant_of(ray: &Ray) -> usize {
    let sign = |v: f64| (v.to_bits() >> 63) as usize;
    sign(ray.direction.x) | sign(ray.direction.y) << 1 | sign(ray.direction.z) << 2
}

/// Traces some rays of one octant together. False if they do not run alike.
#[inline(always)]
fn traverse<E: Wide, W: Wide, V: PacketVisitor>(
    eight: E,
    wide: W,
    tree: &Bvh,
    rays: &[Ray],
    which: u64,
    source: V::Source,
    found: &mut impl FnMut(usize, V::Found),
) -> bool {
    let together = Together::new(rays, which);
    let count = together.count;
    let ends = Ends::new(&together);
    let mut visitor = V::new(source);
    if !visitor.take(&together, &ends, tree.extent) {
        return false;
    }
    let mut slabs = Slabs::new();
    slabs.take(&together, V::SLACK, tree.extent);
    let Some(beam) = Beam::new(eight, wide, &ends, &mut slabs, together.filled, tree.extent) else { return false };
    // Rays that the visitor has not ended.
    let all = first(count);
    let mut alive = all & !visitor.begin(&together, &mut slabs);
    let mut stack = [MaybeUninit::<Waiting>::uninit(); STACK];
    stack[0].write(Waiting { child: Child(0), distance: 0.0, rays: alive });
    let mut top = 1;
    while top > 0 {
        top -= 1;
        // SAFETY: entries below `top` have been written.
        let Waiting { child, distance, rays: mut active } = unsafe { stack.get_unchecked(top).assume_init() };
        active &= alive;
        let from = wide.splat(distance);
        let mut groups = 0;
        for at in (0..PACKET).step_by(W::LANES) {
            let group = active >> at & lanes_mask::<W>();
            if group != 0 {
                let before = u64::from(wide.le(from, wide.load(&slabs.limit.0[at..])));
                active &= !(!before & lanes_mask::<W>()) << at | !(lanes_mask::<W>() << at);
                groups += 1;
            }
        }
        if active == 0 {
            continue;
        }
        if child.is_leaf() {
            let (first, blocks) = child.blocks();
            for block in first..first + blocks {
                let slots = visitor.cull(eight, &beam, block);
                if slots == 0 {
                    continue;
                }
                active &= alive;
                if slots.count_ones() * groups <= active.count_ones() {
                    alive &= !visitor.visit_across(wide, &together, &mut slabs, block, slots, active);
                } else {
                    each(active, |i| {
                        if visitor.visit_one(eight, &together, &mut slabs, block, i) {
                            alive &= !(1 << i);
                        }
                    });
                }
            }
            if alive == 0 {
                break;
            }
            continue;
        }
        if active.count_ones() <= FEW {
            each(active, |i| {
                if walk(eight, tree, &together, &mut slabs, &mut visitor, i, child) {
                    alive &= !(1 << i);
                }
            });
            if alive == 0 {
                break;
            }
            continue;
        }
        // SAFETY: inner children are made by `collapse` from indices of nodes it has pushed (`Bvh::validate`).
        let node = unsafe { tree.nodes.get_unchecked(child.0 as usize) };
        let (mut mask, distances, whole) = beam.entries(eight, &node.planes);
        let mut entries = [0.0; 8];
        eight.store(distances, &mut entries);
        let bottom = top;
        while mask != 0 {
            let k = mask.trailing_zeros() as usize & 7;
            mask &= mask - 1;
            let mut reach = active;
            if whole >> k & 1 == 0 {
                reach = 0;
                for at in (0..PACKET).step_by(W::LANES) {
                    if active >> at & lanes_mask::<W>() != 0 {
                        reach |= u64::from(slabs.meet(wide, at, &node.planes, k)) << at;
                    }
                }
                reach &= active;
                if reach == 0 {
                    continue;
                }
            }
            let new = Waiting { child: node.children[k], distance: entries[k], rays: reach };
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
    visitor.finish(&together, all & !alive, found);
    true
}

/// A bit a lane.
#[inline(always)]
fn lanes_mask<W: Wide>() -> u64 {
    (1 << W::LANES) - 1
}

/// Calls `visit` with the number of each bit.
#[inline(always)]
fn each(mut bits: u64, mut visit: impl FnMut(usize)) {
    while bits != 0 {
        visit(bits.trailing_zeros() as usize & (PACKET - 1));
        bits &= bits - 1;
    }
}

/// Visits the leaves of a subtree that one of the rays may meet, nearer ones first. Whether the visitor ended it.
#[inline(always)]
fn walk<E: Wide, V: PacketVisitor>(
    e: E,
    tree: &Bvh,
    together: &Together,
    slabs: &mut Slabs,
    visitor: &mut V,
    ray: usize,
    from: Child,
) -> bool {
    let (reciprocal, near_reciprocal) = (ones(e, &slabs.reciprocal, ray), ones(e, &slabs.near_reciprocal, ray));
    let (near, far, t_min) = (ones(e, &slabs.near, ray), ones(e, &slabs.far, ray), slabs.t_min.one(e, ray));
    // Distances are not negative: their bits compare as they do.
    let keyed = |distance: f32, child: Child| u64::from(distance.to_bits()) << 32 | u64::from(child.0);
    let mut stack = [MaybeUninit::<u64>::uninit(); STACK];
    stack[0].write(keyed(0.0, from));
    let mut top = 1;
    while top > 0 {
        top -= 1;
        // SAFETY: entries below `top` have been written.
        let key = unsafe { stack.get_unchecked(top).assume_init() };
        let limit = slabs.limit.0[ray];
        if f32::from_bits((key >> 32) as u32) > limit {
            continue;
        }
        let child = Child(key as u32);
        if child.is_leaf() {
            let (first, count) = child.blocks();
            for block in first..first + count {
                if visitor.visit_one(e, together, slabs, block, ray) {
                    return true;
                }
            }
            continue;
        }
        // SAFETY: inner children are made by `collapse` from indices of nodes it has pushed (`Bvh::validate`).
        let node = unsafe { tree.nodes.get_unchecked(child.0 as usize) };
        let (mut enter, mut exit) = (t_min, e.splat(limit));
        for axis in 0..3 {
            let row = slabs.rows[axis];
            // SAFETY: rows are below 6 (`Beam::new`).
            let (first, last) = unsafe { (node.planes.get_unchecked(row), node.planes.get_unchecked(row ^ 1)) };
            enter = e.max(e.mul_sub(e.load(first), near_reciprocal[axis], near[axis]), enter);
            exit = e.min(e.mul_sub(e.load(last), reciprocal[axis], far[axis]), exit);
        }
        let mut mask = e.le(enter, exit);
        if mask == 0 {
            continue;
        }
        let mut distances = [0.0; 8];
        e.store(enter, &mut distances);
        let bottom = top;
        while mask != 0 {
            let k = mask.trailing_zeros() as usize & 7;
            mask &= mask - 1;
            let new = keyed(distances[k], node.children[k]);
            let mut at = top;
            debug_assert!(top < STACK);
            // SAFETY: at most eight entries a level in place of one, MAX_DEPTH levels (`Bvh::validate`); entries below `top` have been
            // written.
            unsafe {
                while !V::ANY_HIT && at > bottom && stack.get_unchecked(at - 1).assume_init() < new {
                    let moved = *stack.get_unchecked(at - 1);
                    *stack.get_unchecked_mut(at) = moved;
                    at -= 1;
                }
                stack.get_unchecked_mut(at).write(new);
            }
            top += 1;
        }
    }
    false
}
