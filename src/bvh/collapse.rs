//! Binary tree to eight children a node: the cheapest cut of every subtree into up to eight, by dynamic programming
//! (Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, section
//! 3.2). On blobs100k it beat greedy collapsing of the largest child by 7 to 14 % of trace time (kernels.md, lesson 2).

use super::build::{At, Binary, Choices};
use super::{Child, EMPTY_SLOT, MAX_BLOCKS, MAX_LEAF_BLOCKS, Node};
use crate::geometry::Aabb;
use crate::workers;
use std::num::NonZeroUsize;

/// Cost of testing a node over that of testing a block. Flat between 0.7 and 1.5 (kernels.md).
const NODE_COST: f32 = 1.0;

/// Leaves of more blocks than this are not made by choice.
const WANTED_LEAF_BLOCKS: u32 = 2;

/// What is known of a binary subtree: the cheapest way to stand as up to k + 1 children of a wide node, for k = 0..7.
///
/// Which way that is goes into [`Choices`]. The first says what it is as one child: 0 for a leaf, or else a wide node,
/// so many of whose eight places the left half gets. The others say what becomes of it if it gets k + 1 places: it is
/// dissolved and the left half gets so many of them, or for 0 it is as with one place less.
#[derive(Clone)]
pub(super) struct Plan {
    cost: [f32; 7],
}

impl Plan {
    /// A leaf of one block.
    pub fn leaf(bounds: &Aabb) -> Self {
        Self { cost: [bounds.half_area(); 7] }
    }

    /// Two halves, which as one leaf would be so many blocks.
    pub fn inner(bounds: &Aabb, blocks: u32, [left, right]: [&Self; 2]) -> (Self, Choices) {
        let area = bounds.half_area();
        // The best division of 2..=8 places.
        // Costs that are not finite (boxes of the size of f32's range) leave the default, one place for the left half.
        let mut divided = [(f32::INFINITY, 1u8); 9];
        for (places, best) in divided.iter_mut().enumerate().skip(2) {
            // Neither half may have more than seven places.
            for l in places.saturating_sub(7).max(1)..=(places - 1).min(7) {
                let cost = left.cost[l - 1] + right.cost[places - l - 1];
                if cost < best.0 {
                    *best = (cost, l as u8);
                }
            }
        }
        let (inside, left_places) = divided[8];
        let (mut cost, mut choices) = ([area * NODE_COST + inside; 7], [left_places, 0, 0, 0, 0, 0, 0]);
        if blocks <= WANTED_LEAF_BLOCKS && area * blocks as f32 <= cost[0] {
            (cost[0], choices[0]) = (area * blocks as f32, 0);
        }
        for k in 1..7 {
            let (dissolved, left_places) = divided[k + 1];
            cost[k] = cost[k - 1];
            if dissolved < cost[k] {
                (cost[k], choices[k]) = (dissolved, left_places);
            }
        }
        (Self { cost }, choices)
    }

    /// Expected cost of a random ray that meets the box.
    pub fn relative_cost(&self, bounds: &Aabb) -> f32 {
        let area = bounds.half_area();
        if area > 0.0 { self.cost[0] / area } else { 0.0 }
    }
}

pub(super) struct Collapsed {
    pub nodes: Vec<Node>,
    pub slots: Vec<u32>,
}

/// The wide tree. Nodes of the top come first, then those below it, depth first.
pub(super) fn collapse(binary: &Binary, block_size: usize, threads: NonZeroUsize) -> Collapsed {
    let layout = Layout { binary, block_size };
    let (mut top, mut below) = (Laid { nodes: vec![EMPTY_NODE], slots: Vec::new() }, Vec::new());
    // A root that is a leaf gets a node of its own.
    let root = binary.node(binary.root);
    let children = if root.plan[0] == 0 { Children::one(binary.root) } else { layout.children(binary.root) };
    layout.fill_top(&mut top, 0, children, &mut below);
    let jobs = below.iter().map(|&(_, at)| at).collect();
    let parts = workers::map(threads, jobs, |at: At| {
        let mut part = Laid::default();
        let child = layout.lay(&mut part, at);
        (part, child)
    });
    let Laid { mut nodes, mut slots } = top;
    nodes.reserve_exact(parts.iter().map(|(part, _)| part.nodes.len()).sum());
    slots.reserve_exact(parts.iter().map(|(part, _)| part.slots.len()).sum());
    for (((to, k), _), (part, child)) in below.into_iter().zip(parts) {
        let (first_node, first_block) = (nodes.len(), slots.len() / block_size);
        assert!(first_block + part.slots.len() / block_size <= MAX_BLOCKS, "more than 2^27 blocks of primitives");
        nodes[to].children[k] = child.moved(first_node, first_block);
        nodes.extend(part.nodes.into_iter().map(|mut node| {
            node.children = node.children.map(|child| child.moved(first_node, first_block));
            node
        }));
        slots.extend(part.slots);
    }
    Collapsed { nodes, slots }
}

