//! Front-to-back traversal of rays that run alike: they share the nodes and, where many reach a leaf, the triangles
//! (kernels.md, lesson 4).
//!
//! One test with intervals that hold all origins and directions finds the children that any ray may meet, eight at
//! once; each of those few is then tested against as many rays at a time as there are lanes. A subtree that few rays
//! reach is finished ray by ray. Packets of 256 rays in room that is kept take 0.84 to 0.90 of the time of packets of
//! 64 whose room was cleared for each (blobs100k and interior, P and S, both presets).
//!
//! Rays of several octants are traced octant by octant: 12 to 37 % where rays end at a light or come from a mirror
//! (interior and blobs100k S, R). How far apart directions are does not matter then: with a limit mirrored rays took
//! 1.1 to 1.4 times as long.

use super::beam::Beam;
use super::rays::{Ends, RayRows, Rays, Room, Take};
use super::set::{RaySet, each_bit};
use super::traverse::STACK;
use super::wide::{Wide, ones};
use super::{Isa, Portable, prefetch};
#[cfg(target_arch = "x86_64")]
use super::{wide::Avx512, x86::Avx2};
use crate::bvh::{Bvh, Child};
use crate::geometry::Ray;
use std::mem::MaybeUninit;

/// Rays that are traversed together at most.
pub const PACKET: usize = 256;

/// Subtrees that no more rays reach are finished ray by ray. 6 to 16 are alike (interior, blobs100k, blobs1M).
const FEW: u32 = 8;

/// In trees of more blocks children are fetched when they are put on the stack: 7 to 11 % (P and S of blobs1M, both
/// presets). In smaller ones, which stay in the caches, that cost 2 % (interior S).
const LARGE: usize = 1 << 14;

/// What is done with the leaves on the way of a packet.
pub trait PacketVisitor: Sized {
    /// What a visitor is made from.
    type Source: Copy;

    /// What it keeps of each ray.
    type Rows: RayRows;

    /// What it finds for a ray.
    type Found;

    /// Whether any hit ends a ray's search.
    const ANY_HIT: bool;

    /// Fewer rays are not worth a packet.
    const LEAST: u32;

    /// How far a hit may lie outside of the triangle's box, in units of 2^-24 times the largest coordinate of tree and
    /// origin.
    const SLACK: f32;

    /// Whether a ray can be taken at all. If not, [`PacketVisitor::take`] refuses it, and those that are with it.
    fn is_fit(ray: &Ray, extent: f64) -> bool;

    /// A visitor without rays.
    fn new(source: Self::Source) -> Self;

    /// Takes rays that lie within `ends`. False if it can not.
    fn take<W: Wide>(&mut self, wide: W, room: &mut Room<Self::Rows>, ends: &Ends, extent: f64) -> bool;

    /// Tells that a block may be asked for soon.
    #[inline(always)]
    fn expect(&self, _block: u32) {}

    /// Meets what is in no box. Lowers limits, and takes rays that it ends from `rays`.
    #[inline(always)]
    fn begin(&mut self, _room: &mut Room<Self::Rows>, _rays: &mut RaySet) {}

    /// Which slots of a block the rays of a beam may meet, a bit each. Called before a block is visited by several
    /// rays.
    fn cull<E: Wide>(&mut self, eight: E, beam: &Beam<E>, block: u32) -> u32;

    /// Tests some slots of a block against some rays of some groups, as many rays at a time as there are lanes. Lowers
    /// limits, and takes rays that it ends from `rays`.
    fn visit_across<W: Wide>(
        &mut self,
        wide: W,
        room: &mut Room<Self::Rows>,
        block: u32,
        slots: u32,
        groups: u32,
        rays: &mut RaySet,
    );

    /// Tests a block against one ray. True ends it.
    fn visit_one<E: Wide>(&mut self, eight: E, room: &mut Room<Self::Rows>, block: u32, ray: usize) -> bool;

