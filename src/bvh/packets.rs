//! Rays that run alike against blocks of triangles.

#![allow(clippy::needless_range_loop)] // Numbers of rays and axes run over several arrays at once.

use super::TriangleHit;
use super::packet_rows::{Met, NONE, TOGETHER, WatertightRows, decide, depth_at};
use super::simd::{Beam, Ends, PACKET, PacketVisitor, RaySet, Room, Row, Wide, prefetch};
use super::triangles::TriangleBlock;
use crate::geometry::{Ray, TriangleRay};

/// Unit roundoff of f32.
const U: f64 = 1.0 / 16_777_216.0;

/// The bits of [`WatertightTest`](super::triangles::WatertightTest), with few f64 operations.
///
/// But for phantoms: a ray in the very plane of a triangle, to within rounding of f64, that passes outside of it may be
/// taken for a hit by rounding alone (two edge functions exactly 0). Such a triangle may be left out here where it is
/// not asked at all. Nothing hangs on it: what is hit there is the edge of a triangle seen edge-on that the ray misses
/// by rounding.
pub struct WatertightPacket<'a, const ANY_HIT: bool> {
    blocks: &'a [TriangleBlock],
    /// The axes called x, y and z here, the same for all rays: z is the one along which they run most.
    axes: [usize; 3],
    /// 1 where they run toward larger z, else -1: what is called depth is z times this.
    sign: f32,
    /// Error of edge functions: the first times the largest side of the triangle's box, plus the second.
    slack: [f32; 2],
    /// The same with the largest coordinate M of the sheared triangle, where that is no more than the last number.
    slack_of_m: [f32; 2],
    largest_m: f32,
    /// Error for the triangles of the block in question.
    block_slack: [f32; 8],
    /// Largest coordinate of the tree.
    extent: f64,
    /// Error of depths where edge functions have none.
    blur: f32,
    /// Whether the axes are those of each ray alone.
    same_axes: bool,
}

type WatertightRoom = Room<WatertightRows>;

/// What f32 can tell of a ray and a triangle.
struct Verdict<V> {
    /// Lanes where they may meet.
    maybe: u32,
    /// Lanes where they do, if depth allows.
    surely: u32,
    /// Bounds of the depth where they do.
    depth: [V; 2],
}

/// The numbers of a ray, or of several.
struct Sheared<V> {
    slope: [V; 2],
    offset: [V; 2],
    start: V,
    end: V,
}