/// Up to eight binary nodes that become the children of a wide node.
#[derive(Default)]
struct Children {
    at: [At; 8],
    count: usize,
}

impl Children {
    fn one(at: At) -> Self {
        let mut one = Self::default();
        one.push(at);
        one
    }

    fn push(&mut self, at: At) {
        self.at[self.count] = at;
        self.count += 1;
    }
}

/// A part of the wide tree; its links count from its own beginning.
#[derive(Default)]
struct Laid {
    nodes: Vec<Node>,
    slots: Vec<u32>,
}

struct Layout<'a> {
    binary: &'a Binary,
    block_size: usize,
}

impl Layout<'_> {
    /// The children of a binary node that becomes a wide one.
    fn children(&self, at: At) -> Children {
        let mut children = Children::default();
        self.gather_halves(at, self.binary.node(at).plan[0], 8, &mut children);
        children
    }

    /// The binary nodes that become children when `at` gets `places` places.
    fn gather(&self, at: At, places: u8, children: &mut Children) {
        match (places, self.binary.node(at).plan[places as usize - 1]) {
            (1, _) => children.push(at),
            (_, 0) => self.gather(at, places - 1, children),
            (_, left) => self.gather_halves(at, left, places, children),
        }
    }

    fn gather_halves(&self, at: At, left: u8, places: u8, children: &mut Children) {
        let [left_half, right_half] = self.binary.node(at).children;
        self.gather(left_half, left, children);
        self.gather(right_half, places - left, children);
    }

    /// Writes the children of wide node `to` as far as they are of the top, and says which are not.
    fn fill_top(&self, top: &mut Laid, to: usize, children: Children, below: &mut Vec<((usize, usize), At)>) {
        for (k, &at) in children.at[..children.count].iter().enumerate() {
            set_bounds(&mut top.nodes[to], k, &self.binary.node(at).bounds);
            if at.arena as usize + 1 < self.binary.arenas.len() {
                below.push(((to, k), at));
                continue;
            }
            let node = top.nodes.len();
            top.nodes.push(EMPTY_NODE);
            top.nodes[to].children[k] = Child::inner(node);
            self.fill_top(top, node, self.children(at), below);
        }
    }

    /// Appends the wide tree of a binary node, depth first.
    fn lay(&self, part: &mut Laid, at: At) -> Child {
        if self.binary.node(at).plan[0] == 0 {
            return self.leaf(part, at);
        }
        let to = part.nodes.len();
        part.nodes.push(EMPTY_NODE);
        let children = self.children(at);
        for (k, &at) in children.at[..children.count].iter().enumerate() {
            set_bounds(&mut part.nodes[to], k, &self.binary.node(at).bounds);
            part.nodes[to].children[k] = self.lay(part, at);
        }
        Child::inner(to)
    }

    fn leaf(&self, part: &mut Laid, at: At) -> Child {
        let node = self.binary.node(at);
        let first = part.slots.len() / self.block_size;
        let range = node.first as usize..(node.first + node.count) as usize;
        let blocks = range.len().div_ceil(self.block_size);
        assert!(blocks <= MAX_LEAF_BLOCKS, "a leaf of {blocks} blocks");
        part.slots.extend_from_slice(&self.binary.order[range]);
        part.slots.resize((first + blocks) * self.block_size, EMPTY_SLOT);
        Child::leaf(first, blocks)
    }
}

const LOWER: [f32; 8] = [f32::INFINITY; 8];
const UPPER: [f32; 8] = [f32::NEG_INFINITY; 8];

const EMPTY_NODE: Node = Node { planes: [LOWER, UPPER, LOWER, UPPER, LOWER, UPPER], children: [Child::ABSENT; 8] };

fn set_bounds(node: &mut Node, k: usize, bounds: &Aabb) {
    for axis in 0..3 {
        node.planes[2 * axis][k] = bounds.lower[axis];
        node.planes[2 * axis + 1][k] = bounds.upper[axis];
    }
}
