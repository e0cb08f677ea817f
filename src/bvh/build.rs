//! The binary tree, top down: large ranges by all threads together, then every range that is left by one thread.

use super::bins::{LaneBox, PrimRef, aabb};
use super::collapse::{self, Plan};
use super::simd::filled;
use super::split::Splitter;
use super::{Bvh, Isa, MAX_DEPTH};
use crate::geometry::Aabb;
use crate::workers;
use std::num::NonZeroUsize;

/// Ranges of at most so many primitives are cut further by one thread, alone.
const ALONE: usize = 1 << 15;

/// The binary tree in pieces: the top, and what single threads have made below it.
pub(super) struct Binary {
    /// The top is the last one; there is none where one thread did all.
    pub arenas: Vec<Vec<BinaryNode>>,
    pub root: At,
    /// Indices of all primitives, in the order of the leaves.
    pub order: Vec<u32>,
}

/// Where a node is.
#[derive(Clone, Copy, Default, Debug, PartialEq)]
pub(super) struct At {
    pub arena: u32,
    pub node: u32,
}

/// A node with its way into the wide tree.
#[derive(Clone, Copy)]
pub(super) struct BinaryNode {
    pub bounds: Aabb,
    /// First of its primitives in the order of all.
    pub first: u32,
    /// How many there are.
    pub count: u32,
    /// The two halves; not used by leaves.
    pub children: [At; 2],
    pub plan: Choices,
}

/// What [`Plan`] has chosen; see there.
pub(super) type Choices = [u8; 7];

impl Binary {
    pub fn node(&self, at: At) -> &BinaryNode {
        &self.arenas[at.arena as usize][at.node as usize]
    }
}

/// A range of primitives with room to move them, and where their order is to be written.
struct Range<'a> {
    refs: &'a mut [PrimRef],
    scratch: &'a mut [PrimRef],
    order: &'a mut [u32],
    /// Position of the first in the order of all.
    first: usize,
    bounds: LaneBox,
    depth: usize,
}

impl<'a> Range<'a> {
    /// The parts before and from `middle` on.
    fn cut(self, middle: usize, [left, right]: [LaneBox; 2]) -> [Range<'a>; 2] {
        let Self { refs, scratch, order, first, depth, .. } = self;
        let (refs, scratch, order) =
            (refs.split_at_mut(middle), scratch.split_at_mut(middle), order.split_at_mut(middle));
        let depth = depth + 1;
        [
            Range { refs: refs.0, scratch: scratch.0, order: order.0, first, bounds: left, depth },
            Range { refs: refs.1, scratch: scratch.1, order: order.1, first: first + middle, bounds: right, depth },
        ]
    }

    fn node(&self) -> BinaryNode {
        BinaryNode {
            bounds: aabb(&self.bounds),
            first: self.first as u32,
            count: self.refs.len() as u32,
            children: [At::default(); 2],
            plan: Choices::default(),
        }
    }

    /// Deep down, what is left is halved, which ends soon: the depth stays below `MAX_DEPTH`.
    fn may_cut(&self) -> bool {
        self.depth < MAX_DEPTH / 2
    }
}

impl Bvh {
    /// Builds a tree over so many primitives, whose leaves hold blocks of `block_size` slots (1 or 8), and tells what
    /// is in the slots: indices of primitives, or [`EMPTY_SLOT`](super::EMPTY_SLOT). The tree is a function of the
    /// boxes alone, for any number of `threads` and any instruction set.
    ///
    /// # Panics
    /// If the processor does not have `isa`.
    pub fn build(
        count: usize,
        bounds: impl Fn(usize) -> Aabb + Sync,
        block_size: usize,
        isa: Isa,
        threads: NonZeroUsize,
    ) -> (Self, Vec<u32>) {
        assert!(isa.is_available(), "this processor has no {}", isa.name());
        assert!(block_size.is_power_of_two() && count < 1 << 31);
        let mut tree = Self {
            nodes: vec![],
            block_size,
            primitives: count,
            blocks: 0,
            bounds: Aabb::EMPTY,
            extent: 0.0,
            sah_cost: 0.0,
            isa,
        };
        if count == 0 {
            return (tree, vec![]);
        }
        let splitter = Splitter { block_shift: block_size.trailing_zeros(), isa };
        let (binary, sah_cost) =
            Builder { splitter, threads }.build(filled(count, threads, |i| PrimRef::new(bounds(i), i as u32)));
        let collapsed = collapse::collapse(&binary, block_size, threads);
        tree.bounds = binary.node(binary.root).bounds;
        tree.extent = tree.bounds.max_abs();
        tree.blocks = collapsed.slots.len() / block_size;
        tree.nodes = collapsed.nodes;
        tree.sah_cost = sah_cost;
        (tree, collapsed.slots)
    }
}

