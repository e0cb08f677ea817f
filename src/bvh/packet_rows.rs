//! What is kept of the rays of a packet for the watertight test of triangles.

#![allow(clippy::needless_range_loop)] // Numbers of rays and axes run over several arrays at once.

use super::simd::{Doubles, ExactRays, PACKET, RayRows, RaySet, Row, Together, Wide};
use crate::geometry::TriangleRay;

/// Unit roundoff of f32.
const U: f64 = 1.0 / 16_777_216.0;

/// Stands for no triangle: more than any code.
pub const NONE: u32 = 1 << 30;

/// What a [`WatertightPacket`](super::packets::WatertightPacket) keeps of each ray.
#[derive(Debug)]
pub struct WatertightRows {
    /// (dx / dz, dy / dz) times the sign.
    pub slope: [Row; 2],
    /// Where the line of a ray meets depth 0, negated.
    pub offset: [Row; 2],
    /// Depth at t_min: not more than, not less than.
    pub start: [Row; 2],
    /// Depth at the nearest hit so far, or at t_max: not more than, not less than.
    pub end: [Row; 2],
    /// Eight times the block, plus the slot, of the nearest hit so far, as bits of f32 (below 2).
    pub best: Row,
    /// Rays whose nearest hit's t is known.
    pub exact: RaySet,
    pub t: Doubles,
    /// As in [`TriangleRay`], but for the axes above.
    pub shear: [Doubles; 3],
    /// Origins in the order of each ray's own axes.
    pub own_origin: [Doubles; 3],
    /// The rays as they come.
    pub rays: ExactRays,
}

impl Default for WatertightRows {
    fn default() -> Self {
        let (row, zero) = (Row::ZERO, Doubles::ZERO);
        Self {
            slope: [row; 2],
            offset: [row; 2],
            start: [row; 2],
            end: [row; 2],
            best: row,
            exact: RaySet::NONE,
            t: zero,
            shear: [zero; 3],
            own_origin: [zero; 3],
            rays: ExactRays::default(),
        }
    }
}

impl RayRows for WatertightRows {
    #[inline(always)]
    fn exact(&mut self) -> Option<&mut ExactRays> {
        Some(&mut self.rays)
    }
}

impl WatertightRows {
    /// Takes rays that run along the last of some axes in a direction of this sign.
    #[inline(always)]
    pub fn take<W: Wide>(&mut self, w: W, together: &Together, axes: [usize; 3], sign: f32, extent: f64) {
        let filled = together.filled.min(PACKET);
        self.best.0[..filled].fill(f32::from_bits(NONE));
        self.exact = RaySet::NONE;
        let Self { rays, shear, slope, offset, start, end, .. } = self;
        shear_all(filled, axes, sign.into(), rays, shear, slope, offset);
        let [.., z] = axes;
        let (oz, dz, sign) = (&together.origin[z], &together.direction[z], w.splat(sign));
        for at in (0..filled).step_by(W::LANES) {
            let (oz, dz) = (w.mul(oz.group(w, at), sign), w.mul(dz.group(w, at), sign));
            for (t, [low, high]) in [(&together.t_min, &mut *start), (&together.t_max, &mut *end)] {
                let depth = depths(w, oz, dz, t.group(w, at), extent as f32);
                w.store(depth[0], &mut low.0[at..]);
                w.store(depth[1], &mut high.0[at..]);
            }
        }
    }
}

/// Rays that are decided together at the end.
pub const TOGETHER: usize = 16;

/// The triangles that some rays have met, side by side.
pub struct Met {
    /// By corner, and by axis in the order of the ray's.
    pub corners: [[[f32; TOGETHER]; 3]; 3],
    pub ids: [u32; TOGETHER],
}

