//! The rays of a packet side by side: in f64 as they come, in f32 as boxes are tested against them.

#![allow(clippy::needless_range_loop)] // Numbers of rays and axes run over several arrays at once.

use super::packet::PACKET;
use super::wide::{Row, Wide};
use crate::geometry::Ray;
use glam::DVec3;

/// One number a ray.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Doubles(pub [f64; PACKET]);

impl Doubles {
    /// Nothing but zeros.
    pub const ZERO: Self = Self([0.0; PACKET]);

    /// The smallest and the largest of the first `count`, which is a multiple of eight. NaN counts for nothing.
    #[inline(always)]
    fn ends(&self, count: usize) -> [f64; 2] {
        let (mut low, mut high) = ([f64::INFINITY; 8], [f64::NEG_INFINITY; 8]);
        for v in self.0[..count].chunks_exact(8) {
            for k in 0..8 {
                low[k] = if v[k] < low[k] { v[k] } else { low[k] };
                high[k] = if v[k] > high[k] { v[k] } else { high[k] };
            }
        }
        for half in [4, 2, 1] {
            for k in 0..half {
                low[k] = if low[k + half] < low[k] { low[k + half] } else { low[k] };
                high[k] = if high[k + half] > high[k] { high[k + half] } else { high[k] };
            }
        }
        [low[0], high[0]]
    }
}

/// Rays of one packet. Places beyond the last ray, up to a multiple of 16, repeat the first one.
pub struct Together {
    /// How many.
    pub count: usize,
    /// Places that are filled.
    pub filled: usize,
    /// What number each has outside.
    pub number: [u8; PACKET],
    /// By axis.
    pub origin: [Doubles; 3],
    /// By axis.
    pub direction: [Doubles; 3],
    /// See [`Ray`].
    pub t_min: Doubles,
    /// See [`Ray`].
    pub t_max: Doubles,
}

impl Together {
    /// Takes those of up to [`PACKET`] rays that have a bit in `which`, at least one.
    #[inline(always)]
    pub fn new(rays: &[Ray], mut which: u64) -> Self {
        let count = which.count_ones() as usize;
        let filled = count.next_multiple_of(16);
        let zero = Doubles::ZERO;
        let (origin, direction, number) = ([zero; 3], [zero; 3], [0; PACKET]);
        let mut new = Self { count, filled, number, origin, direction, t_min: zero, t_max: zero };
        if which.count_ones() == PACKET as u32
            && let Some(rays) = rays.first_chunk::<PACKET>()
        {
            // Without the detours of the loop below: 4 % of packets of f32.
            for (i, ray) in rays.iter().enumerate() {
                let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
                for axis in 0..3 {
                    new.origin[axis].0[i] = o[axis];
                    new.direction[axis].0[i] = d[axis];
                }
                (new.t_min.0[i], new.t_max.0[i], new.number[i]) = (ray.t_min, ray.t_max, i as u8);
            }
            return new;
        }
        let one = which.trailing_zeros() as usize;
        for i in 0..filled.min(PACKET) {
            let k = if which == 0 { one } else { which.trailing_zeros() as usize };
            which &= which.wrapping_sub(1);
            let ray = &rays[k];
            let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
            for axis in 0..3 {
                new.origin[axis].0[i] = o[axis];
                new.direction[axis].0[i] = d[axis];
            }
            (new.t_min.0[i], new.t_max.0[i], new.number[i]) = (ray.t_min, ray.t_max, k as u8);
        }
        new
    }

    /// One of them.
    #[inline(always)]
    pub fn ray(&self, i: usize) -> Ray {
        let ([ox, oy, oz], [dx, dy, dz]) = (&self.origin, &self.direction);
        Ray {
            origin: DVec3::new(ox.0[i], oy.0[i], oz.0[i]),
            direction: DVec3::new(dx.0[i], dy.0[i], dz.0[i]),
            t_min: self.t_min.0[i],
            t_max: self.t_max.0[i],
        }
    }
}

/// Rays as boxes are tested against them, in f32; see [`PaddedSlab`](crate::geometry::PaddedSlab).
pub struct Slabs {
    pub reciprocal: [Row; 3],
    pub near_reciprocal: [Row; 3],
    pub near: [Row; 3],
    pub far: [Row; 3],
    pub t_min: Row,
    /// Where rays end, rounded up; falls when they meet something.
    pub limit: Row,
    /// Row of the near plane of each axis, the same for all rays; the far one is its neighbour, row ^ 1.
    pub(super) rows: [usize; 3],
}

/// Intervals that hold the rays of a packet.
pub struct Ends {
    /// Of the origins, by axis.
    pub origin: [[f64; 2]; 3],
    /// Of the directions, by axis.
    pub direction: [[f64; 2]; 3],
}