impl<'a, const ANY_HIT: bool> WatertightPacket<'a, ANY_HIT> {
    /// What f32 tells of corners (x, y and depth of each), which lie between two depths. `slack`: error of their edge
    /// functions where the ray meets them, if that is known.
    ///
    /// The bound is that of [`WatertightTest`](super::triangles::WatertightTest) with slopes up to s in place of 1.
    /// With u = 2^-24, R the extent and d = (7 + 6s)uR: slope and product suR each, difference and constant (1 + s)uR
    /// each, sum 2(1 + s)uR, together (4 + 6s)uR and room for the f64 test's own rounding and for that of another axis
    /// (|o| <= 8R). An edge function of coordinates up to M <= 2(1 + s)R is off by at most 4dM + 2d² + 4u(M + d)² <
    /// M(4d + 8(1 + s)uR) + 6d². Where the ray meets a triangle whose box has sides up to L, M is at most (1 + s)L +
    /// 2d, so `slack` need not be found for each ray. But where it does not, the edge functions of a triangle seen
    /// edge-on may be nothing but rounding: only with the ray's own M do they prove a hit.
    ///
    /// Weights off by `error` of their sum shift the depth, a mean of the corners' depths, by no more than three times
    /// that part of their range; `blur` is for the rounding of the mean.
    #[inline(always)]
    fn judge<W: Wide>(
        &self,
        w: W,
        [a, b, c]: [[W::V; 3]; 3],
        [nearest, farthest]: [W::V; 2],
        slack: Option<W::V>,
        ray: Sheared<W::V>,
        mask: u32,
    ) -> Option<Verdict<W::V>> {
        let ([sx, sy], [ox, oy]) = (ray.slope, ray.offset);
        let mut maybe = mask & w.le(ray.start, farthest) & w.le(nearest, ray.end);
        if maybe == 0 {
            return None;
        }
        let ax = w.add(w.neg_mul_add(a[2], sx, a[0]), ox);
        let bx = w.add(w.neg_mul_add(b[2], sx, b[0]), ox);
        let cx = w.add(w.neg_mul_add(c[2], sx, c[0]), ox);
        let ay = w.add(w.neg_mul_add(a[2], sy, a[1]), oy);
        let by = w.add(w.neg_mul_add(b[2], sy, b[1]), oy);
        let cy = w.add(w.neg_mul_add(c[2], sy, c[1]), oy);
        let u = w.mul_sub(cx, by, w.mul(cy, bx));
        let v = w.mul_sub(ax, cy, w.mul(ay, cx));
        let x = w.mul_sub(bx, ay, w.mul(by, ax));
        let low = w.min(w.min(u, v), x);
        let high = w.max(w.max(u, v), x);
        let zero = w.splat(0.0);
        let inside = w.max(low, w.sub(zero, high));
        if let Some(slack) = slack {
            maybe &= w.le(w.sub(zero, slack), inside);
            if maybe == 0 {
                return None;
            }
        }
        let size_x = w.max(w.max(w.abs(ax), w.abs(bx)), w.abs(cx));
        let size_y = w.max(w.max(w.abs(ay), w.abs(by)), w.abs(cy));
        let size = w.max(size_x, size_y);
        let slack = w.mul_add(size, w.splat(self.slack_of_m[0]), w.splat(self.slack_of_m[1]));
        let maybe = maybe & w.le(w.sub(zero, slack), inside);
        if maybe == 0 {
            return None;
        }
        let surely = maybe & w.lt(slack, inside) & w.le(size, w.splat(self.largest_m));
        let inverse = w.div(w.splat(1.0), w.add(w.add(u, v), x));
        let at = w.mul_add(u, a[2], w.mul_add(v, b[2], w.mul(x, c[2])));
        let at = w.mul(at, inverse);
        let part = w.mul(w.mul(slack, w.abs(inverse)), w.splat(3.1));
        let error = w.mul_add(part, w.sub(farthest, nearest), w.splat(self.blur));
        Some(Verdict { maybe, surely, depth: [w.sub(at, error), w.add(at, error)] })
    }

    /// The f64 test of one ray and one triangle: keeps the hit if it is the nearest. True if there is one.
    #[inline(always)]
    fn settle(&self, room: &mut WatertightRoom, i: usize, code: u32) -> bool {
        let Room { slabs, rows, .. } = room;
        let ray = rows.rays.ray(i);
        let exact = TriangleRay::new(&ray);
        let old = rows.best.0[i].to_bits();
        let t_max = if old == NONE {
            ray.t_max
        } else if rows.exact.contains(i) {
            rows.t.0[i]
        } else {
            match exact.intersect_permuted(self.corners(old, exact.axes), ray.t_max) {
                Some((t, _, _)) => t,
                None => ray.t_max,
            }
        };
        let corners = self.corners(code, exact.axes);
        let Some((t, _, _)) = exact.intersect_permuted(corners, t_max) else { return false };
        if t < t_max || old == NONE || self.id(code) < self.id(old) {
            (rows.best.0[i], rows.t.0[i]) = (f32::from_bits(code), t);
            rows.exact.insert(i);
            let [.., z] = self.axes;
            let end =
                depth_at(ray.origin.to_array()[z], ray.direction.to_array()[z], f64::from(self.sign), t, self.extent);
            (rows.end[0].0[i], rows.end[1].0[i]) = (end[0], end[1]);
            let limit = (t * (1.0 + 4.0 * U)) as f32;
            slabs.limit.0[i] = if limit < slabs.limit.0[i] { limit } else { slabs.limit.0[i] };
        }
        true
    }