/// (t, u, v) where rays meet triangles that they are known to meet.
#[inline(always)]
pub fn decide(
    axes: [usize; 3],
    [ox, oy, oz]: [&[f64; TOGETHER]; 3],
    [sx, sy, sz]: [&[f64; TOGETHER]; 3],
    [a, b, c]: &[[[f32; TOGETHER]; 3]; 3],
) -> [[f64; TOGETHER]; 3] {
    let [mut t, mut u, mut v] = [[0.0; TOGETHER]; 3];
    for k in 0..TOGETHER {
        let (origin, shear) = ([ox[k], oy[k], oz[k]], [sx[k], sy[k], sz[k]]);
        let ray = TriangleRay::from_parts(axes, origin, shear, f64::NEG_INFINITY);
        let corners = [[a[0][k], a[1][k], a[2][k]], [b[0][k], b[1][k], b[2][k]], [c[0][k], c[1][k], c[2][k]]];
        #[allow(clippy::manual_unwrap_or)] // `Option::unwrap_or` is not inlined always.
        let hit = match ray.intersect_permuted(corners, f64::INFINITY) {
            Some(hit) => hit,
            None => (0.0, 0.0, 0.0),
        };
        (t[k], u[k], v[k]) = hit;
    }
    [t, u, v]
}

/// Slopes and offsets of rays for some axes and a sign of the last one.
///
/// What is read and what is written are arguments of their own: see [`Task`](super::simd::Task).
#[inline(always)]
fn shear_all(
    filled: usize,
    [x, y, z]: [usize; 3],
    sign: f64,
    rays: &ExactRays,
    [sx, sy, inverse]: &mut [Doubles; 3],
    [slope_x, slope_y]: &mut [Row; 2],
    [offset_x, offset_y]: &mut [Row; 2],
) {
    let (ox, oy, oz) = (&rays.origin[x].0, &rays.origin[y].0, &rays.origin[z].0);
    let (dx, dy, dz) = (&rays.direction[x].0, &rays.direction[y].0, &rays.direction[z].0);
    for i in 0..filled.min(PACKET) {
        // As in [`TriangleRay::new`].
        let of_z = 1.0 / dz[i];
        let (of_x, of_y) = (dx[i] * of_z, dy[i] * of_z);
        (sx.0[i], sy.0[i], inverse.0[i]) = (of_x, of_y, of_z);
        (slope_x.0[i], slope_y.0[i]) = ((of_x * sign) as f32, (of_y * sign) as f32);
        (offset_x.0[i], offset_y.0[i]) = ((of_x * oz[i] - ox[i]) as f32, (of_y * oz[i] - oy[i]) as f32);
    }
}

/// [`depth_at`] in f32. With u = 2^-24: t is off by 2u|t d|, d and the product by u|t d| each, the origin by u|o|, the sum
/// by u times itself, and what is returned by as much again, where |t d| is no more than the sum and |o|: together 6u of
/// both.
#[inline(always)]
fn depths<W: Wide>(w: W, origin: W::V, direction: W::V, t: W::V, extent: f32) -> [W::V; 2] {
    let depth = w.mul_add(t, direction, origin);
    // Beyond everything, and finite. What is not a number stays so.
    let depth = w.max(w.splat(-1e30), w.min(w.splat(1e30), depth));
    let least = w.splat(1e-13 * extent);
    let pad = w.mul_add(w.add(w.abs(depth), w.abs(origin)), w.splat((6.5 * U) as f32), least);
    [w.sub(depth, pad), w.add(depth, pad)]
}

/// Bounds of the depth at t, which may be that of a hit found along another axis: its rounding is relative to the
/// extent.
#[inline(always)]
pub fn depth_at(origin: f64, direction: f64, sign: f64, t: f64, extent: f64) -> [f32; 2] {
    let depth = (origin + t * direction) * sign;
    // Beyond everything, and finite.
    let depth = if depth > 1e30 { 1e30 } else { depth };
    let depth = if depth < -1e30 { -1e30 } else { depth };
    let pad = depth.abs() * 1.3e-7 + 1e-14 * origin.abs() + 1e-13 * extent;
    [(depth - pad) as f32, (depth + pad) as f32]
}
