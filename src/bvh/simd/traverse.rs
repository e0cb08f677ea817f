//! Front-to-back traversal of one ray.

#[cfg(target_arch = "x86_64")]
use super::{Isa, x86::Avx2};
use super::{Lanes, Portable};
use crate::bvh::{BoxTest, Bvh, Child, MAX_DEPTH};
use crate::geometry::Ray;
#[cfg(target_arch = "x86_64")]
use glam::DVec3;
use std::mem::MaybeUninit;

/// What is done with the leaves on the way of a ray.
pub trait LeafVisitor: Sized {
    /// What a visitor is made from.
    type Source: Copy;

    /// What is left of a visitor at the end: little, since visitors are large, and written in pieces just before.
    /// Copying them out took 4 % of single rays.
    type Found;

    /// A visitor for a ray. Called inside of the traversal, so that set-up is compiled for its instruction set: a
    /// closure in its place stayed out of line and took 12 % of single rays.
    fn new(source: Self::Source, ray: &Ray) -> Self;

    /// Whether the order of leaves does not matter, since any hit ends the search. Pushing children unsorted is 0 to 11
    /// % faster then, median 8 % (kernels.md, lesson 6).
    const ANY_HIT: bool;

    /// Tests a block against the ray; lowers `t_max` when there is a hit before it. True ends the search.
    fn visit<L: Lanes>(&mut self, lanes: L, block: u32, t_max: &mut f64) -> bool;

    /// An inner node is opened: its eight boxes are tested.
    #[inline(always)]
    fn open(&mut self) {}

    /// What has been found. `ended`: by this visitor, before the last leaf.
    fn found(self, ended: bool) -> Self::Found;
}

/// A visitor, and how many nodes and blocks the traversal looks at for it.
pub struct Counted<V> {
    /// What does the work.
    pub visitor: V,
    /// Inner nodes opened and blocks tested.
    pub visits: u64,
}

impl<V: LeafVisitor> LeafVisitor for Counted<V> {
    type Source = V::Source;
    type Found = (u64, V::Found);
    const ANY_HIT: bool = V::ANY_HIT;

    #[inline(always)]
    fn new(source: V::Source, ray: &Ray) -> Self {
        Self { visitor: V::new(source, ray), visits: 0 }
    }

    #[inline(always)]
    fn visit<L: Lanes>(&mut self, lanes: L, block: u32, t_max: &mut f64) -> bool {
        self.visits += 1;
        self.visitor.visit(lanes, block, t_max)
    }

    #[inline(always)]
    fn open(&mut self) {
        self.visits += 1;
        self.visitor.open();
    }

    #[inline(always)]
    fn found(self, ended: bool) -> Self::Found {
        (self.visits, self.visitor.found(ended))
    }
}

impl Bvh {
    /// Visits the leaves that the ray may meet, nearer ones first, and returns what the visitor has found.
    ///
    /// With a conservative `T`, no leaf is passed over whose primitives the ray meets at t <= t_max, ties included.
    ///
    /// Always inlined, and so should be what calls it with a ray that has just been made: a function of its own gets
    /// the ray in memory and loads its numbers two by two. They have just been stored in other pieces, which the
    /// processor can not forward: 12 to 18 ns a ray (interior P).
    #[inline(always)]
    pub fn traverse<T: BoxTest, V: LeafVisitor>(&self, ray: &Ray, source: V::Source) -> V::Found {
        #[cfg(target_arch = "x86_64")]
        if !self.nodes.is_empty() && self.isa != Isa::Portable {
            let Ray { origin: o, direction: d, t_min, t_max } = *ray;
            // SAFETY: a tree gets its instruction set from `Isa::best` or after `Isa::is_available` (`Bvh::build`
            // checks). With 32 registers and masks of their own the same source took 1.08 to 1.30 times as long
            // (blobs100k, interior).
            return unsafe { traverse_avx2::<T, V>(self, source, o.x, o.y, o.z, d.x, d.y, d.z, t_min, t_max) };
        }
        traverse_portable::<T, V>(self, ray, source)
    }
}

/// For any processor, and for empty trees.
#[inline(never)]
fn traverse_portable<T: BoxTest, V: LeafVisitor>(tree: &Bvh, ray: &Ray, source: V::Source) -> V::Found {
    if tree.nodes.is_empty() {
        return V::new(source, ray).found(false);
    }
    traverse::<Portable, T, V>(Portable, tree, ray, source)
}

/// Takes the ray number by number, that is in registers: see [`Bvh::traverse`]. With that, and results in place of
/// visitors returned, single rays take 0.77 (fast) and 0.93 (robust) of the time (interior P: 122 -> 95 and 158 -> 147
/// ns).
///
/// # Safety
/// The processor has what [`Isa::Avx2`] names.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[allow(clippy::too_many_arguments)]
unsafe fn traverse_avx2<T: BoxTest, V: LeafVisitor>(
    tree: &Bvh,
    source: V::Source,
    ox: f64,
    oy: f64,
    oz: f64,
    dx: f64,
    dy: f64,
    dz: f64,
    t_min: f64,
    t_max: f64,
) -> V::Found {
    let ray = Ray { origin: DVec3::new(ox, oy, oz), direction: DVec3::new(dx, dy, dz), t_min, t_max };
    // SAFETY: this function's own condition.
    traverse::<Avx2, T, V>(unsafe { Avx2::new() }, tree, &ray, source)
}

/// Children that wait: at most seven a level.
pub(super) const STACK: usize = 7 * MAX_DEPTH + 8;

