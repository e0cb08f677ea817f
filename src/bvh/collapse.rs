//! Binary tree to eight children a node: the cheapest cut of every subtree into up to eight, by dynamic programming
//! (Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, section 3.2).
//! On blobs100k it beat greedy collapsing of the largest child by 7 to 14 % of trace time (kernels.md, lesson 2).

use super::build::{BinaryNode, PrimRef};
use super::{Child, EMPTY_SLOT, MAX_BLOCKS, MAX_LEAF_BLOCKS, Node};
use crate::geometry::Aabb;

/// Cost of testing a node over that of testing a block. Flat between 0.7 and 1.5 (kernels.md).
const NODE_COST: f32 = 1.0;

/// Leaves of more blocks than this are not made by choice.
const WANTED_LEAF_BLOCKS: usize = 2;

pub(super) struct Collapsed {
    pub nodes: Vec<Node>,
    pub slots: Vec<u32>,
    pub sah_cost: f32,
}

/// What is known of a binary subtree: the cheapest way to stand as up to k + 1 children of a wide node, for k = 0..7, and
/// which choice that is.
#[derive(Clone, Copy)]
struct Plan {
    cost: [f32; 7],
    choice: [Choice; 7],
    primitives: u32,
    /// First primitive; those of a subtree stand together.
    first: u32,
}

#[derive(Clone, Copy, PartialEq)]
enum Choice {
    /// One leaf.
    Leaf,
    /// One wide node, whose children take `left` of eight places for the left half.
    Node { left: u8 },
    /// Dissolved: `left` places for the left half, the rest for the right one.
    Split { left: u8 },
    /// As with one place less.
    Fewer,
}

pub(super) fn collapse(binary: &[BinaryNode], refs: &[PrimRef], block_size: usize) -> Collapsed {
    let plans = plan(binary, block_size);
    let mut layout = Layout { binary, plans: &plans, refs, block_size, nodes: Vec::new(), slots: Vec::new() };
    let root_area = binary[0].bounds.half_area();
    let sah_cost = if root_area > 0.0 { plans[0].cost[0] / root_area } else { 0.0 };
    layout.nodes.reserve(binary.len() / 6 + 1);
    layout.root();
    Collapsed { nodes: layout.nodes, slots: layout.slots, sah_cost }
}

/// Children stand behind their parents, so one pass from the back suffices.
fn plan(binary: &[BinaryNode], block_size: usize) -> Vec<Plan> {
    let unset = Plan { cost: [f32::INFINITY; 7], choice: [Choice::Fewer; 7], primitives: 0, first: 0 };
    let mut plans = vec![unset; binary.len()];
    for (at, node) in binary.iter().enumerate().rev() {
        let area = node.bounds.half_area();
        if node.count > 0 {
            let blocks = (node.count as usize).div_ceil(block_size);
            let plan = &mut plans[at];
            plan.cost = [area * blocks as f32; 7];
            plan.choice[0] = Choice::Leaf;
            (plan.primitives, plan.first) = (node.count, node.link);
            continue;
        }
        let (left, right) = (plans[node.link as usize], plans[node.right as usize]);
        let mut plan =
            Plan { primitives: left.primitives + right.primitives, first: left.first.min(right.first), ..unset };
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
        plan.cost[0] = area * NODE_COST + inside;
        plan.choice[0] = Choice::Node { left: left_places };
        let blocks = (plan.primitives as usize).div_ceil(block_size);
        if blocks <= WANTED_LEAF_BLOCKS && area * blocks as f32 <= plan.cost[0] {
            plan.cost[0] = area * blocks as f32;
            plan.choice[0] = Choice::Leaf;
        }
        for (places, &(cost, left_places)) in divided.iter().enumerate().take(8).skip(2) {
            if cost < plan.cost[places - 2] {
                plan.cost[places - 1] = cost;
                plan.choice[places - 1] = Choice::Split { left: left_places };
            } else {
                plan.cost[places - 1] = plan.cost[places - 2];
            }
        }
        plans[at] = plan;
    }
    plans
}

struct Layout<'a> {
    binary: &'a [BinaryNode],
    plans: &'a [Plan],
    refs: &'a [PrimRef],
    block_size: usize,
    nodes: Vec<Node>,
    slots: Vec<u32>,
}

impl Layout<'_> {
    /// Lays out the whole tree; a root that is a leaf gets a node of its own.
    fn root(&mut self) {
        self.nodes.push(EMPTY_NODE);
        let mut children = Vec::with_capacity(8);
        match self.plans[0].choice[0] {
            Choice::Node { left } => self.gather_halves(0, left, 8, &mut children),
            _ => children.push(0),
        }
        self.fill(0, &children);
    }

    /// The binary nodes that become children when `at` gets `places` places.
    fn gather(&self, at: usize, places: u8, children: &mut Vec<usize>) {
        match self.plans[at].choice[places as usize - 1] {
            Choice::Leaf | Choice::Node { .. } => children.push(at),
            Choice::Split { left } => self.gather_halves(at, left, places, children),
            Choice::Fewer => {
                if places > 1 {
                    self.gather(at, places - 1, children);
                }
            }
        }
    }

    fn gather_halves(&self, at: usize, left: u8, places: u8, children: &mut Vec<usize>) {
        self.gather(self.binary[at].link as usize, left, children);
        self.gather(self.binary[at].right as usize, places - left, children);
    }

    /// Writes the children of wide node `to`, depth first.
    fn fill(&mut self, to: usize, children: &[usize]) {
        for (k, &at) in children.iter().enumerate() {
            let bounds = self.binary[at].bounds;
            set_bounds(&mut self.nodes[to], k, &bounds);
            let child = match self.plans[at].choice[0] {
                Choice::Node { left } => {
                    let node = self.nodes.len();
                    self.nodes.push(EMPTY_NODE);
                    let mut grandchildren = Vec::with_capacity(8);
                    self.gather_halves(at, left, 8, &mut grandchildren);
                    self.fill(node, &grandchildren);
                    Child::inner(node)
                }
                _ => self.leaf(at),
            };
            self.nodes[to].children[k] = child;
        }
    }

    fn leaf(&mut self, at: usize) -> Child {
        let plan = &self.plans[at];
        let first = self.slots.len() / self.block_size;
        let range = plan.first as usize..(plan.first + plan.primitives) as usize;
        let blocks = range.len().div_ceil(self.block_size);
        assert!(blocks <= MAX_LEAF_BLOCKS && first + blocks <= MAX_BLOCKS, "more than 2^27 blocks of primitives");
        self.slots.extend(self.refs[range].iter().map(PrimRef::index));
        self.slots.resize((first + blocks) * self.block_size, EMPTY_SLOT);
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
