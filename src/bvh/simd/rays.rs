//! The rays of a packet side by side: in f64 as they come, in f32 as boxes are tested against them.

#![allow(clippy::needless_range_loop)] // Numbers of rays and axes run over several arrays at once.

use super::packet::PACKET;
use super::set::RaySet;
use super::task::Task;
use super::wide::{Row, Wide, of_group};
use crate::geometry::Ray;
use glam::DVec3;
use std::marker::PhantomData;
use std::ops::Range;

/// One number a ray.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Doubles(pub [f64; PACKET]);

impl Doubles {
    /// Nothing but zeros.
    pub const ZERO: Self = Self([0.0; PACKET]);

    /// So many, from place `at` on; both divide [`PACKET`].
    #[inline(always)]
    pub fn some<const COUNT: usize>(&self, at: usize) -> &[f64; COUNT] {
        self.0[at & (PACKET - COUNT)..].first_chunk().expect("there are as many")
    }
}

/// Rays that are told one by one. Packets take them in as they come, so that whoever makes them (by widening or
/// transforming others) does not lay them out in memory first: that took 7 of 24 ns a ray of f32 (interior P).
pub trait Rays {
    /// Whether each of their numbers lies side by side in memory, and not ray by ray.
    const IN_ROWS: bool;

    /// How many.
    fn count(&self) -> usize;

    /// One of them. Always inlined.
    fn ray(&self, i: usize) -> Ray;
}

impl Rays for [Ray] {
    const IN_ROWS: bool = false;

    #[inline(always)]
    fn count(&self) -> usize {
        self.len()
    }

    #[inline(always)]
    fn ray(&self, i: usize) -> Ray {
        self[i]
    }
}

/// What a visitor keeps of each ray.
pub trait RayRows {
    /// Where the rays go as they come, if that is needed.
    #[inline(always)]
    fn exact(&mut self) -> Option<&mut ExactRays> {
        None
    }
}

/// Rays side by side as they come.
#[derive(Debug)]
pub struct ExactRays {
    /// By axis.
    pub origin: [Doubles; 3],
    /// By axis.
    pub direction: [Doubles; 3],
    /// See [`Ray`].
    pub t_min: Doubles,
    /// See [`Ray`].
    pub t_max: Doubles,
}

impl Default for ExactRays {
    fn default() -> Self {
        let zero = Doubles::ZERO;
        Self { origin: [zero; 3], direction: [zero; 3], t_min: zero, t_max: zero }
    }
}

impl ExactRays {
    /// Puts a ray in a place.
    #[inline(always)]
    pub fn put(&mut self, i: usize, ray: &Ray) {
        let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
        for axis in 0..3 {
            self.origin[axis].0[i] = o[axis];
            self.direction[axis].0[i] = d[axis];
        }
        (self.t_min.0[i], self.t_max.0[i]) = (ray.t_min, ray.t_max);
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

/// Room for a packet while it is traced, and `R` for what a visitor keeps of each ray. It is not made anew for each
/// packet: clearing it took a fifth of the time of shadow rays.
#[derive(Debug, Default)]
pub struct Room<R> {
    /// The rays, rounded.
    pub together: Together,
    /// As boxes are tested against them.
    pub slabs: Slabs,
    /// The visitor's.
    pub rows: R,
}

/// Takes some of up to [`PACKET`] rays, at least one, into a [`Room`].
pub struct Take<'a, S: ?Sized, R> {
    /// Which of them.
    which: &'a RaySet,
    kinds: PhantomData<fn(&S) -> R>,
}

impl<'a, S: Rays + ?Sized, R: RayRows> Take<'a, S, R> {
    /// Those.
    #[inline(always)]
    pub fn new(which: &'a RaySet) -> Self {
        Self { which, kinds: PhantomData }
    }
}

/// A task, since the loops over all rays become vector code only where what is read and what is written are known not
/// to overlap.
///
/// Rays that lie in rows are taken number by number: they are read from one end to the other then (in f32, 8 KiB), and
/// every loop becomes vector code. One loop for all numbers did so in f32 only and waited for eight places of memory at
/// once. Others are taken ray by ray: number by number took 6 % of the whole time of the sphereflake.
impl<S: Rays + ?Sized, R: RayRows> Task for Take<'_, S, R> {
    type Input = S;
    type Output = Room<R>;

