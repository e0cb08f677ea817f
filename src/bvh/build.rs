//! The binary tree: binned surface-area heuristic, top down (Wald, "On fast Construction of SAH-based Bounding Volume
//! Hierarchies", 2007), with leaves priced in blocks.

use super::{Bvh, Isa, MAX_DEPTH, collapse};
use crate::geometry::Aabb;
use glam::{Vec3, Vec4};
use std::num::NonZeroUsize;
use std::sync::{Mutex, PoisonError};

const BINS: usize = 16;

/// Ranges of at least this many primitives are worth a thread of their own.
const PARALLEL: usize = 1 << 14;

/// A primitive's box, moved as a whole so that every pass over a range reads memory in order. The index hides in the
/// fourth lane of `lower`.
#[derive(Clone, Copy)]
pub(super) struct PrimRef {
    lower: Vec4,
    upper: Vec4,
}

impl PrimRef {
    fn new(bounds: &Aabb, index: u32) -> Self {
        Self { lower: bounds.lower.extend(f32::from_bits(index)), upper: bounds.upper.extend(0.0) }
    }

    pub fn index(&self) -> u32 {
        self.lower.w.to_bits()
    }

    /// Twice the centre.
    fn centre(&self) -> Vec4 {
        self.lower + self.upper
    }
}

/// Node of the binary tree: children at `link` (left) and `right`, or `count` primitives from `link` on.
#[derive(Clone, Copy)]
pub(super) struct BinaryNode {
    pub bounds: Aabb,
    pub link: u32,
    pub right: u32,
    /// 0 for an inner node.
    pub count: u32,
}

impl Bvh {
    /// Builds a tree over primitives with these boxes, whose leaves hold blocks of `block_size` slots (1 or 8), and tells what is in
    /// the slots: indices of primitives, or [`EMPTY_SLOT`](super::EMPTY_SLOT). The tree is a function of the boxes alone,
    /// for any number of `threads`.
    ///
    /// # Panics
    /// If the processor does not have `isa`.
    pub fn build(primitives: &[Aabb], block_size: usize, isa: Isa, threads: NonZeroUsize) -> (Self, Vec<u32>) {
        assert!(isa.is_available(), "this processor has no {}", isa.name());
        let bounds = primitives.iter().fold(Aabb::EMPTY, |b, p| b.union(*p));
        let mut tree = Self {
            nodes: vec![],
            block_size,
            primitives: primitives.len(),
            blocks: 0,
            bounds,
            extent: bounds.max_abs(),
            sah_cost: 0.0,
            isa,
        };
        if primitives.is_empty() {
            return (tree, vec![]);
        }
        let mut refs: Vec<PrimRef> = primitives.iter().zip(0..).map(|(b, i)| PrimRef::new(b, i)).collect();
        let binary = Builder { block_size }.subtree(&mut refs, 0, 1, threads.get());
        let collapsed = collapse::collapse(&binary, &refs, block_size);
        tree.blocks = collapsed.slots.len() / block_size;
        tree.nodes = collapsed.nodes;
        tree.sah_cost = collapsed.sah_cost;
        (tree, collapsed.slots)
    }
}

#[derive(Clone, Copy)]
struct Bin {
    lower: Vec4,
    upper: Vec4,
    count: usize,
}

const EMPTY_BIN: Bin = Bin { lower: Vec4::INFINITY, upper: Vec4::NEG_INFINITY, count: 0 };

impl Bin {
    #[inline(always)]
    fn add(&mut self, p: &PrimRef) {
        self.lower = self.lower.min(p.lower);
        self.upper = self.upper.max(p.upper);
        self.count += 1;
    }

    fn join(&mut self, other: &Bin) {
        self.lower = self.lower.min(other.lower);
        self.upper = self.upper.max(other.upper);
        self.count += other.count;
    }

    fn bounds(&self) -> Aabb {
        Aabb { lower: self.lower.truncate(), upper: self.upper.truncate() }
    }
}

struct Builder {
    block_size: usize,
}

/// Where to cut a range.
struct Cut {
    axis: usize,
    /// First bin of the right part.
    border: usize,
    lower: Vec4,
    scale: Vec4,
}

