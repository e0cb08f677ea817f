//! The rays of a packet side by side: in f64 as they come, in f32 as boxes are tested against them.

#![allow(clippy::needless_range_loop)] // Numbers of rays and axes run over several arrays at once.

use super::packet::PACKET;
use super::set::RaySet;
use super::wide::{Row, Wide, of_group};
use crate::geometry::Ray;
use glam::DVec3;

/// One number a ray.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Doubles(pub [f64; PACKET]);

impl Doubles {
    /// Nothing but zeros.
    pub const ZERO: Self = Self([0.0; PACKET]);
}

/// Room for a packet while it is traced, and `R` for what a visitor keeps of each ray. It is not made anew for each packet: clearing it took
/// a fifth of the time of shadow rays.
#[derive(Debug, Default)]
pub struct Room<R> {
    /// The rays as they come.
    pub together: Together,
    /// As boxes are tested against them.
    pub slabs: Slabs,
    /// The visitor's.
    pub rows: R,
}

/// Rays of one packet. Places beyond the last ray, up to a multiple of 16, repeat the first one.
#[derive(Debug)]
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
    /// Origins, rounded.
    pub near_origin: [Row; 3],
    /// Directions, rounded.
    pub near_direction: [Row; 3],
}

impl Default for Together {
    fn default() -> Self {
        Self {
            count: 0,
            filled: 0,
            number: [0; PACKET],
            origin: [Doubles::ZERO; 3],
            direction: [Doubles::ZERO; 3],
            t_min: Doubles::ZERO,
            t_max: Doubles::ZERO,
            near_origin: [Row::ZERO; 3],
            near_direction: [Row::ZERO; 3],
        }
    }
}

impl Together {
    /// Takes some of up to [`PACKET`] rays, at least one.
    #[inline(always)]
    pub fn take(&mut self, rays: &[Ray], which: &RaySet) {
        let count = which.len() as usize;
        let filled = count.next_multiple_of(16);
        (self.count, self.filled) = (count, filled);
        if count == rays.len() {
            // Without the detours of the loop below: 4 % of packets of f32. (Eight rays at a time, transposed in AVX-512 registers: no gain.)
            for (i, ray) in rays.iter().enumerate().take(PACKET) {
                self.put(i, i, ray);
            }
        } else {
            let mut i = 0;
            which.each(|k| {
                self.put(i, k, &rays[k]);
                i += 1;
            });
        }
        let first = self.number[0];
        for i in count..filled.min(PACKET) {
            self.put(i, first.into(), &rays[usize::from(first)]);
        }
        for axis in 0..3 {
            round(filled, &self.origin[axis], &mut self.near_origin[axis]);
            round(filled, &self.direction[axis], &mut self.near_direction[axis]);
        }
    }