    /// Hands over what was found.
    fn finish<W: Wide>(
        &mut self,
        wide: W,
        room: &mut Room<Self::Rows>,
        ended: &RaySet,
        found: impl FnMut(usize, Self::Found),
    );
}

impl Bvh {
    /// Traces up to [`PACKET`] rays, those together that run alike, and hands to `found` the number of each and what
    /// the visitor has found for it. Returns the rays that are left: those that no others run like, or that can not be
    /// taken.
    #[inline]
    pub fn traverse_packet<V: PacketVisitor, S: Rays + ?Sized>(
        &self,
        rays: &S,
        source: V::Source,
        room: &mut Room<V::Rows>,
        found: &mut impl FnMut(usize, V::Found),
    ) -> RaySet {
        if self.nodes.is_empty() || rays.count() < V::LEAST as usize {
            return RaySet::first(rays.count());
        }
        match self.isa {
            Isa::Portable => sort::<_, _, V, S>(Portable, Portable, self, rays, source, room, found),
            // SAFETY: a tree gets its instruction set from `Isa::best` or after `Isa::is_available` (`Bvh::build`
            // checks).
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => unsafe { packet_avx2::<V, S>(self, rays, source, room, found) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => unsafe { packet_avx512::<V, S>(self, rays, source, room, found) },
            #[cfg(not(target_arch = "x86_64"))]
            _ => sort::<_, _, V, S>(Portable, Portable, self, rays, source, room, found),
        }
    }
}

/// # Safety
/// The processor has what [`Isa::Avx2`] names.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn packet_avx2<V: PacketVisitor, S: Rays + ?Sized>(
    tree: &Bvh,
    rays: &S,
    source: V::Source,
    room: &mut Room<V::Rows>,
    found: &mut impl FnMut(usize, V::Found),
) -> RaySet {
    // SAFETY: this function's own condition.
    let eight = unsafe { Avx2::new() };
    sort::<_, _, V, S>(eight, eight, tree, rays, source, room, found)
}

/// # Safety
/// The processor has what [`Isa::Avx512`] names.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq,avx512bw")]
unsafe fn packet_avx512<V: PacketVisitor, S: Rays + ?Sized>(
    tree: &Bvh,
    rays: &S,
    source: V::Source,
    room: &mut Room<V::Rows>,
    found: &mut impl FnMut(usize, V::Found),
) -> RaySet {
    // SAFETY: this function's own condition.
    let (eight, wide) = unsafe { (Avx2::new(), Avx512::new()) };
    sort::<_, _, V, S>(eight, wide, tree, rays, source, room, found)
}

/// A child that waits (with its rays: kept elsewhere, level by level, and never copied, they took 2 to 5 % more time),
/// with a lower bound of where the rays that reach it enter.
#[derive(Clone, Copy)]
struct Waiting {
    child: Child,
    distance: f32,
    rays: RaySet,
    /// Groups in which there are any, a bit each.
    groups: u32,
}

/// Traces the rays of each octant together. Returns the rays that are left.
#[inline(always)]
fn sort<E: Wide, W: Wide, V: PacketVisitor, S: Rays + ?Sized>(
    eight: E,
    wide: W,
    tree: &Bvh,
    rays: &S,
    source: V::Source,
    room: &mut Room<V::Rows>,
    found: &mut impl FnMut(usize, V::Found),
) -> RaySet {
    let count = rays.count().min(PACKET);
    let mut left = RaySet::first(count);
    // In most packets all are of one octant, and all can be taken.
    let mut octants = [RaySet::NONE; 8];
    octants[0] = left;
    let mut sorted = false;
    let mut at = 0;
    // The one place where packets are traced: with two, half of what is in them was not inlined.
    while at < 8 {
        let which = octants[at];
        at += 1;
        if which.len() < V::LEAST {
            continue;
        }
        if traverse::<_, _, V, S>(eight, wide, tree, rays, &which, source, room, found) {
            left = left.without(&which);
        } else if !sorted {
            // Octant by octant, without those that can not be taken, if that is why.
            let fit = by_octant::<V, S>(rays, tree.extent);
            if !fit.contains(&which) {
                (octants, sorted, at) = (fit, true, 0);
            }
        }
    }
    left
}

