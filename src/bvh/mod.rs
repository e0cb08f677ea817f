//! Hierarchies of axis-aligned boxes over anything that has one: triangles of a mesh, objects of a scene.
//!
//! A tree is built in three steps: a binary tree by the surface-area heuristic ([`build`](self)), collapsed to nodes of
//! eight children by dynamic programming, laid out depth first. Leaves hold blocks: eight triangles that are tested
//! together, or single objects.
//!
//! Traversal is written once over vectors of eight lanes and compiled for every instruction set in `simd`.

mod balls;
mod bins;
mod build;
mod collapse;
mod kernels;
mod overlap;
mod packet_rows;
mod packets;
mod plain_packets;
mod ray_packet;
mod simd;
mod split;
mod triangles;

pub use balls::{BallRows, Near};
pub use kernels::{BoxTest, Packets, TreeKernels};
pub use ray_packet::{FirstRays, RayPacket};
pub use simd::{
    Beam, Counted, Ends, ExactRays, Isa, IsaError, Lanes, LeafVisitor, PACKET, PacketVisitor, RayRows, RaySet, Rays,
    Room, Slabs, Task, Wide, each_bit,
};
pub use triangles::{BlockTest, PacketRoom, TriangleBlock, TriangleHit, Triangles};

use crate::geometry::Aabb;

/// An 8-wide hierarchy. Its leaves hold runs of blocks; what is in a block is the caller's ([`Bvh::build`] tells).
#[derive(Clone, Debug)]
pub struct Bvh {
    /// Node 0 is the root; empty without primitives.
    nodes: Vec<Node>,
    /// Slots a block.
    block_size: usize,
    /// Primitives in all leaves.
    primitives: usize,
    /// Blocks in all leaves.
    blocks: usize,
    /// Box of everything.
    bounds: Aabb,
    /// Largest coordinate of any box, in magnitude.
    extent: f64,
    /// Expected cost of a random ray in node tests (surface-area heuristic).
    sah_cost: f32,
    /// What its traversal is compiled for.
    isa: Isa,
}

/// Marks a slot of a block that holds no primitive.
pub const EMPTY_SLOT: u32 = u32::MAX;

/// Eight children with their boxes: 256 bytes, four cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Node {
    /// Lower and upper x, lower and upper y, lower and upper z of each child; an absent child has the empty box.
    planes: [[f32; 8]; 6],
    children: [Child; 8],
}

/// An inner node by its index, or a run of blocks: bit 31 tells which, then 4 bits of count.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
struct Child(u32);

const LEAF: u32 = 1 << 31;
const COUNT_SHIFT: u32 = 27;
const FIRST_MASK: u32 = (1 << COUNT_SHIFT) - 1;

/// Most blocks that a leaf can hold.
const MAX_LEAF_BLOCKS: usize = 15;

/// Most blocks that a tree can hold.
const MAX_BLOCKS: usize = 1 << COUNT_SHIFT;

impl Child {
    const ABSENT: Child = Child(LEAF);

    fn inner(node: usize) -> Self {
        Self(node as u32)
    }

    fn leaf(first: usize, blocks: usize) -> Self {
        Self(LEAF | (blocks as u32) << COUNT_SHIFT | first as u32)
    }

    /// The same child where its node or its blocks have moved by so much.
    fn moved(self, nodes: usize, blocks: usize) -> Self {
        match self {
            Self::ABSENT => self,
            _ if self.is_leaf() => Self(self.0 + blocks as u32),
            _ => Self(self.0 + nodes as u32),
        }
    }

    #[inline(always)]
    fn is_leaf(self) -> bool {
        self.0 & LEAF != 0
    }

    /// First block and number of blocks of a leaf.
    #[inline(always)]
    fn blocks(self) -> (u32, u32) {
        (self.0 & FIRST_MASK, (self.0 & !LEAF) >> COUNT_SHIFT)
    }
}

/// Numbers that describe a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BvhStats {
    /// What is in the leaves.
    pub primitives: usize,
    /// Inner nodes.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Blocks in all leaves.
    pub blocks: usize,
    /// Mean number of primitives a block, over the slots of a block.
    pub fill: f64,
    /// Longest way from the root to a leaf.
    pub depth: usize,
    /// Expected cost of a random ray in node tests (surface-area heuristic).
    pub sah_cost: f32,
    /// Bytes of nodes, and of blocks where they hold copies of the primitives ([`Triangles::stats`]).
    pub bytes: usize,
}