impl Builder {
    /// The binary tree of `refs`, which start at position `first` of all; node 0 is its root. Reorders `refs`.
    fn subtree(&self, refs: &mut [PrimRef], first: usize, depth: usize, threads: usize) -> Vec<BinaryNode> {
        let mut nodes = Vec::with_capacity(2 * refs.len() / self.block_size.max(2) + 1);
        self.split(&mut nodes, refs, first, depth, threads);
        nodes
    }

    fn split(&self, nodes: &mut Vec<BinaryNode>, refs: &mut [PrimRef], first: usize, depth: usize, threads: usize) {
        let at = nodes.len();
        let (bounds, centres) = spans(refs);
        nodes.push(BinaryNode { bounds, link: first as u32, right: 0, count: refs.len() as u32 });
        if refs.len() <= self.block_size {
            return;
        }
        // Deep down, what is left is halved, which ends soon: the depth stays below `MAX_DEPTH`.
        let cut = if depth < MAX_DEPTH / 2 { self.best_cut(refs, &centres) } else { None };
        let middle = cut.map_or(refs.len() / 2, |cut| partition(refs, &cut));
        let (left, right) = refs.split_at_mut(middle);
        let link = nodes.len();
        let right_link;
        if threads > 1 && left.len().min(right.len()) >= PARALLEL {
            let half = threads / 2;
            let slot = Mutex::new(Some(left));
            let build_left = || {
                let left = slot.lock().unwrap_or_else(PoisonError::into_inner).take();
                left.map_or_else(Vec::new, |left| self.subtree(left, first, depth + 1, half))
            };
            let (l, r) = std::thread::scope(|scope| {
                let other = std::thread::Builder::new().spawn_scoped(scope, build_left);
                let r = self.subtree(right, first + middle, depth + 1, threads - half);
                // Where there is no thread to be had, this one does both halves.
                let l = other.map(|handle| handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
                (l.unwrap_or_else(|_| build_left()), r)
            });
            append(nodes, l);
            right_link = nodes.len();
            append(nodes, r);
        } else {
            self.split(nodes, left, first, depth + 1, threads);
            right_link = nodes.len();
            self.split(nodes, right, first + middle, depth + 1, threads);
        }
        nodes[at] = BinaryNode { bounds, link: link as u32, right: right_link as u32, count: 0 };
    }

    /// The cheapest cut between bins, over all axes; `None` if all centres are in one place (or not finite).
    fn best_cut(&self, refs: &[PrimRef], centres: &Bin) -> Option<Cut> {
        let size = (centres.upper - centres.lower).truncate();
        if !size.is_finite() || size.max_element() <= 0.0 {
            return None;
        }
        // An axis without extent gets all its primitives into bin 0.
        let scale =
            Vec3::select(size.cmpgt(Vec3::ZERO), Vec3::splat(BINS as f32 * 0.99999) / size, Vec3::ZERO).extend(0.0);
        let mut cut = Cut { axis: 0, border: 0, lower: centres.lower, scale };
        let mut bins = [[EMPTY_BIN; BINS]; 3];
        for p in refs {
            let [x, y, z] = cut.bins(p);
            bins[0][x].add(p);
            bins[1][y].add(p);
            bins[2][z].add(p);
        }
        let mut best = f32::INFINITY;
        for axis in (0..3).filter(|&axis| size[axis] > 0.0) {
            let mut right_costs = [0.0; BINS];
            let mut right = EMPTY_BIN;
            for k in (1..BINS).rev() {
                right.join(&bins[axis][k]);
                right_costs[k] = self.cost(&right);
            }
            let mut left = EMPTY_BIN;
            for border in 1..BINS {
                left.join(&bins[axis][border - 1]);
                let cost = self.cost(&left) + right_costs[border];
                if left.count > 0 && left.count < refs.len() && cost < best {
                    best = cost;
                    (cut.axis, cut.border) = (axis, border);
                }
            }
        }
        (cut.border > 0).then_some(cut)
    }

    /// Half the area times the number of blocks that this many primitives fill.
    fn cost(&self, bin: &Bin) -> f32 {
        if bin.count == 0 { 0.0 } else { bin.bounds().half_area() * bin.count.div_ceil(self.block_size) as f32 }
    }
}

impl Cut {
    #[inline(always)]
    fn bins(&self, p: &PrimRef) -> [usize; 3] {
        let place = (p.centre() - self.lower) * self.scale;
        [place.x, place.y, place.z].map(|v| (v as usize).min(BINS - 1))
    }
}

/// Box of the primitives, and the span of their doubled centres.
fn spans(refs: &[PrimRef]) -> (Aabb, Bin) {
    let (mut bounds, mut centres) = (EMPTY_BIN, EMPTY_BIN);
    for p in refs {
        bounds.add(p);
        let c = p.centre();
        centres.lower = centres.lower.min(c);
        centres.upper = centres.upper.max(c);
    }
    (bounds.bounds(), centres)
}

/// Moves the primitives left of the cut to the front and returns how many there are.
fn partition(refs: &mut [PrimRef], cut: &Cut) -> usize {
    let is_left = |p: &PrimRef| cut.bins(p)[cut.axis] < cut.border;
    let (mut left, mut right) = (0, refs.len());
    loop {
        while left < right && is_left(&refs[left]) {
            left += 1;
        }
        while left < right && !is_left(&refs[right - 1]) {
            right -= 1;
        }
        if left >= right {
            return left;
        }
        refs.swap(left, right - 1);
    }
}

/// Adds a subtree whose links count from its own root.
fn append(nodes: &mut Vec<BinaryNode>, subtree: Vec<BinaryNode>) {
    let start = nodes.len() as u32;
    nodes.extend(subtree.into_iter().map(|node| match node.count {
        0 => BinaryNode { link: node.link + start, right: node.right + start, ..node },
        _ => node,
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SplitMix64;

    fn boxes(n: usize, seed: u64, place: impl Fn(&mut SplitMix64) -> Vec3, size: f32) -> Vec<Aabb> {
        let mut rng = SplitMix64(seed);
        let around = |p: Vec3| Aabb { lower: p - Vec3::splat(size), upper: p + Vec3::splat(size) };
        (0..n).map(|_| around(place(&mut rng))).collect()
    }

    fn random(r: &mut SplitMix64) -> Vec3 {
        Vec3::new(r.unit() as f32, r.unit() as f32, r.unit() as f32)
    }

    fn threads(n: usize) -> NonZeroUsize {
        NonZeroUsize::new(n).expect("not zero")
    }

    #[test]
    fn trees_over_random_coincident_huge_and_tiny_boxes_are_valid() {
        for n in [0, 1, 2, 3, 7, 8, 9, 100, 5000] {
            for (what, list) in [
                ("random", boxes(n, 1, random, 0.01)),
                ("coincident", boxes(n, 2, |_| Vec3::ONE, 0.5)),
                ("line", boxes(n, 3, |r| Vec3::new(r.unit() as f32, 0.0, 0.0), 0.0)),
                ("exponential", boxes(n, 4, |r| Vec3::splat(2f32.powf(r.range(-60.0, 60.0) as f32)), 0.0)),
                ("huge", boxes(n, 5, |r| random(r) * 3e38 - Vec3::splat(1.5e38), 1e30)),
            ] {
                for block_size in [1, 8] {
                    let (tree, slots) = Bvh::build(&list, block_size, Isa::best(), threads(2));
                    assert_eq!(tree.validate(&list, &slots), Ok(()), "{what} {n} in blocks of {block_size}");
                }
            }
        }
    }

    #[test]
    fn any_number_of_threads_builds_the_same_tree() {
        let list = boxes(100_000, 6, random, 0.001);
        let (one, slots) = Bvh::build(&list, 8, Isa::best(), threads(1));
        for n in [2, 3, 7] {
            let (many, many_slots) = Bvh::build(&list, 8, Isa::best(), threads(n));
            assert_eq!((one.stats(), &slots), (many.stats(), &many_slots), "{n} threads");
            assert!(one.nodes.iter().zip(&many.nodes).all(|(a, b)| a.planes == b.planes && a.children == b.children));
        }
    }

    #[test]
    fn validate_notices_a_box_that_sticks_out() {
        let mut list = boxes(100, 7, random, 0.1);
        let (tree, slots) = Bvh::build(&list, 8, Isa::best(), threads(1));
        list[50].upper += Vec3::splat(1.0);
        assert!(tree.validate(&list, &slots).is_err());
    }
}