    #[inline(always)]
    fn run(self, rays: &S, Room { together, rows, .. }: &mut Room<R>) {
        let (count, all) = (self.which.len() as usize, rays.count().min(PACKET));
        let filled = count.next_multiple_of(16);
        (together.count, together.filled) = (count, filled);
        let mut exact = rows.exact();
        let by_number = if S::IN_ROWS && count == all { all } else { 0 };
        if by_number > 0 {
            let Together { origin: [ox, oy, oz], direction: [dx, dy, dz], t_min, t_max, .. } = &mut *together;
            let [mut x, mut y, mut z, mut p, mut q, mut r, mut start, mut end] = [const { None }; 8];
            if let Some(ExactRays { origin, direction, t_min, t_max }) = &mut exact {
                [x, y, z] = origin.each_mut().map(Some);
                [p, q, r] = direction.each_mut().map(Some);
                (start, end) = (Some(t_min), Some(t_max));
            }
            column::<0, S>(rays, all, ox, x);
            column::<3, S>(rays, all, dx, p);
            column::<1, S>(rays, all, oy, y);
            column::<4, S>(rays, all, dy, q);
            column::<2, S>(rays, all, oz, z);
            column::<5, S>(rays, all, dz, r);
            column::<6, S>(rays, all, t_min, start);
            column::<7, S>(rays, all, t_max, end);
        }
        if count == all {
            for i in 0..all {
                together.number[i] = i as u8;
            }
        } else {
            self.which.list(&mut together.number);
        }
        // What fills the last group up.
        for i in count..filled.min(PACKET) {
            together.number[i] = together.number[0];
        }
        let by_ray = by_number..filled.min(PACKET);
        match exact {
            Some(exact) => {
                for i in by_ray.clone() {
                    exact.put(i, &rays.ray(together.number[i].into()));
                }
                together.round(exact, by_ray);
            }
            None => {
                for i in by_ray {
                    together.put(i, &rays.ray(together.number[i].into()));
                }
            }
        }
    }
}

/// One of the numbers of a ray: origin, direction, t_min, t_max.
#[inline(always)]
fn number<const K: usize>(ray: &Ray) -> f64 {
    match K {
        0..3 => ray.origin.to_array()[K],
        3..6 => ray.direction.to_array()[K - 3],
        6 => ray.t_min,
        _ => ray.t_max,
    }
}

/// A number of all rays.
#[inline(always)]
fn column<const K: usize, S: Rays + ?Sized>(rays: &S, all: usize, rounded: &mut Row, exact: Option<&mut Doubles>) {
    let round = if K < 6 { |v: f64| v as f32 } else { rounded_down };
    let all = all.min(PACKET);
    match exact {
        None => {
            for i in 0..all {
                rounded.0[i] = round(number::<K>(&rays.ray(i)));
            }
        }
        Some(exact) => {
            for i in 0..all {
                let v = number::<K>(&rays.ray(i));
                (rounded.0[i], exact.0[i]) = (round(v), v);
            }
        }
    }
}

/// The largest f32 that is not above.
#[inline(always)]
fn rounded_down(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) > x { near.next_down() } else { near }
}

/// Rays of one packet, rounded. Places beyond the last ray, up to a multiple of 16, repeat the first one.
#[derive(Debug)]
pub struct Together {
    /// How many.
    pub count: usize,
    /// Places that are filled.
    pub filled: usize,
    /// What number each has outside.
    pub number: [u8; PACKET],
    /// By axis.
    pub origin: [Row; 3],
    /// By axis.
    pub direction: [Row; 3],
    /// See [`Ray`]; rounded down.
    pub t_min: Row,
    /// See [`Ray`]; rounded down.
    pub t_max: Row,
}

impl Default for Together {
    fn default() -> Self {
        let row = Row::ZERO;
        Self { count: 0, filled: 0, number: [0; PACKET], origin: [row; 3], direction: [row; 3], t_min: row, t_max: row }
    }
}

impl Together {
    /// Rounds some rays.
    #[inline(always)]
    fn round(&mut self, exact: &ExactRays, range: Range<usize>) {
        for axis in 0..3 {
            for i in range.clone() {
                self.origin[axis].0[i] = exact.origin[axis].0[i] as f32;
            }
            for i in range.clone() {
                self.direction[axis].0[i] = exact.direction[axis].0[i] as f32;
            }
        }
        for i in range {
            self.t_min.0[i] = rounded_down(exact.t_min.0[i]);
            self.t_max.0[i] = rounded_down(exact.t_max.0[i]);
        }
    }

    #[inline(always)]
    fn put(&mut self, i: usize, ray: &Ray) {
        let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
        for axis in 0..3 {
            self.origin[axis].0[i] = o[axis] as f32;
            self.direction[axis].0[i] = d[axis] as f32;
        }
        (self.t_min.0[i], self.t_max.0[i]) = (rounded_down(ray.t_min), rounded_down(ray.t_max));
    }