impl BvhStats {
    /// Bytes over primitives; 0 for an empty tree.
    pub fn bytes_per_primitive(&self) -> f64 {
        self.bytes as f64 / self.primitives.max(1) as f64
    }
}

impl Bvh {
    /// Box of everything; empty without primitives.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The largest coordinate of any box, in magnitude.
    pub fn extent(&self) -> f64 {
        self.extent
    }

    /// What its traversal is compiled for.
    pub fn isa(&self) -> Isa {
        self.isa
    }

    /// Bytes of all nodes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.nodes)
    }

    /// Children of a node with their boxes, absent ones left out.
    fn children(&self, node: usize) -> impl Iterator<Item = (Child, Aabb)> + '_ {
        let Node { planes, children } = &self.nodes[node];
        (0..8).filter(|&k| children[k] != Child::ABSENT).map(|k| {
            let [lx, ux, ly, uy, lz, uz] = [0, 1, 2, 3, 4, 5].map(|p| planes[p][k]);
            (children[k], Aabb { lower: glam::Vec3::new(lx, ly, lz), upper: glam::Vec3::new(ux, uy, uz) })
        })
    }

    /// Describes the tree.
    pub fn stats(&self) -> BvhStats {
        let mut stats = BvhStats {
            primitives: self.primitives,
            nodes: self.nodes.len(),
            blocks: self.blocks,
            fill: self.primitives as f64 / (self.blocks * self.block_size).max(1) as f64,
            sah_cost: self.sah_cost,
            bytes: self.bytes(),
            ..BvhStats::default()
        };
        let mut stack: Vec<(usize, usize)> = if self.nodes.is_empty() { vec![] } else { vec![(0, 1)] };
        while let Some((at, depth)) = stack.pop() {
            stats.depth = stats.depth.max(depth);
            for (child, _) in self.children(at) {
                if child.is_leaf() {
                    stats.leaves += 1;
                } else {
                    stack.push((child.0 as usize, depth + 1));
                }
            }
        }
        stats
    }

    /// Walks the tree and checks what traversal relies on: every primitive in exactly one slot, every box inside of its
    /// parent's, every primitive's box inside of its leaf's, links within bounds, depth within the stack of traversal.
    pub fn validate(&self, primitives: &[Aabb], slots: &[u32]) -> Result<(), String> {
        let mut seen = vec![false; primitives.len()];
        let mut stack = if self.nodes.is_empty() { vec![] } else { vec![(0usize, self.bounds, 1usize)] };
        while let Some((at, bounds, depth)) = stack.pop() {
            if at >= self.nodes.len() {
                return Err(format!("link to node {at} of {}", self.nodes.len()));
            }
            if depth > MAX_DEPTH {
                return Err(format!("deeper than {MAX_DEPTH}"));
            }
            for (child, child_bounds) in self.children(at) {
                if !bounds.encloses(&child_bounds) {
                    return Err(format!("a child of node {at} sticks out"));
                }
                if !child.is_leaf() {
                    stack.push((child.0 as usize, child_bounds, depth + 1));
                    continue;
                }
                let (first, count) = child.blocks();
                let (first, end) = (first as usize * self.block_size, (first + count) as usize * self.block_size);
                let slots = slots.get(first..end).ok_or("leaf beyond the blocks")?;
                for &index in slots.iter().filter(|&&s| s != EMPTY_SLOT) {
                    let index = index as usize;
                    if std::mem::replace(seen.get_mut(index).ok_or("index beyond the primitives")?, true) {
                        return Err(format!("primitive {index} is in two leaves"));
                    }
                    if !child_bounds.encloses(&primitives[index]) {
                        return Err(format!("primitive {index} sticks out of its leaf"));
                    }
                }
            }
        }
        match seen.iter().position(|s| !s) {
            Some(index) => Err(format!("primitive {index} is in no leaf")),
            None => Ok(()),
        }
    }
}

/// Bound on the depth of a tree, in nodes: the stack of traversal has room for seven siblings a level.
const MAX_DEPTH: usize = 64;
