//! What lies in a box.

use super::Bvh;
use crate::geometry::Aabb;

impl Bvh {
    /// Visits the blocks of the leaves that meet `bounds`, until a visit says that it is enough.
    pub fn overlapping(&self, bounds: &Aabb, mut enough: impl FnMut(u32) -> bool) {
        let mut stack = if self.nodes.is_empty() { vec![] } else { vec![0] };
        while let Some(at) = stack.pop() {
            for (child, _) in self.children(at).filter(|(_, child)| child.overlaps(bounds)) {
                if !child.is_leaf() {
                    stack.push(child.0 as usize);
                    continue;
                }
                let (first, count) = child.blocks();
                if (first..first + count).any(&mut enough) {
                    return;
                }
            }
        }
    }
}