    /// One of them, rounded.
    #[inline(always)]
    pub fn ray(&self, i: usize) -> Ray {
        let ([ox, oy, oz], [dx, dy, dz]) = (&self.origin, &self.direction);
        let wide = |row: &Row| f64::from(row.0[i & (PACKET - 1)]);
        Ray {
            origin: DVec3::new(wide(ox), wide(oy), wide(oz)),
            direction: DVec3::new(wide(dx), wide(dy), wide(dz)),
            t_min: wide(&self.t_min),
            t_max: wide(&self.t_max),
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
#[derive(Clone, Copy, Debug)]
pub struct Ends {
    /// Of the origins, by axis.
    pub origin: [[f64; 2]; 3],
    /// Of the directions, by axis.
    pub direction: [[f64; 2]; 3],
    /// Of their reciprocals, by axis.
    pub(super) reciprocal: [[f32; 2]; 3],
}

/// The least and the greatest of a lane each.
struct Extremes<W: Wide>([W::V; 2]);

impl<W: Wide> Extremes<W> {
    #[inline(always)]
    fn none(w: W) -> Self {
        Self([w.splat(f32::INFINITY), w.splat(f32::NEG_INFINITY)])
    }

    #[inline(always)]
    fn hold(&mut self, w: W, v: W::V) {
        self.0 = [w.min(v, self.0[0]), w.max(v, self.0[1])];
    }

    #[inline(always)]
    fn ends(&self, w: W) -> [f32; 2] {
        w.ends(self.0[0], self.0[1])
    }
}

/// Factor on the entry that makes up for the relative errors of entry and exit.
const ENTRY_FACTOR: f32 = 1.0 - 16.0 * U;

/// Unit roundoff of f32.
const U: f32 = 1.0 / 16_777_216.0;

impl Slabs {
    /// Takes rays for a tree whose coordinates are at most `extent` in magnitude.
    ///
    /// A plane at b is met at t = (b - o) / d, here r b - r o. The rounding of d and that of r = 1/d scale both terms
    /// and so are relative to t: 2u|t|, and u|t| for the last sum. What is left is the rounding of o and of r o: 2u|r
    /// o|, and 2u|r o| where pad and factor are applied. The pad is 8u|o| and the visitor's slack, the factor that of
    /// [`PaddedSlab`](crate::geometry::PaddedSlab) twice over.
    ///
    /// Returns what holds all of them. In one pass, since the rows of a packet do not stay in the first cache. (To take
    /// rays in parts of 64 and to do this for one part while the next one is fetched: 6 to 18 % slower.)
    #[inline(always)]
    pub fn take<W: Wide>(&mut self, w: W, together: &Together, slack: f32, extent: f64) -> Ends {
        let slack = slack * U + 2f32.powi(-37);
        let (pad_of_all, pad_of_size) = (w.splat(slack * extent as f32), w.splat(8.0 * U + slack));
        let (one, factor, zero) = (w.splat(1.0), w.splat(ENTRY_FACTOR), w.splat(0.0));
        let (tiny, wider) = (w.splat(f32::MIN_POSITIVE), w.splat(4.0 * U));
        let [mut ox, mut oy, mut oz] = [Extremes::none(w), Extremes::none(w), Extremes::none(w)];
        let [mut dx, mut dy, mut dz] = [Extremes::none(w), Extremes::none(w), Extremes::none(w)];
        let [mut rx, mut ry, mut rz] = [Extremes::none(w), Extremes::none(w), Extremes::none(w)];
        for at in (0..together.filled.min(PACKET)).step_by(W::LANES) {
            let (o, d) = (of_group(w, &together.origin, at), of_group(w, &together.direction, at));
            let pad = w.mul_add(largest(w, o), pad_of_size, pad_of_all);
            let least = w.mul(largest(w, d), w.splat(2f32.powi(-40)));
            let ends = [(&mut ox, &mut dx, &mut rx), (&mut oy, &mut dy, &mut ry), (&mut oz, &mut dz, &mut rz)];
            for (axis, (of_origin, of_direction, of_reciprocal)) in ends.into_iter().enumerate() {
                let (o, d) = (o[axis], d[axis]);
                let inverse = w.div(one, w.mul_sign(w.max(least, w.abs(d)), d));
                let (constant, pad) = (w.mul(o, inverse), w.mul(pad, w.abs(inverse)));
                w.store(inverse, &mut self.reciprocal[axis].0[at..]);
                w.store(w.mul(inverse, factor), &mut self.near_reciprocal[axis].0[at..]);
                w.store(w.mul(w.add(constant, pad), factor), &mut self.near[axis].0[at..]);
                w.store(w.sub(constant, pad), &mut self.far[axis].0[at..]);
                of_origin.hold(w, o);
                of_direction.hold(w, d);
                of_reciprocal.hold(w, inverse);
            }
            let (start, end) = (together.t_min.group(w, at), together.t_max.group(w, at));
            w.store(w.max(w.mul_sub(start, factor, tiny), zero), &mut self.t_min.0[at..]);
            w.store(w.add(end, w.mul_add(w.abs(end), wider, tiny)), &mut self.limit.0[at..]);
        }
        Ends {
            origin: [ox.ends(w).map(f64::from), oy.ends(w).map(f64::from), oz.ends(w).map(f64::from)],
            direction: [dx.ends(w).map(f64::from), dy.ends(w).map(f64::from), dz.ends(w).map(f64::from)],
            reciprocal: [rx.ends(w), ry.ends(w), rz.ends(w)],
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
pub fn largest<W: Wide>(w: W, [x, y, z]: [W::V; 3]) -> W::V {
    w.max(w.max(w.abs(x), w.abs(y)), w.abs(z))
}
