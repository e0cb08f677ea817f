//! Intervals that hold the rays of a packet, against eight boxes.

#![allow(clippy::needless_range_loop)] // Numbers of axes run over several arrays at once.

use super::rays::{Ends, Slabs};
use super::wide::Wide;
use crate::geometry::PaddedSlab;

/// Intervals that hold the rays of a packet, spread over lanes.
pub struct Beam<E: Wide> {
    /// Row of the near plane of each axis; the far one is its neighbour, row ^ 1.
    rows: [usize; 3],
    /// Ends of the origins that are nearest to the near planes, and to the far planes.
    origin: [[E::V; 3]; 2],
    /// Least and greatest.
    reciprocal: [[E::V; 3]; 2],
    t_min: E::V,
}

impl<E: Wide> Beam<E> {
    /// The intervals; `None` if the rays are of different octants or not finite.
    #[inline(always)]
    pub(super) fn new(eight: E, ends: &Ends, slabs: &mut Slabs, extent: f64) -> Option<Self> {
        let mut rows = [0; 3];
        let zero = eight.splat(0.0);
        let mut beam = Self { rows, origin: [[zero; 3]; 2], reciprocal: [[zero; 3]; 2], t_min: zero };
        let farthest = ends.origin.iter().flatten().fold(0.0, |far: f64, v| v.abs().max(far));
        for axis in 0..3 {
            let [first, last] = ends.reciprocal[axis];
            let negative = last < 0.0;
            if !((negative || first > 0.0) && (first - last).is_finite()) {
                return None;
            }
            rows[axis] = 2 * axis + usize::from(negative);
            // Three roundings of the origin and its difference to a plane, the visitor's slack, and what `Slabs` pad
            // for components that are almost zero: these move a ray by 2^-40 of its way along the other axes. What else
            // is rounded is relative to t and made up for below.
            let [low, high] = ends.origin[axis];
            let pad = (farthest + extent) * 2f64.powi(-19);
            let (low, high) = ((low - pad) as f32, (high + pad) as f32);
            let (to_near, to_far) = if negative { (low, high) } else { (high, low) };
            beam.origin[0][axis] = eight.splat(to_near);
            beam.origin[1][axis] = eight.splat(to_far);
            beam.reciprocal[0][axis] = eight.splat(first);
            beam.reciprocal[1][axis] = eight.splat(last);
        }
        (beam.rows, slabs.rows) = (rows, rows);
        Some(beam)
    }

    /// Which children any ray may meet, a bit each, lower bounds of where they are entered, and which of them all rays
    /// meet unless they end before.
    #[inline(always)]
    pub(super) fn entries(&self, e: E, planes: &[[f32; 8]; 6]) -> (u32, E::V, u32) {
        let [r0, r1] = &self.reciprocal;
        let (mut enter, mut exit) = (self.t_min, e.splat(f32::INFINITY));
        let (mut last_enter, mut first_exit) = (self.t_min, e.splat(f32::INFINITY));
        for axis in 0..3 {
            // SAFETY: `new` makes rows below 6.
            let (near, far) =
                unsafe { (planes.get_unchecked(self.rows[axis]), planes.get_unchecked(self.rows[axis] ^ 1)) };
            let (near, far) = (e.load(near), e.load(far));
            let (o0, o1) = (self.origin[0][axis], self.origin[1][axis]);
            let (r0, r1) = (r0[axis], r1[axis]);
            let first = e.sub(near, o0);
            enter = e.max(e.min(e.mul(first, r0), e.mul(first, r1)), enter);
            let last = e.sub(far, o1);
            exit = e.min(e.max(e.mul(last, r0), e.mul(last, r1)), exit);
            let first = e.sub(near, o1);
            last_enter = e.max(e.max(e.mul(first, r0), e.mul(first, r1)), last_enter);
            let last = e.sub(far, o0);
            first_exit = e.min(e.min(e.mul(last, r0), e.mul(last, r1)), first_exit);
        }
        let enter = e.mul(enter, e.splat(PaddedSlab::ENTRY_FACTOR as f32));
        let exit = e.mul(exit, e.splat((2.0 - PaddedSlab::ENTRY_FACTOR) as f32));
        let met = e.le(enter, exit);
        (met, enter, met & e.le(last_enter, first_exit))
    }

    /// Which boxes any ray may meet, a bit each.
    #[inline(always)]
    pub fn meets(&self, e: E, lower: [E::V; 3], upper: [E::V; 3]) -> u32 {
        let [r0, r1] = &self.reciprocal;
        let (mut enter, mut exit) = (self.t_min, e.splat(f32::INFINITY));
        for axis in 0..3 {
            let negative = self.rows[axis] & 1 != 0;
            let (near, far) = if negative { (upper[axis], lower[axis]) } else { (lower[axis], upper[axis]) };
            let first = e.sub(near, self.origin[0][axis]);
            let last = e.sub(far, self.origin[1][axis]);
            let (r0, r1) = (r0[axis], r1[axis]);
            enter = e.max(e.min(e.mul(first, r0), e.mul(first, r1)), enter);
            exit = e.min(e.max(e.mul(last, r0), e.mul(last, r1)), exit);
        }
        let enter = e.mul(enter, e.splat(PaddedSlab::ENTRY_FACTOR as f32));
        let exit = e.mul(exit, e.splat((2.0 - PaddedSlab::ENTRY_FACTOR) as f32));
        e.le(enter, exit)
    }
}