/// A child with the distance where the ray enters it, which is not negative: keys compare as distances do.
#[inline(always)]
fn keyed(distance: f32, child: Child) -> u64 {
    u64::from(distance.to_bits()) << 32 | u64::from(child.0)
}

/// The smallest key of children entered beyond `limit`.
#[inline(always)]
fn beyond(limit: f32) -> u64 {
    keyed(limit.max(0.0), Child(u32::MAX))
}

#[inline(always)]
fn traverse<L: Lanes, T: BoxTest, V: LeafVisitor>(lanes: L, tree: &Bvh, ray: &Ray, source: V::Source) -> V::Found {
    // The boxes first, since they are met first.
    let test = T::of(lanes, ray, tree.extent);
    let prepared = test.prepare(lanes);
    let mut visitor = V::new(source, ray);
    let mut t_max = ray.t_max;
    let ended = walk(lanes, tree, &test, &prepared, &mut visitor, &mut t_max, Child(0));
    visitor.found(ended)
}

/// Visits the leaves of a subtree that a ray may meet before `t_max`, nearer ones first. Whether the visitor ended it.
///
/// What lost or gained nothing (blobs100k and interior, single rays): a loop of its own for the way down, whose
/// constants then stay in registers (0 %); three children of any-hit rays written to the stack whether there are so
/// many or not, without a branch (0 to 6 % slower); their distances left out (0 %); prefetching of nodes that are
/// pushed (0 to 10 % slower, also in a mesh of a million triangles) or of blocks (0 to 6 % slower); huge pages (0 %).
#[inline(always)]
pub(super) fn walk<L: Lanes, T: BoxTest, V: LeafVisitor>(
    lanes: L,
    tree: &Bvh,
    test: &T,
    prepared: &T::Prepared<L>,
    visitor: &mut V,
    t_max: &mut f64,
    from: Child,
) -> bool {
    let mut limit = test.limit(*t_max);
    let mut end = beyond(limit);
    // Uninitialised: zeroing it would cost more than many a traversal.
    let mut stack = [MaybeUninit::<u64>::uninit(); STACK];
    let mut top = 0;
    let mut current = from;
    loop {
        if !current.is_leaf() {
            visitor.open();
            // SAFETY: inner children are made by `collapse` from indices of nodes it has pushed (`Bvh::validate`).
            let node = unsafe { tree.nodes.get_unchecked(current.0 as usize) };
            let (mut mask, distances) = test.entries(lanes, prepared, &node.planes, limit);
            if mask != 0 {
                let first = mask.trailing_zeros() as usize & 7;
                mask &= mask - 1;
                if mask == 0 {
                    current = node.children[first];
                    continue;
                }
                let distances = lanes.store(distances);
                let mut best = keyed(distances[first], node.children[first]);
                if V::ANY_HIT {
                    while mask != 0 {
                        let k = mask.trailing_zeros() as usize & 7;
                        mask &= mask - 1;
                        debug_assert!(top < STACK);
                        // SAFETY: at most seven entries a level and MAX_DEPTH levels (`Bvh::validate`).
                        unsafe { stack.get_unchecked_mut(top).write(keyed(distances[k], node.children[k])) };
                        top += 1;
                    }
                } else {
                    let bottom = top;
                    let k = mask.trailing_zeros() as usize & 7;
                    mask &= mask - 1;
                    let mut last = keyed(distances[k], node.children[k]);
                    (best, last) = (best.min(last), best.max(last));
                    if mask != 0 {
                        // Three in registers: whether the third comes before the second can not be predicted. 1 to 5 %
                        // of robust rays against insertion from the second on (blobs100k P, R, D).
                        let k = mask.trailing_zeros() as usize & 7;
                        mask &= mask - 1;
                        let key = keyed(distances[k], node.children[k]);
                        let middle = last.min(key);
                        last = last.max(key);
                        let second = best.max(middle);
                        best = best.min(middle);
                        debug_assert!(top < STACK);
                        // SAFETY: as above.
                        unsafe { stack.get_unchecked_mut(top).write(last) };
                        top += 1;
                        last = second;
                    }
                    debug_assert!(top < STACK);
                    // SAFETY: as above.
                    unsafe { stack.get_unchecked_mut(top).write(last) };
                    top += 1;
                    while mask != 0 {
                        let k = mask.trailing_zeros() as usize & 7;
                        mask &= mask - 1;
                        let key = keyed(distances[k], node.children[k]);
                        let later = best.max(key);
                        best = best.min(key);
                        // Insertion: the stack's upper part stays sorted, nearest on top.
                        let mut at = top;
                        debug_assert!(top < STACK);
                        // SAFETY: as above; entries below `top` have been written.
                        unsafe {
                            while at > bottom && stack.get_unchecked(at - 1).assume_init() < later {
                                let moved = *stack.get_unchecked(at - 1);
                                *stack.get_unchecked_mut(at) = moved;
                                at -= 1;
                            }
                            stack.get_unchecked_mut(at).write(later);
                        }
                        top += 1;
                    }
                }
                current = Child(best as u32);
                continue;
            }
        } else {
            let (first, count) = current.blocks();
            let before = *t_max;
            for block in first..first + count {
                if visitor.visit(lanes, block, t_max) {
                    return true;
                }
            }
            if *t_max < before {
                limit = test.limit(*t_max);
                end = beyond(limit);
            }
        }
        loop {
            if top == 0 {
                return false;
            }
            top -= 1;
            // SAFETY: entries below `top` have been written.
            let key = unsafe { stack.get_unchecked(top).assume_init() };
            if key <= end {
                current = Child(key as u32);
                break;
            }
        }
    }
}