#[derive(Clone, Copy)]
struct Builder {
    splitter: Splitter,
    threads: NonZeroUsize,
}

/// A node of the top, before what is below it is known.
enum Top {
    /// Another node of the top.
    Node { node: BinaryNode, halves: [Box<Top>; 2] },
    /// The arena with this number.
    Arena(usize),
}

impl Builder {
    /// The binary tree, and its expected cost.
    fn build(self, mut refs: Vec<PrimRef>) -> (Binary, f32) {
        let empty_or_all = |refs: &[PrimRef]| self.splitter.bounds(refs);
        let boxes = workers::map(self.threads, refs.chunks(ALONE).collect(), empty_or_all);
        let bounds = self.splitter.joined(&boxes);
        let mut order = vec![0; refs.len()];
        let mut scratch = filled(refs.len(), self.threads, |_| PrimRef(bounds));
        let all = Range { refs: &mut refs, scratch: &mut scratch, order: &mut order, first: 0, bounds, depth: 1 };
        let mut ranges = Vec::new();
        let top = self.top(all, &mut ranges);
        // The largest first, so that no thread is left with one while the others have done theirs.
        let mut jobs: Vec<_> = ranges.into_iter().enumerate().collect();
        jobs.sort_by_key(|(_, range)| std::cmp::Reverse(range.refs.len()));
        let mut done = workers::map(self.threads, jobs, |(number, range)| {
            let mut nodes = Vec::with_capacity((2 * range.refs.len()) >> self.splitter.block_shift.max(1));
            let plan = self.alone(&mut nodes, range, number as u32);
            (number, nodes, plan)
        });
        done.sort_by_key(|(number, ..)| *number);
        let (mut arenas, mut plans) = (Vec::new(), Vec::new());
        for (_, nodes, plan) in done {
            arenas.push(nodes);
            plans.push(plan);
        }
        let mut above = Vec::new();
        let (root, plan) = join(top, &plans, &mut above);
        arenas.push(above);
        let binary = Binary { arenas, root, order };
        let cost = plan.relative_cost(&binary.node(root).bounds);
        (binary, cost)
    }

    /// Cuts large ranges and collects those that are left, in order.
    fn top<'a>(self, range: Range<'a>, ranges: &mut Vec<Range<'a>>) -> Top {
        if range.refs.len() <= ALONE || !range.may_cut() {
            ranges.push(range);
            return Top::Arena(ranges.len() - 1);
        }
        let node = range.node();
        let (middle, sides, moved) = self.splitter.split_together(range.refs, range.scratch, self.threads);
        let range = match moved {
            true => Range { refs: range.scratch, scratch: range.refs, ..range },
            false => range,
        };
        let halves = range.cut(middle, sides).map(|half| Box::new(self.top(half, ranges)));
        Top::Node { node, halves }
    }

    /// Appends the tree of a range to `nodes` and makes its plan.
    fn alone(self, nodes: &mut Vec<BinaryNode>, range: Range, arena: u32) -> Plan {
        let at = nodes.len();
        nodes.push(range.node());
        let (node, splitter) = (nodes[at], self.splitter);
        if range.refs.len() <= 1 << splitter.block_shift {
            for (place, p) in range.order.iter_mut().zip(range.refs.iter()) {
                *place = p.index();
            }
            return Plan::leaf(&node.bounds);
        }
        let (middle, sides) = splitter.split(range.refs, range.scratch, range.may_cut());
        let [left, right] = range.cut(middle, sides);
        let mut children = [At::default(); 2];
        let plans = [left, right].map(|half| (nodes.len(), self.alone(nodes, half, arena)));
        for (child, (node, _)) in children.iter_mut().zip(&plans) {
            *child = At { arena, node: *node as u32 };
        }
        let (plan, choices) = Plan::inner(&node.bounds, splitter.blocks(node.count), [&plans[0].1, &plans[1].1]);
        nodes[at] = BinaryNode { children, plan: choices, ..node };
        plan
    }
}

