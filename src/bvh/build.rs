//! Binned surface-area heuristic, top down (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007).

use super::traverse::MAX_DEPTH;
use super::{Bvh, Node};
use crate::geometry::Aabb;
use glam::Vec3;

const BINS: usize = 16;
/// Leaves hold at most this many primitives, unless all of them have the same centre.
const MAX_LEAF: usize = 4;
/// Cost of a node over that of a primitive.
const NODE_COST: f32 = 1.0;

impl Bvh {
    /// Builds a tree over primitives with these boxes. The tree is a function of the boxes alone.
    pub fn build(primitives: &[Aabb]) -> Self {
        let mut order: Vec<u32> = (0..primitives.len() as u32).collect();
        let bounds = primitives.iter().fold(Aabb::EMPTY, |b, p| b.union(*p));
        let mut nodes = Vec::new();
        if primitives.len() > 1 {
            let centres: Vec<Vec3> = primitives.iter().map(Aabb::doubled_centre).collect();
            let mut builder = Builder { primitives, centres: &centres, nodes: Vec::with_capacity(primitives.len()) };
            builder.split(&mut order, 0, 1, true);
            nodes = builder.nodes;
        }
        Self { nodes, order, bounds }
    }
}

struct Builder<'a> {
    primitives: &'a [Aabb],
    centres: &'a [Vec3],
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: usize,
}

const EMPTY_BIN: Bin = Bin { bounds: Aabb::EMPTY, count: 0 };

impl Bin {
    fn join(self, other: Bin) -> Bin {
        Bin { bounds: self.bounds.union(other.bounds), count: self.count + other.count }
    }

    fn cost(&self) -> f32 {
        if self.count == 0 { 0.0 } else { self.bounds.half_area() * self.count as f32 }
    }
}

impl Builder<'_> {
    /// Makes a subtree of `order`, whose first element stands at position `first` of the whole. Returns link and count as a
    /// node holds them.
    fn split(&mut self, order: &mut [u32], first: usize, depth: usize, root: bool) -> (u32, u32) {
        let leaf = (first as u32, order.len() as u32);
        // Deep enough for any sensible scene; what is left at the bottom becomes one long leaf.
        let middle = if depth >= MAX_DEPTH && !root { None } else { self.partition(order, root) };
        let Some(middle) = middle else { return leaf };
        let at = self.nodes.len();
        self.nodes.push(Node { bounds: [Aabb::EMPTY; 2], link: [0; 2], count: [0; 2] });
        let (left, right) = order.split_at_mut(middle);
        let bounds = [self.bounds(left), self.bounds(right)];
        let (left_link, left_count) = self.split(left, first, depth + 1, false);
        let (right_link, right_count) = self.split(right, first + middle, depth + 1, false);
        self.nodes[at] = Node { bounds, link: [left_link, right_link], count: [left_count, right_count] };
        (at as u32, 0)
    }

    fn bounds(&self, order: &[u32]) -> Aabb {
        order.iter().fold(Aabb::EMPTY, |b, &i| b.union(self.primitives[i as usize]))
    }

    /// Reorders `order` into two parts and returns the length of the first; `None` if a leaf is cheaper.
    fn partition(&self, order: &mut [u32], must_split: bool) -> Option<usize> {
        let n = order.len();
        if n < 2 {
            return None;
        }
        let span = Aabb::of_points(order.iter().map(|&i| self.centres[i as usize]));
        let size = span.upper - span.lower;
        if size.max_element() <= 0.0 || !size.is_finite() {
            // All centres in one place (or too far apart for f32): halve by order, so that leaves stay short.
            return (must_split || n > MAX_LEAF).then_some(n / 2);
        }
        let (cost, axis, border) =
            (0..3).filter_map(|axis| self.best_border(order, &span, axis)).min_by(|a, b| a.0.total_cmp(&b.0))?;
        let area = self.bounds(order).half_area();
        let leaf_is_cheaper = cost + NODE_COST * area >= area * n as f32;
        if n <= MAX_LEAF && leaf_is_cheaper && !must_split {
            return None;
        }
        let scale = BINS as f32 / size[axis];
        let middle =
            partition_in_place(order, |&i| bin_of(self.centres[i as usize][axis], span.lower[axis], scale) < border);
        Some(if middle == 0 || middle == n { n / 2 } else { middle })
    }

    /// The best border between bins on an axis: (cost, axis, first bin of the right part).
    fn best_border(&self, order: &[u32], span: &Aabb, axis: usize) -> Option<(f32, usize, usize)> {
        let size = span.upper[axis] - span.lower[axis];
        if size <= 0.0 {
            return None;
        }
        let scale = BINS as f32 / size;
        let mut bins = [EMPTY_BIN; BINS];
        for &i in order {
            let bin = &mut bins[bin_of(self.centres[i as usize][axis], span.lower[axis], scale)];
            *bin = bin.join(Bin { bounds: self.primitives[i as usize], count: 1 });
        }
        let mut right_costs = [0.0; BINS];
        let mut right = EMPTY_BIN;
        for k in (1..BINS).rev() {
            right = right.join(bins[k]);
            right_costs[k] = right.cost();
        }
        let mut left = EMPTY_BIN;
        (1..BINS)
            .map(|k| {
                left = left.join(bins[k - 1]);
                (left.cost() + right_costs[k], axis, k)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

fn bin_of(centre: f32, lower: f32, scale: f32) -> usize {
    (((centre - lower) * scale) as usize).min(BINS - 1)
}

/// Moves the elements that satisfy `first` to the front and returns how many there are.
fn partition_in_place<T>(items: &mut [T], first: impl Fn(&T) -> bool) -> usize {
    let mut middle = 0;
    for i in 0..items.len() {
        if first(&items[i]) {
            items.swap(i, middle);
            middle += 1;
        }
    }
    middle
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SplitMix64;

    fn boxes(n: usize, seed: u64, place: impl Fn(&mut SplitMix64) -> Vec3, size: f32) -> Vec<Aabb> {
        let mut rng = SplitMix64(seed);
        (0..n)
            .map(|_| {
                let p = place(&mut rng);
                Aabb { lower: p - Vec3::splat(size), upper: p + Vec3::splat(size) }
            })
            .collect()
    }

    #[test]
    fn trees_over_random_coincident_huge_and_tiny_boxes_are_valid() {
        let random = |r: &mut SplitMix64| Vec3::new(r.unit() as f32, r.unit() as f32, r.unit() as f32);
        for n in [0, 1, 2, 3, 7, 100, 5000] {
            for (what, list) in [
                ("random", boxes(n, 1, random, 0.01)),
                ("coincident", boxes(n, 2, |_| Vec3::ONE, 0.5)),
                ("line", boxes(n, 3, |r| Vec3::new(r.unit() as f32, 0.0, 0.0), 0.0)),
                ("exponential", boxes(n, 4, |r| Vec3::splat(2f32.powf(r.range(-60.0, 60.0) as f32)), 0.0)),
                ("huge", boxes(n, 5, |r| random(r) * 3e38 - Vec3::splat(1.5e38), 1e30)),
            ] {
                let tree = Bvh::build(&list);
                assert_eq!(tree.validate(&list), Ok(()), "{what} {n}");
            }
        }
    }

    #[test]
    fn validate_notices_a_box_that_sticks_out() {
        let mut list = boxes(100, 6, |r| Vec3::splat(r.unit() as f32), 0.1);
        let tree = Bvh::build(&list);
        list[50].upper += Vec3::splat(1.0);
        assert!(tree.validate(&list).is_err());
    }
}