    #[inline(always)]
    fn put(&mut self, i: usize, number: usize, ray: &Ray) {
        let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
        let i = i & (PACKET - 1);
        for axis in 0..3 {
            self.origin[axis].0[i] = o[axis];
            self.direction[axis].0[i] = d[axis];
        }
        (self.t_min.0[i], self.t_max.0[i], self.number[i]) = (ray.t_min, ray.t_max, number as u8);
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
#[derive(Debug, Default)]
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

/// Intervals that hold the rays of a packet, rounded to f32. NaN counts for nothing.
pub struct Ends {
    /// Of the origins, by axis.
    pub origin: [[f64; 2]; 3],
    /// Of the directions, by axis.
    pub direction: [[f64; 2]; 3],
}

impl Ends {
    #[inline(always)]
    pub fn new<W: Wide>(w: W, together: &Together) -> Self {
        let filled = together.filled.min(PACKET);
        let mut ends = Self { origin: [[0.0; 2]; 3], direction: [[0.0; 2]; 3] };
        for axis in 0..3 {
            ends.origin[axis] = together.near_origin[axis].ends(w, filled).map(f64::from);
            ends.direction[axis] = together.near_direction[axis].ends(w, filled).map(f64::from);
        }
        ends
    }
}

#[inline(always)]
fn round(filled: usize, from: &Doubles, to: &mut Row) {
    for i in 0..filled.min(PACKET) {
        to.0[i] = from.0[i] as f32;
    }
}

/// Factor on the entry that makes up for the relative errors of entry and exit.
const ENTRY_FACTOR: f32 = 1.0 - 16.0 * U;

/// Unit roundoff of f32.
const U: f32 = 1.0 / 16_777_216.0;

impl Slabs {
    /// Takes rays for a tree whose coordinates are at most `extent` in magnitude.
    ///
    /// A plane at b is met at t = (b - o) / d, here r b - r o. The rounding of d and that of r = 1/d scale both terms and so are relative to t:
    /// 2u|t|, and u|t| for the last sum. What is left is the rounding of o and of r o: 2u|r o|, and 2u|r o| where pad and factor are
    /// applied. The pad is 8u|o| and the visitor's slack, the factor that of [`PaddedSlab`](crate::geometry::PaddedSlab) twice over.
    #[inline(always)]
    pub fn take(&mut self, together: &Together, slack: f32, extent: f64) {
        let Together { filled, near_origin: origin, near_direction: direction, t_min, t_max, .. } = together;
        let filled = (*filled).min(PACKET);
        let (mut pad, mut least) = (Row::ZERO, Row::ZERO);
        let slack = slack * U + 2f32.powi(-37);
        sizes(filled, origin, |i, size| pad.0[i] = 8.0 * U * size + slack * (extent as f32 + size));
        sizes(filled, direction, |i, size| least.0[i] = size * 2f32.powi(-40));
        for axis in 0..3 {
            let (o, d) = (&origin[axis].0, &direction[axis].0);
            let (r, nr) = (&mut self.reciprocal[axis].0, &mut self.near_reciprocal[axis].0);
            let (near, far) = (&mut self.near[axis].0, &mut self.far[axis].0);
            for i in 0..filled {
                let (o, d) = (o[i], d[i]);
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

    /// The rays of the group that starts at place `at`.
    #[inline(always)]
    pub fn of_group<W: Wide>(&self, w: W, at: usize) -> SlabGroup<W> {
        SlabGroup {
            reciprocal: of_group(w, &self.reciprocal, at),
            near_reciprocal: of_group(w, &self.near_reciprocal, at),
            near: of_group(w, &self.near, at),
            far: of_group(w, &self.far, at),
            t_min: self.t_min.group(w, at),
            limit: self.limit.group(w, at),
        }
    }
}

/// As many rays as there are lanes, as boxes are tested against them.
pub struct SlabGroup<W: Wide> {
    reciprocal: [W::V; 3],
    near_reciprocal: [W::V; 3],
    near: [W::V; 3],
    far: [W::V; 3],
    t_min: W::V,
    limit: W::V,
}

impl<W: Wide> SlabGroup<W> {
    /// Which of them meet the box of a child, a bit each. `rows`: those of [`Slabs`].
    #[inline(always)]
    pub(super) fn meet(&self, w: W, rows: &[usize; 3], planes: &[[f32; 8]; 6], child: usize) -> u32 {
        let (mut enter, mut exit) = (self.t_min, self.limit);
        for axis in 0..3 {
            // SAFETY: rows are below 6 (`Beam::new`).
            let (near, far) = unsafe { (planes.get_unchecked(rows[axis]), planes.get_unchecked(rows[axis] ^ 1)) };
            let near = w.mul_sub(w.splat(near[child]), self.near_reciprocal[axis], self.near[axis]);
            let far = w.mul_sub(w.splat(far[child]), self.reciprocal[axis], self.far[axis]);
            (enter, exit) = (w.max(near, enter), w.min(far, exit));
        }
        w.le(enter, exit)
    }
}

/// The largest component of each vector.
#[inline(always)]
fn sizes(count: usize, [x, y, z]: &[Row; 3], mut take: impl FnMut(usize, f32)) {
    for i in 0..count.min(PACKET) {
        let (x, y, z) = (x.0[i].abs(), y.0[i].abs(), z.0[i].abs());
        let larger = if x > y { x } else { y };
        take(i, if larger > z { larger } else { z });
    }
}