/// Plans the top, whose nodes come to stand behind their halves.
fn join(top: Top, plans: &[Plan], nodes: &mut Vec<BinaryNode>) -> (At, Plan) {
    match top {
        Top::Arena(arena) => (At { arena: arena as u32, node: 0 }, plans[arena].clone()),
        Top::Node { node, halves } => {
            let [(left, left_plan), (right, right_plan)] = halves.map(|half| join(*half, plans, nodes));
            // Far too many for a leaf.
            let (plan, choices) = Plan::inner(&node.bounds, u32::MAX, [&left_plan, &right_plan]);
            nodes.push(BinaryNode { children: [left, right], plan: choices, ..node });
            (At { arena: plans.len() as u32, node: nodes.len() as u32 - 1 }, plan)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SplitMix64;
    use glam::Vec3;

    fn boxes(n: usize, seed: u64, place: impl Fn(&mut SplitMix64) -> Vec3, size: f32) -> Vec<Aabb> {
        let mut rng = SplitMix64(seed);
        let around = |p: Vec3| Aabb { lower: p - Vec3::splat(size), upper: p + Vec3::splat(size) };
        (0..n).map(|_| around(place(&mut rng))).collect()
    }

    fn random(r: &mut SplitMix64) -> Vec3 {
        Vec3::new(r.unit() as f32, r.unit() as f32, r.unit() as f32)
    }

    fn build(list: &[Aabb], block_size: usize, threads: usize) -> (Bvh, Vec<u32>) {
        let threads = NonZeroUsize::new(threads).expect("not zero");
        Bvh::build(list.len(), |i| list[i], block_size, Isa::best(), threads)
    }

    /// Boxes that are easy and boxes that are not.
    fn kinds(n: usize) -> [(&'static str, Vec<Aabb>); 7] {
        let line = |r: &mut SplitMix64| Vec3::new(r.unit() as f32, 0.0, 0.0);
        let exponential = |r: &mut SplitMix64| Vec3::splat(2f32.powf(r.range(-60.0, 60.0) as f32));
        let two = |r: &mut SplitMix64| if r.unit() < 0.001 { Vec3::splat(1e30) } else { random(r) * 1e-30 };
        [
            ("random", boxes(n, 1, random, 0.01)),
            ("coincident", boxes(n, 2, |_| Vec3::ONE, 0.5)),
            ("line", boxes(n, 3, line, 0.0)),
            ("exponential", boxes(n, 4, exponential, 0.0)),
            ("huge", boxes(n, 5, |r| random(r) * 3e38 - Vec3::splat(1.5e38), 1e30)),
            ("tiny", boxes(n, 6, |r| random(r) * 1e-42, 1e-44)),
            ("two places", boxes(n, 7, two, 0.0)),
        ]
    }

    #[test]
    fn trees_over_random_coincident_huge_and_tiny_boxes_are_valid_and_the_same_for_all_threads_and_instruction_sets() {
        // The last is cut by all threads together first.
        for n in [0, 1, 2, 3, 7, 8, 9, 100, 5000, ALONE + 7] {
            for (what, list) in kinds(n) {
                for block_size in [1, 8] {
                    let (tree, slots) = build(&list, block_size, 1);
                    assert_eq!(tree.validate(&list, &slots), Ok(()), "{what} {n} in blocks of {block_size}");
                    let others = [(2, Isa::best()), (7, Isa::best()), (1, Isa::Portable)].map(|(threads, isa)| {
                        let threads = NonZeroUsize::new(threads).expect("not zero");
                        Bvh::build(n, |i| list[i], block_size, isa, threads)
                    });
                    for (other, other_slots) in &others {
                        assert!(same(&tree, other) && &slots == other_slots, "{what} {n} in blocks of {block_size}");
                    }
                }
            }
        }
    }

    fn same(a: &Bvh, b: &Bvh) -> bool {
        let pairs = || a.nodes.iter().zip(&b.nodes);
        let planes = |node: &crate::bvh::Node| node.planes.map(|row| row.map(f32::to_bits));
        // As text, since costs of huge boxes are not numbers.
        format!("{:?}", a.stats()) == format!("{:?}", b.stats())
            && pairs().all(|(a, b)| planes(a) == planes(b) && a.children == b.children)
    }

    #[test]
    fn validate_notices_a_box_that_sticks_out() {
        let mut list = boxes(100, 7, random, 0.1);
        let (tree, slots) = build(&list, 8, 1);
        list[50].upper += Vec3::splat(1.0);
        assert!(tree.validate(&list, &slots).is_err());
    }
}