    /// Fetches the triangles that rays with the same axes have met, each once for all of a group.
    #[inline(always)]
    fn gather<W: Wide>(&self, w: W, best: &Row, at: usize, part: usize, met: &mut Met) {
        let codes = best.group(w, at + part);
        let mut left = w.lt(codes, w.splat(f32::from_bits(NONE)));
        let zero = w.splat(0.0);
        let (mut corners, mut ids) = ([[zero; 3]; 3], zero);
        while left != 0 {
            let code = best.0[(at + part + left.trailing_zeros() as usize) & (PACKET - 1)];
            let of_code = w.splat(code);
            let same = left & w.le(codes, of_code) & w.le(of_code, codes);
            left &= !same;
            let triangle = self.corners(code.to_bits(), self.axes);
            for corner in 0..3 {
                for k in 0..3 {
                    corners[corner][k] = w.select(same, w.splat(triangle[corner][k]), corners[corner][k]);
                }
            }
            ids = w.select(same, w.splat(f32::from_bits(self.id(code.to_bits()))), ids);
        }
        for corner in 0..3 {
            for k in 0..3 {
                w.store(corners[corner][k], &mut met.corners[corner][k][part..]);
            }
        }
        let mut bits = [0.0; TOGETHER];
        w.store(ids, &mut bits);
        for k in 0..W::LANES {
            met.ids[part + k] = bits[k].to_bits();
        }
    }

    /// Fetches the triangle that a ray has met, and its numbers in the order of its own axes.
    #[inline(always)]
    fn gather_one(&self, rows: &mut WatertightRows, at: usize, k: usize, met: &mut Met) {
        let i = (at + k) & (PACKET - 1);
        let code = rows.best.0[i].to_bits();
        if code == NONE {
            return;
        }
        let ray = TriangleRay::new(&rows.rays.ray(i));
        let triangle = self.corners(code, ray.axes);
        for axis in 0..3 {
            (rows.own_origin[axis].0[i], rows.shear[axis].0[i]) = (ray.origin[axis], ray.shear[axis]);
            for corner in 0..3 {
                met.corners[corner][axis][k] = triangle[corner][axis];
            }
        }
        met.ids[k] = self.id(code);
    }

    #[inline(always)]
    fn corners(&self, code: u32, axes: [usize; 3]) -> [[f32; 3]; 3] {
        self.blocks[(code >> 3) as usize].corners(code as usize & 7, axes)
    }

    #[inline(always)]
    fn id(&self, code: u32) -> u32 {
        self.blocks[(code >> 3) as usize].ids[code as usize & 7]
    }
}

/// A corner of one triangle in all lanes: x, y and depth.
#[inline(always)]
fn spread<W: Wide>(w: W, corner: &[[f32; 8]; 3], [x, y, z]: [usize; 3], sign: f32, slot: usize) -> [W::V; 3] {
    [w.splat(corner[x][slot & 7]), w.splat(corner[y][slot & 7]), w.splat(corner[z][slot & 7] * sign)]
}

/// A corner of eight triangles: x, y and depth.
#[inline(always)]
fn load_corner<E: Wide>(e: E, corner: &[[f32; 8]; 3], [x, y, z]: [usize; 3], sign: E::V) -> [E::V; 3] {
    [e.load(&corner[x]), e.load(&corner[y]), e.mul(e.load(&corner[z]), sign)]
}

/// Boxes of eight triangles.
#[inline(always)]
fn boxes<E: Wide>(e: E, block: &TriangleBlock) -> ([E::V; 3], [E::V; 3]) {
    let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = &block.corners;
    let ([lx, hx], [ly, hy], [lz, hz]) = (ends(e, ax, bx, cx), ends(e, ay, by, cy), ends(e, az, bz, cz));
    ([lx, ly, lz], [hx, hy, hz])
}

