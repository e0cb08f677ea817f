//! Hierarchies of axis-aligned boxes over anything that has one: triangles of a mesh, objects of a scene.

mod build;
mod traverse;

use crate::geometry::Aabb;

/// A binary hierarchy. Primitives are referred to by position in `order`, which maps to the caller's indices; leaves
/// hold runs of it.
#[derive(Clone, Debug)]
pub struct Bvh {
    /// Children boxes and links; node 0 is the root. Empty for fewer than two primitives.
    nodes: Vec<Node>,
    /// The caller's index of each position.
    order: Vec<u32>,
    /// Box of everything.
    bounds: Aabb,
}

/// Two children with their boxes: 64 bytes, one cache line.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: [Aabb; 2],
    /// A node index, or for a leaf its first position.
    link: [u32; 2],
    /// 0 for an inner node, else the number of primitives of the leaf.
    count: [u32; 2],
}

/// Numbers that describe a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BvhStats {
    /// Inner nodes.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Longest way from the root to a leaf.
    pub depth: usize,
    /// Bytes of nodes and order.
    pub bytes: usize,
}

impl Bvh {
    /// Box of everything; empty without primitives.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The caller's index of each position.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Describes the tree.
    pub fn stats(&self) -> BvhStats {
        let bytes = size_of_val(&*self.nodes) + size_of_val(&*self.order);
        let mut stats = BvhStats { nodes: self.nodes.len(), bytes, ..BvhStats::default() };
        let mut stack: Vec<(usize, usize)> = if self.nodes.is_empty() { vec![] } else { vec![(0, 1)] };
        while let Some((at, depth)) = stack.pop() {
            stats.depth = stats.depth.max(depth);
            for side in 0..2 {
                if self.nodes[at].count[side] == 0 {
                    stack.push((self.nodes[at].link[side] as usize, depth + 1));
                } else {
                    stats.leaves += 1;
                }
            }
        }
        stats
    }

    /// Walks the tree and checks what traversal relies on: every primitive in exactly one leaf, every box inside of its
    /// parent's, every primitive's box inside of its leaf's, depth within the stack of traversal.
    pub fn validate(&self, primitives: &[Aabb]) -> Result<(), String> {
        let mut seen = vec![false; primitives.len()];
        let mut leaf = |range: std::ops::Range<usize>, bounds: &Aabb| {
            for position in range {
                let index = *self.order.get(position).ok_or("leaf beyond the order")? as usize;
                if std::mem::replace(seen.get_mut(index).ok_or("index beyond the primitives")?, true) {
                    return Err(format!("primitive {index} is in two leaves"));
                }
                if !bounds.encloses(&primitives[index]) {
                    return Err(format!("primitive {index} sticks out of its leaf"));
                }
            }
            Ok(())
        };
        if self.nodes.is_empty() {
            leaf(0..self.order.len(), &self.bounds)?;
        } else {
            let mut stack = vec![(0usize, self.bounds, 1usize)];
            while let Some((at, bounds, depth)) = stack.pop() {
                let node = self.nodes.get(at).ok_or("link beyond the nodes")?;
                if depth > traverse::MAX_DEPTH {
                    return Err(format!("deeper than {}", traverse::MAX_DEPTH));
                }
                for side in 0..2 {
                    if !bounds.encloses(&node.bounds[side]) {
                        return Err(format!("child {side} of node {at} sticks out"));
                    }
                    let (link, count) = (node.link[side] as usize, node.count[side] as usize);
                    if count == 0 {
                        stack.push((link, node.bounds[side], depth + 1));
                    } else {
                        leaf(link..link + count, &node.bounds[side])?;
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
