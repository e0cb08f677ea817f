//! Rays side by side, as renderers make them and packets take them.

use super::simd::{Doubles, ExactRays, PACKET, Rays};
use crate::geometry::Ray;

/// Up to [`PACKET`] rays side by side.
#[derive(Debug, Default)]
pub struct RayPacket {
    /// Their numbers; beyond the last ray whatever was there.
    pub rows: ExactRays,
    count: usize,
}

impl RayPacket {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Says how many there are, whose numbers are or will be in the rows.
    pub fn set_len(&mut self, count: usize) {
        debug_assert!(count <= PACKET);
        self.count = count.min(PACKET);
    }

    /// One of them.
    #[inline(always)]
    pub fn ray(&self, i: usize) -> Ray {
        self.rows.ray(i & (PACKET - 1))
    }

    /// The first ones.
    pub fn first(&self, count: usize) -> FirstRays<'_> {
        FirstRays { rows: &self.rows, count: count.min(self.count) }
    }

    /// All of them.
    pub fn all(&self) -> FirstRays<'_> {
        self.first(self.count)
    }

    /// Takes some rays of another packet, in this order.
    pub fn take(&mut self, from: &Self, order: &[u16]) {
        let pick = |to: &mut Doubles, from: &Doubles| {
            for (to, &number) in to.0.iter_mut().zip(order) {
                *to = from.0[usize::from(number) & (PACKET - 1)];
            }
        };
        let (to, from) = (&mut self.rows, &from.rows);
        for axis in 0..3 {
            pick(&mut to.origin[axis], &from.origin[axis]);
            pick(&mut to.direction[axis], &from.direction[axis]);
        }
        pick(&mut to.t_min, &from.t_min);
        pick(&mut to.t_max, &from.t_max);
        self.set_len(order.len());
    }

    /// Keeps these rays only; their numbers rise.
    pub fn keep(&mut self, which: &[u16]) {
        let keep = |row: &mut Doubles| {
            for (to, &number) in (0..PACKET).zip(which) {
                row.0[to] = row.0[usize::from(number) & (PACKET - 1)];
            }
        };
        let rows = &mut self.rows;
        if which.len() < self.count {
            rows.origin.iter_mut().chain(&mut rows.direction).for_each(keep);
            keep(&mut rows.t_min);
            keep(&mut rows.t_max);
        }
        self.set_len(which.len());
    }
}

/// The first rays of a [`RayPacket`].
#[derive(Clone, Copy, Debug)]
pub struct FirstRays<'a> {
    rows: &'a ExactRays,
    count: usize,
}

impl Rays for FirstRays<'_> {
    const IN_ROWS: bool = true;

    #[inline(always)]
    fn count(&self) -> usize {
        self.count
    }

    #[inline(always)]
    fn ray(&self, i: usize) -> Ray {
        self.rows.ray(i & (PACKET - 1))
    }
}
