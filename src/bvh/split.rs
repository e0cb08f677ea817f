//! Where to cut a range of primitives: the surface-area heuristic over bins (Wald, "On fast Construction of SAH-based
//! Bounding Volume Hierarchies", 2007), with leaves priced in blocks.

use super::Isa;
use super::bins::{BINS, Bins, EMPTY_BOX, Grid, LaneBox, PrimRef, half_area, union};
use crate::workers;
use std::num::NonZeroUsize;

/// Primitives that one thread takes at a time, where many threads work on one range. Not a matter of how many they are,
/// so that the tree is not either.
const PIECE: usize = 1 << 14;

/// How ranges are cut.
#[derive(Clone, Copy)]
pub(super) struct Splitter {
    /// Slots a block, as a power of two.
    pub block_shift: u32,
    pub isa: Isa,
}

/// A cut, and what is on its two sides.
pub(super) struct Cut {
    grid: Grid,
    axis: usize,
    /// First bin of the right part.
    border: usize,
    /// Boxes of the left and the right part.
    pub sides: [LaneBox; 2],
}

impl Splitter {
    /// The box of a range.
    pub fn bounds(self, refs: &[PrimRef]) -> LaneBox {
        refs.iter().fold(EMPTY_BOX, |b, p| union(&b, &p.0))
    }

    /// The box of boxes.
    pub fn joined(self, boxes: &[LaneBox]) -> LaneBox {
        boxes.iter().fold(EMPTY_BOX, |a, b| union(&a, b))
    }

    /// Blocks that so many primitives fill.
    #[inline(always)]
    pub fn blocks(self, primitives: u32) -> u32 {
        (primitives + (1 << self.block_shift) - 1) >> self.block_shift
    }

    /// Cuts a range, in place: the first so many primitives and their box become the left part, the others the right
    /// one. `scratch` is as long as `refs` and is written over. Halves what can not be cut, since all centres are in
    /// one place or too far away from each other.
    pub fn split(self, refs: &mut [PrimRef], scratch: &mut [PrimRef], may_cut: bool) -> (usize, [LaneBox; 2]) {
        let cut = span(refs).filter(|_| may_cut).and_then(|grid| self.best_cut(grid, &Bins::of(refs, &grid, self.isa)));
        match cut {
            Some(cut) => (partition(refs, scratch, &cut), cut.sides),
            None => halve(refs),
        }
    }

    /// [`Splitter::split`] by many threads. Whether the parts are in `scratch` now comes last.
    pub fn split_together(
        self,
        refs: &mut [PrimRef],
        scratch: &mut [PrimRef],
        threads: NonZeroUsize,
    ) -> (usize, [LaneBox; 2], bool) {
        let spans = workers::map(threads, refs.chunks(PIECE).collect(), centres);
        let grid = grid_over(spans.iter().fold(EMPTY_BOX, |a, b| union(&a, b)));
        let cut = grid.and_then(|grid| {
            let bins = workers::map(threads, refs.chunks(PIECE).collect(), |p| Bins::of(p, &grid, self.isa));
            let mut all = bins[0].clone();
            bins[1..].iter().for_each(|piece| all.join(piece));
            self.best_cut(grid, &all).map(|cut| (cut, bins))
        });
        let Some((cut, bins)) = cut else {
            let (middle, sides) = halve(refs);
            return (middle, sides, false);
        };
        // The bins tell how much of each piece goes to the left, so where it goes.
        let lefts = bins.iter().map(|b| b.counts[cut.axis][..cut.border].iter().sum::<u32>() as usize);
        let lefts: Vec<usize> = lefts.collect();
        let middle = lefts.iter().sum();
        let pieces: Vec<&[PrimRef]> = refs.chunks(PIECE).collect();
        let (left, right) = scratch.split_at_mut(middle);
        let left = workers::slices(left, lefts.iter().copied());
        let right = workers::slices(right, pieces.iter().zip(&lefts).map(|(piece, left)| piece.len() - left));
        let jobs = pieces.into_iter().zip(left.into_iter().zip(right)).collect();
        workers::map(threads, jobs, |(piece, (left, right)): (&[PrimRef], (&mut [PrimRef], &mut [PrimRef]))| {
            let (mut left, mut right) = (left.iter_mut(), right.iter_mut());
            for p in piece {
                let place = if cut.is_left(p) { left.next() } else { right.next() };
                if let Some(place) = place {
                    *place = *p;
                }
            }
        });
        (middle, cut.sides, true)
    }