/// The rays that can be taken, by octant of their directions.
#[inline(always)]
fn by_octant<V: PacketVisitor, S: Rays + ?Sized>(rays: &S, extent: f64) -> [RaySet; 8] {
    let mut octants = [RaySet::NONE; 8];
    for i in 0..rays.count().min(PACKET) {
        let ray = rays.ray(i);
        if V::is_fit(&ray, extent) {
            octants[octant_of(&ray)].insert(i);
        }
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
#[allow(clippy::too_many_arguments)]
fn traverse<E: Wide, W: Wide, V: PacketVisitor, S: Rays + ?Sized>(
    eight: E,
    wide: W,
    tree: &Bvh,
    rays: &S,
    which: &RaySet,
    source: V::Source,
    room: &mut Room<V::Rows>,
    found: &mut impl FnMut(usize, V::Found),
) -> bool {
    tree.run(Take::new(which), rays, room);
    let last = room.together.count - 1;
    if octant_of(&room.together.ray(0)) != octant_of(&room.together.ray(last)) {
        return false;
    }
    let ends = room.slabs.take(wide, &room.together, V::SLACK, tree.extent);
    if ends.direction.iter().any(|[low, high]| *low < 0.0 && *high > 0.0) {
        return false;
    }
    let mut visitor = V::new(source);
    if !visitor.take(wide, room, &ends, tree.extent) {
        return false;
    }
    let Some(beam) = Beam::new(eight, &ends, &mut room.slabs, tree.extent) else { return false };
    // Rays that the visitor has not ended.
    let all = RaySet::first(room.together.count);
    let mut alive = all;
    visitor.begin(room, &mut alive);
    let is_large = tree.blocks > LARGE;
    let mut stack = [MaybeUninit::<Waiting>::uninit(); STACK];
    stack[0].write(Waiting { child: Child(0), distance: 0.0, rays: alive, groups: alive.groups::<W>() });
    let mut top = 1;
    while top > 0 {
        top -= 1;
        // SAFETY: entries below `top` have been written.
        let Waiting { child, distance, rays: mut active, groups: of_all } =
            unsafe { stack.get_unchecked(top).assume_init() };
        let from = wide.splat(distance);
        let (mut groups, mut count) = (0, 0);
        each_bit(of_all.into(), |g| {
            let before = wide.le(from, room.slabs.limit.group(wide, g * W::LANES));
            let lanes = active.group::<W>(g) & alive.group::<W>(g) & before;
            active.set_group::<W>(g, lanes);
            groups |= u32::from(lanes != 0) << g;
            count += lanes.count_ones();
        });
        if groups == 0 {
            continue;
        }
        if child.is_leaf() {
            let (first, blocks) = child.blocks();
            for block in first..first + blocks {
                let slots = visitor.cull(eight, &beam, block);
                if slots == 0 {
                    continue;
                }
                if slots.count_ones() * groups.count_ones() <= count {
                    let before = active;
                    visitor.visit_across(wide, room, block, slots, groups, &mut active);
                    if V::ANY_HIT {
                        alive = alive.without(&before.without(&active));
                    }
                } else {
                    for word in 0..RaySet::WORDS {
                        let mut left = active.word(word);
                        while left != 0 {
                            let i = 64 * word + left.trailing_zeros() as usize;
                            left &= left - 1;
                            if visitor.visit_one(eight, room, block, i) {
                                active.remove(i);
                                alive.remove(i);
                            }
                        }
                    }
                }
            }
            continue;
        }
        if count <= FEW {
            for word in 0..RaySet::WORDS {
                let mut left = active.word(word);
                while left != 0 {
                    let i = 64 * word + left.trailing_zeros() as usize;
                    left &= left - 1;
                    if walk(eight, tree, room, &mut visitor, i, child) {
                        alive.remove(i);
                    }
                }
            }
            continue;
        }
        // SAFETY: inner children are made by `collapse` from indices of nodes it has pushed (`Bvh::validate`).
        let node = unsafe { tree.nodes.get_unchecked(child.0 as usize) };
        let (mask, distances, whole) = beam.entries(eight, &node.planes);
        let mut entries = [0.0; 8];
        eight.store(distances, &mut entries);
        // Group by group, so that the numbers of its rays are loaded once for all children.
        let (mut reached, mut in_groups) = ([active; 8], [groups; 8]);
        let asked = mask & !whole;
        each_bit(asked.into(), |k| (reached[k & 7], in_groups[k & 7]) = (RaySet::NONE, 0));
        if asked != 0 {
            each_bit(groups.into(), |g| {
                let (rays, lanes) = (room.slabs.of_group(wide, g * W::LANES), active.group::<W>(g));
                each_bit(asked.into(), |k| {
                    let met = rays.meet(wide, &room.slabs.rows, &node.planes, k & 7) & lanes;
                    reached[k & 7].set_group::<W>(g, met);
                    in_groups[k & 7] |= u32::from(met != 0) << g;
                });
            });
        }
        let bottom = top;
        each_bit(mask.into(), |k| {
            let k = k & 7;
            if in_groups[k] == 0 {
                return;
            }
            let child = node.children[k];
            if is_large {
                if child.is_leaf() {
                    visitor.expect(child.blocks().0);
                } else {
                    prefetch(&tree.nodes[child.0 as usize]);
                }
            }
            let new = Waiting { child, distance: entries[k], rays: reached[k], groups: in_groups[k] };
            let mut at = top;
            debug_assert!(top < STACK);
            // SAFETY: at most eight entries a level in place of one, MAX_DEPTH levels (`Bvh::validate`); entries below
            // `top` have been written. Nearest on top.
            unsafe {
                while !V::ANY_HIT
                    && at > bottom
                    && stack.get_unchecked(at - 1).assume_init_ref().distance < new.distance
                {
                    let moved = *stack.get_unchecked(at - 1);
                    *stack.get_unchecked_mut(at) = moved;
                    at -= 1;
                }
                stack.get_unchecked_mut(at).write(new);
            }
            top += 1;
        });
    }
    visitor.finish(wide, room, &all.without(&alive), found);
    true
}

/// Visits the leaves of a subtree that one of the rays may meet, nearer ones first. Whether the visitor ended it.
#[inline(always)]
fn walk<E: Wide, V: PacketVisitor>(
    e: E,
    tree: &Bvh,
    room: &mut Room<V::Rows>,
    visitor: &mut V,
    ray: usize,
    from: Child,
) -> bool {
    let slabs = &room.slabs;
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
        let limit = room.slabs.limit.0[ray & (PACKET - 1)];
        if f32::from_bits((key >> 32) as u32) > limit {
            continue;
        }
        let child = Child(key as u32);
        if child.is_leaf() {
            let (first, count) = child.blocks();
            for block in first..first + count {
                if visitor.visit_one(e, room, block, ray) {
                    return true;
                }
            }
            continue;
        }
        // SAFETY: inner children are made by `collapse` from indices of nodes it has pushed (`Bvh::validate`).
        let node = unsafe { tree.nodes.get_unchecked(child.0 as usize) };
        let (mut enter, mut exit) = (t_min, e.splat(limit));
        for axis in 0..3 {
            let row = room.slabs.rows[axis];
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
            // SAFETY: at most eight entries a level in place of one, MAX_DEPTH levels (`Bvh::validate`); entries below
            // `top` have been written.
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