/// The smallest and the largest of three numbers.
#[inline(always)]
fn ends<E: Wide>(e: E, a: &[f32; 8], b: &[f32; 8], c: &[f32; 8]) -> [E::V; 2] {
    let (a, b, c) = (e.load(a), e.load(b), e.load(c));
    [e.min(e.min(a, b), c), e.max(e.max(a, b), c)]
}

impl<'a, const ANY_HIT: bool> PacketVisitor for WatertightPacket<'a, ANY_HIT> {
    type Source = &'a [TriangleBlock];
    type Rows = WatertightRows;
    type Found = Option<TriangleHit>;
    const ANY_HIT: bool = ANY_HIT;
    const LEAST: u32 = 9;
    const SLACK: f32 = 0.0;

    #[inline(always)]
    fn is_fit(_ray: &Ray, _extent: f64) -> bool {
        true
    }

    #[inline(always)]
    fn new(blocks: &'a [TriangleBlock]) -> Self {
        Self {
            blocks,
            axes: [0, 1, 2],
            sign: 1.0,
            slack: [0.0; 2],
            slack_of_m: [0.0; 2],
            largest_m: 0.0,
            block_slack: [0.0; 8],
            extent: 0.0,
            blur: 0.0,
            same_axes: true,
        }
    }

    #[inline(always)]
    fn take<W: Wide>(
        &mut self,
        w: W,
        Room { together, rows, .. }: &mut WatertightRoom,
        ends: &Ends,
        extent: f64,
    ) -> bool {
        let size = |axis: usize| (ends.direction[axis][0] + ends.direction[axis][1]).abs();
        let z = if size(0) > size(1) {
            if size(0) > size(2) { 0 } else { 2 }
        } else if size(1) > size(2) {
            1
        } else {
            2
        };
        let axes @ [x, y, z] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][z];
        let largest = |axis: usize| ends.direction[axis][0].abs().max(ends.direction[axis][1].abs());
        let [low, high] = ends.direction[z];
        let farthest = ends.origin.iter().flatten().fold(0.0, |far, v| v.abs().max(far));
        let steepest = largest(x).max(largest(y)) / low.abs().min(high.abs());
        // The depth of a hit is a sum of products of three coordinates, which f32 must hold with all bits, and t times the
        // direction one of a t that f32 holds. NaN goes nowhere.
        let (least, most) = (low.abs().min(high.abs()), low.abs().max(high.abs()));
        let is_same_way = low * high > 0.0 && least > 1e-24 && most < 1e20;
        if !(farthest <= 8.0 * extent && steepest <= 4.0 && is_same_way && (1e-8..1e12).contains(&extent)) {
            return false;
        }
        self.sign = 1f32.copysign(low as f32);
        let d = (7.0 + 6.0 * steepest) * U * extent;
        let times_m = 4.0 * d + 8.0 * (1.0 + steepest) * U * extent;
        let slack = [times_m * (1.0 + steepest), times_m * 2.0 * d + 6.0 * d * d].map(|slack| (slack * 1.001) as f32);
        self.largest_m = (2.0 * (1.0 + steepest) * extent) as f32;
        self.slack_of_m = [times_m, 6.0 * d * d].map(|slack| (slack * 1.001) as f32);
        (self.axes, self.slack, self.blur) = (axes, slack, (12.0 * U * extent) as f32);
        (self.extent, self.same_axes) = (extent, steepest < 1.0);
        rows.take(w, together, axes, self.sign, extent);
        true
    }

    #[inline(always)]
    fn expect(&self, block: u32) {
        prefetch(&self.blocks[block as usize]);
    }

    #[inline(always)]
    fn cull<E: Wide>(&mut self, e: E, beam: &Beam<E>, block: u32) -> u32 {
        let (low, high) = boxes(e, &self.blocks[block as usize]);
        let size = e.max(e.max(e.sub(high[0], low[0]), e.sub(high[1], low[1])), e.sub(high[2], low[2]));
        e.store(e.mul_add(size, e.splat(self.slack[0]), e.splat(self.slack[1])), &mut self.block_slack);
        // Empty slots are NaN, and are met by nothing.
        beam.meets(e, low, high) & e.le(low[0], high[0])
    }

    #[inline(always)]
    fn visit_across<W: Wide>(
        &mut self,
        w: W,
        room: &mut WatertightRoom,
        block: u32,
        mut slots: u32,
        groups: u32,
        active: &mut RaySet,
    ) {
        let [.., kz] = self.axes;
        while slots != 0 {
            let slot = slots.trailing_zeros() & 7;
            slots &= slots - 1;
            let code = block << 3 | slot;
            let [a, b, c] = &self.blocks[block as usize].corners;
            let slot = slot as usize;
            let corners = [
                spread(w, a, self.axes, self.sign, slot),
                spread(w, b, self.axes, self.sign, slot),
                spread(w, c, self.axes, self.sign, slot),
            ];
            let depth = |corner: &[[f32; 8]; 3]| corner[kz][slot] * self.sign;
            let (za, zb, zc) = (depth(a), depth(b), depth(c));
            let smaller = |a: f32, b: f32| if a < b { a } else { b };
            let larger = |a: f32, b: f32| if a > b { a } else { b };
            let nearest = w.splat(smaller(smaller(za, zb), zc));
            let farthest = w.splat(larger(larger(za, zb), zc));
            let (bounds, slack) = ([nearest, farthest], Some(w.splat(self.block_slack[slot])));
            let mut left = groups;
            while left != 0 {
                let group = left.trailing_zeros() as usize % (PACKET / W::LANES);
                left &= left - 1;
                let (at, mask) = (group * W::LANES, active.group::<W>(group));
                let Room { slabs, rows, .. } = &mut *room;
                let slope = [rows.slope[0].group(w, at), rows.slope[1].group(w, at)];
                let offset = [rows.offset[0].group(w, at), rows.offset[1].group(w, at)];
                let end = rows.end[1].group(w, at);
                let ray = Sheared { slope, offset, start: rows.start[0].group(w, at), end };
                let Some(Verdict { maybe, surely, depth }) = self.judge(w, corners, bounds, slack, ray, mask) else {
                    continue;
                };
                let nearer =
                    surely & w.lt(depth[1], rows.end[0].group(w, at)) & w.lt(rows.start[1].group(w, at), depth[0]);
                let beyond = surely & (w.lt(end, depth[0]) | w.lt(depth[1], rows.start[0].group(w, at)));
                let mut unclear = maybe & !nearer & !beyond;
                if ANY_HIT {
                    active.set_group::<W>(group, mask & !nearer);
                } else if nearer != 0 {
                    let [low, high] = &mut rows.end;
                    w.store(w.select(nearer, depth[0], w.load(&low.0[at..])), &mut low.0[at..]);
                    w.store(w.select(nearer, depth[1], end), &mut high.0[at..]);
                    let old = w.load(&slabs.limit.0[at..]);
                    let limit =
                        w.mul_sub(depth[1], w.abs(slabs.reciprocal[kz].group(w, at)), slabs.far[kz].group(w, at));
                    let limit = w.min(w.mul(limit, w.splat(1.0 + 8.0 * U as f32)), old);
                    w.store(w.select(nearer, limit, old), &mut slabs.limit.0[at..]);
                    rows.exact.set_group::<W>(group, rows.exact.group::<W>(group) & !nearer);
                    let best = w.select(nearer, w.splat(f32::from_bits(code)), rows.best.group(w, at));
                    w.store(best, &mut rows.best.0[at..]);
                }
                while unclear != 0 {
                    let i = (at + unclear.trailing_zeros() as usize) & (PACKET - 1);
                    unclear &= unclear - 1;
                    if self.settle(room, i, code) && ANY_HIT {
                        active.remove(i);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn visit_one<E: Wide>(&mut self, e: E, room: &mut WatertightRoom, block: u32, i: usize) -> bool {
        let [.., kz] = self.axes;
        let [a, b, c] = &self.blocks[block as usize].corners;
        let sign = e.splat(self.sign);
        let corners = [
            load_corner(e, a, self.axes, sign),
            load_corner(e, b, self.axes, sign),
            load_corner(e, c, self.axes, sign),
        ];
        let rows = &room.rows;
        let slope = [rows.slope[0].one(e, i), rows.slope[1].one(e, i)];
        let offset = [rows.offset[0].one(e, i), rows.offset[1].one(e, i)];
        let ray = Sheared { slope, offset, start: rows.start[0].one(e, i), end: rows.end[1].one(e, i) };
        let nearest = e.min(e.min(corners[0][2], corners[1][2]), corners[2][2]);
        let farthest = e.max(e.max(corners[0][2], corners[1][2]), corners[2][2]);
        let Some(verdict) = self.judge(e, corners, [nearest, farthest], None, ray, 0xff) else { return false };
        let (mut low, mut high) = ([0.0; 8], [0.0; 8]);
        e.store(verdict.depth[0], &mut low);
        e.store(verdict.depth[1], &mut high);
        let mut maybe = verdict.maybe;
        while maybe != 0 {
            let slot = maybe.trailing_zeros() & 7;
            maybe &= maybe - 1;
            let (code, low, high) = (block << 3 | slot, low[slot as usize], high[slot as usize]);
            let Room { slabs, rows, .. } = &mut *room;
            let mut unclear = true;
            if verdict.surely >> slot & 1 != 0 {
                if high < rows.end[0].0[i] && low > rows.start[1].0[i] {
                    if ANY_HIT {
                        return true;
                    }
                    (rows.end[0].0[i], rows.end[1].0[i], rows.best.0[i]) = (low, high, f32::from_bits(code));
                    rows.exact.remove(i);
                    let limit = high * slabs.reciprocal[kz].0[i].abs() - slabs.far[kz].0[i];
                    let limit = limit * (1.0 + 8.0 * U as f32);
                    slabs.limit.0[i] = if limit < slabs.limit.0[i] { limit } else { slabs.limit.0[i] };
                    continue;
                }
                unclear = !(low > rows.end[1].0[i] || high < rows.start[0].0[i]);
            }
            if unclear && self.settle(room, i, code) && ANY_HIT {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn finish<W: Wide>(
        &mut self,
        w: W,
        Room { together, rows, .. }: &mut WatertightRoom,
        ended: &RaySet,
        mut found: impl FnMut(usize, Option<TriangleHit>),
    ) {
        if ANY_HIT {
            return ended.each(|i| {
                found(together.number[i].into(), Some(TriangleHit { t: 0.0, triangle: 0, u: 0.0, v: 0.0 }));
            });
        }
        let count = together.count.min(PACKET);
        for at in (0..count).step_by(TOGETHER) {
            let mut met = Met { corners: [[[0.0; TOGETHER]; 3]; 3], ids: [0; TOGETHER] };
            if self.same_axes {
                for part in (0..TOGETHER).step_by(W::LANES) {
                    self.gather(w, &rows.best, at, part, &mut met);
                }
            } else {
                for k in 0..TOGETHER {
                    self.gather_one(rows, at, k, &mut met);
                }
            }
            let WatertightRows { rays, shear: [sx, sy, sz], own_origin, best, .. } = &*rows;
            let [x, y, z] = self.axes;
            let origin = [&rays.origin[x], &rays.origin[y], &rays.origin[z]];
            let [ox, oy, oz] = if self.same_axes { origin } else { own_origin.each_ref() };
            let shear = [sx.some(at), sy.some(at), sz.some(at)];
            let [t, u, v] = decide(self.axes, [ox.some(at), oy.some(at), oz.some(at)], shear, &met.corners);
            for k in 0..TOGETHER.min(count - at) {
                let hit = if best.0[at + k].to_bits() == NONE {
                    None
                } else {
                    Some(TriangleHit { t: t[k], triangle: met.ids[k], u: u[k], v: v[k] })
                };
                found(usize::from(together.number[at + k]), hit);
            }
        }
    }
}
