//! Front-to-back traversal.

use super::Bvh;
use crate::geometry::{Ray, Slab};
use std::ops::Range;

/// Bound on the depth of a tree: the traversal stack holds one entry a level.
pub(super) const MAX_DEPTH: usize = 64;

impl Bvh {
    /// Visits the leaves that the ray may meet, nearer ones first. `leaf` gets positions in [`Bvh::order`] and returns the
    /// new end of the ray (smaller after a hit), or `None` to stop. Returns whether it was stopped.
    ///
    /// With a conservative `S`, no leaf is passed over whose primitives the ray meets at t <= t_max, ties included.
    #[inline(always)]
    pub fn traverse<S: Slab>(&self, ray: &Ray, mut leaf: impl FnMut(Range<usize>, f64) -> Option<f64>) -> bool {
        let mut t_max = ray.t_max;
        if self.nodes.is_empty() {
            return !self.order.is_empty() && leaf(0..self.order.len(), t_max).is_none();
        }
        let slab = S::new(ray, self.bounds.max_abs());
        let mut limit = slab.limit(t_max);
        let mut stack = [(0u32, 0u32, 0f32); MAX_DEPTH + 1];
        let mut depth = 0;
        let (mut link, mut count) = (0u32, 0u32);
        loop {
            if count == 0 {
                let node = &self.nodes[link as usize];
                let entries = [slab.entry(&node.bounds[0], limit), slab.entry(&node.bounds[1], limit)];
                let child = |side: usize| (node.link[side], node.count[side]);
                match entries {
                    [Some(a), Some(b)] => {
                        let (first, second, second_entry) = if b < a { (1, 0, a) } else { (0, 1, b) };
                        (link, count) = child(first);
                        let (later_link, later_count) = child(second);
                        stack[depth] = (later_link, later_count, second_entry);
                        depth += 1;
                        continue;
                    }
                    [Some(_), None] => {
                        (link, count) = child(0);
                        continue;
                    }
                    [None, Some(_)] => {
                        (link, count) = child(1);
                        continue;
                    }
                    [None, None] => {}
                }
            } else {
                match leaf(link as usize..(link + count) as usize, t_max) {
                    Some(end) if end < t_max => {
                        t_max = end;
                        limit = slab.limit(t_max);
                    }
                    Some(_) => {}
                    None => return true,
                }
            }
            loop {
                if depth == 0 {
                    return false;
                }
                depth -= 1;
                let (later_link, later_count, entry) = stack[depth];
                if entry <= limit {
                    (link, count) = (later_link, later_count);
                    break;
                }
            }
        }
    }
}