    /// The cheapest cut between bins, over all axes; `None` if no cut leaves something on either side.
    fn best_cut(self, grid: Grid, bins: &Bins) -> Option<Cut> {
        let (mut best, mut at) = (f32::INFINITY, None);
        for axis in 0..3 {
            let (boxes, counts) = (&bins.boxes[axis], &bins.counts[axis]);
            let mut right_costs = [0.0; BINS];
            let (mut right, mut right_count) = (EMPTY_BOX, 0);
            for k in (1..BINS).rev() {
                right = union(&boxes[k], &right);
                right_count += counts[k];
                right_costs[k] = self.cost(&right, right_count);
            }
            // All that is in bin 0 and all that is not.
            let total = right_count + counts[0];
            let (mut left, mut left_count) = (EMPTY_BOX, 0);
            for border in 1..BINS {
                left = union(&boxes[border - 1], &left);
                left_count += counts[border - 1];
                let cost = self.cost(&left, left_count) + right_costs[border];
                if cost < best && left_count > 0 && left_count < total {
                    (best, at) = (cost, Some((axis, border)));
                }
            }
        }
        at.map(|(axis, border)| {
            let (left, right) = bins.boxes[axis].split_at(border);
            let sides = [left, right].map(|side| side.iter().fold(EMPTY_BOX, |a, b| union(&a, b)));
            Cut { grid, axis, border, sides }
        })
    }

    /// Half the area times the number of blocks that this many primitives fill.
    #[inline(always)]
    fn cost(self, bounds: &LaneBox, count: u32) -> f32 {
        if count == 0 { 0.0 } else { half_area(bounds) * self.blocks(count) as f32 }
    }
}

impl Cut {
    #[inline(always)]
    fn is_left(&self, p: &PrimRef) -> bool {
        self.grid.bin(p, self.axis) < self.border
    }
}

/// Span of the doubled centres, as a box.
fn centres(refs: &[PrimRef]) -> LaneBox {
    let mut span = EMPTY_BOX;
    for p in refs {
        for axis in 0..3 {
            let c = p.centre(axis);
            span[axis] = if c < span[axis] { c } else { span[axis] };
            span[axis + 4] = if -c < span[axis + 4] { -c } else { span[axis + 4] };
        }
    }
    span
}

fn span(refs: &[PrimRef]) -> Option<Grid> {
    grid_over(centres(refs))
}

/// Bins over centres; `None` if they are in one place or not finite.
fn grid_over(centres: LaneBox) -> Option<Grid> {
    let size = [0, 1, 2].map(|axis| -centres[axis + 4] - centres[axis]);
    let usable = size.iter().all(|s| s.is_finite()) && size.iter().any(|s| *s > 0.0);
    usable.then(|| Grid::new([centres[0], centres[1], centres[2]], size))
}

/// Moves the primitives left of the cut to the front, in their order, and returns how many there are. Without a branch:
/// which side it will be can not be predicted.
fn partition(refs: &mut [PrimRef], scratch: &mut [PrimRef], cut: &Cut) -> usize {
    let (mut left, mut right) = (0, 0);
    let scratch = &mut scratch[..refs.len()];
    for i in 0..refs.len() {
        let p = refs[i];
        let is_left = usize::from(cut.is_left(&p));
        refs[left] = p;
        scratch[right] = p;
        left += is_left;
        right += 1 - is_left;
    }
    refs[left..].copy_from_slice(&scratch[..right]);
    left
}

/// The halves of a range, as it stands.
fn halve(refs: &[PrimRef]) -> (usize, [LaneBox; 2]) {
    let middle = refs.len() / 2;
    let (left, right) = refs.split_at(middle);
    (middle, [left, right].map(|side| side.iter().fold(EMPTY_BOX, |b, p| union(&b, &p.0))))
}