impl Ends {
    #[inline(always)]
    pub fn new(together: &Together) -> Self {
        let n = together.filled;
        let (o, d) = (&together.origin, &together.direction);
        Self {
            origin: [o[0].ends(n), o[1].ends(n), o[2].ends(n)],
            direction: [d[0].ends(n), d[1].ends(n), d[2].ends(n)],
        }
    }
}

/// Factor on the entry that makes up for the relative errors of entry and exit.
const ENTRY_FACTOR: f32 = 1.0 - 16.0 * U;

/// Unit roundoff of f32.
const U: f32 = 1.0 / 16_777_216.0;

impl Slabs {
    /// No numbers.
    #[inline(always)]
    #[allow(clippy::new_without_default)] // `default` might not be inlined.
    pub fn new() -> Self {
        let row = Row::new(0.0);
        let rows = [row; 3];
        Self { reciprocal: rows, near_reciprocal: rows, near: rows, far: rows, t_min: row, limit: row, rows: [0, 2, 4] }
    }

    /// Takes rays for a tree whose coordinates are at most `extent` in magnitude.
    ///
    /// A plane at b is met at t = (b - o) / d, here r b - r o. The rounding of d and that of r = 1/d scale both terms and so are relative to t:
    /// 2u|t|, and u|t| for the last sum. What is left is the rounding of o and of r o: 2u|r o|, and 2u|r o| where pad and factor are
    /// applied. The pad is 8u|o| and the visitor's slack, the factor that of [`PaddedSlab`](crate::geometry::PaddedSlab) twice over.
    #[inline(always)]
    pub fn take(&mut self, together: &Together, slack: f32, extent: f64) {
        let Together { filled, origin, direction, t_min, t_max, .. } = together;
        let filled = (*filled).min(PACKET);
        let (mut pad, mut least) = (Row::new(0.0), Row::new(0.0));
        let slack = slack * U + 2f32.powi(-37);
        sizes(filled, origin, |i, size| pad.0[i] = 8.0 * U * size + slack * (extent as f32 + size));
        sizes(filled, direction, |i, size| least.0[i] = size * 2f32.powi(-40));
        for axis in 0..3 {
            let (o, d) = (&origin[axis].0, &direction[axis].0);
            let (r, nr) = (&mut self.reciprocal[axis].0, &mut self.near_reciprocal[axis].0);
            let (near, far) = (&mut self.near[axis].0, &mut self.far[axis].0);
            for i in 0..filled {
                let (o, d) = (o[i] as f32, d[i] as f32);
                let small = least.0[i].copysign(d);
                let inverse = 1.0 / if d.abs() < least.0[i] { small } else { d };
                let (constant, pad) = (o * inverse, pad.0[i] * inverse.abs());
                r[i] = inverse;
                nr[i] = inverse * ENTRY_FACTOR;
                near[i] = (constant + pad) * ENTRY_FACTOR;
                far[i] = constant - pad;
            }
        }
        for i in 0..filled {
            let (start, end) = (t_min.0[i] as f32 * ENTRY_FACTOR, t_max.0[i] as f32);
            let start = start - f32::MIN_POSITIVE;
            self.t_min.0[i] = if start > 0.0 { start } else { 0.0 };
            self.limit.0[i] = end + (end.abs() * 4.0 * U + f32::MIN_POSITIVE);
        }
    }

    /// Which rays of the group that starts at place `at` meet a box, a bit each.
    #[inline(always)]
    pub fn meet<W: Wide>(&self, w: W, at: usize, planes: &[[f32; 8]; 6], child: usize) -> u32 {
        let mut enter = self.t_min.group(w, at);
        let mut exit = self.limit.group(w, at);
        for axis in 0..3 {
            // SAFETY: rows are below 6 (`Beam::new`).
            let (near, far) =
                unsafe { (planes.get_unchecked(self.rows[axis]), planes.get_unchecked(self.rows[axis] ^ 1)) };
            let near =
                w.mul_sub(w.splat(near[child]), self.near_reciprocal[axis].group(w, at), self.near[axis].group(w, at));
            let far = w.mul_sub(w.splat(far[child]), self.reciprocal[axis].group(w, at), self.far[axis].group(w, at));
            (enter, exit) = (w.max(near, enter), w.min(far, exit));
        }
        w.le(enter, exit)
    }
}

/// The largest component of each vector, rounded.
#[inline(always)]
fn sizes(count: usize, [x, y, z]: &[Doubles; 3], mut take: impl FnMut(usize, f32)) {
    for i in 0..count.min(PACKET) {
        let (x, y, z) = ((x.0[i] as f32).abs(), (y.0[i] as f32).abs(), (z.0[i] as f32).abs());
        let larger = if x > y { x } else { y };
        take(i, if larger > z { larger } else { z });
    }
}
