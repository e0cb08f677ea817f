//! Rays that run alike against blocks of triangles, in f32.

use super::TriangleHit;
use super::simd::{
    Beam, Ends, PACKET, PacketVisitor, RayRows, RaySet, Room, Row, Wide, largest, of_group, ones, prefetch,
};
use super::triangles::TriangleBlock;
use crate::geometry::Ray;

/// Coordinates that are neither too small nor too large.
const NEAR: f64 = 1e-10;
const FAR: f64 = 1e10;

/// Stands for no triangle: more than any code.
const NONE: u32 = 1 << 30;

/// Möller and Trumbore (1997), as [`MoellerTrumboreTest`](super::triangles::MoellerTrumboreTest): without fused
/// operations, so that every instruction set gives the same bits.
///
/// The test may say yes far from the triangle where a ray grazes it. Then it would depend on the boxes on the way
/// whether it is asked, and so on the other rays of the packet. Hence a hit counts only where it lies in the triangle's
/// own box, which is widened by less than the boxes on the way are: what is found is the first of all such hits, in
/// whatever order.
pub struct MoellerTrumborePacket<'a, const ANY_HIT: bool> {
    blocks: &'a [TriangleBlock],
    block: Sides,
}

/// What a [`MoellerTrumborePacket`] keeps of each ray.
#[derive(Debug, Default)]
pub struct PlainRows {
    /// Of the nearest hit so far; where the ray ends if there is none.
    t: Row,
    /// Weights of its corners.
    u: Row,
    v: Row,
    /// Eight times its block, plus its slot, as bits of f32 (below 2).
    best: Row,
    /// How far a hit may lie outside of the triangle's box.
    pad: Row,
}

impl RayRows for PlainRows {}

type PlainRoom = Room<PlainRows>;

/// Triangles of the block in question.
#[repr(align(32))]
struct Sides {
    e1: [[f32; 8]; 3],
    e2: [[f32; 8]; 3],
    low: [[f32; 8]; 3],
    high: [[f32; 8]; 3],
}

/// Hits of some lanes.
struct Hits<V> {
    lanes: u32,
    t: V,
    u: V,
    v: V,
}

/// Three coordinates.
type Three<V> = [V; 3];

/// A triangle: first corner, sides, box.
struct Triangle<V> {
    corner: Three<V>,
    sides: [Three<V>; 2],
    bounds: [Three<V>; 2],
}

#[inline(always)]
fn sub<W: Wide>(w: W, a: Three<W::V>, b: Three<W::V>) -> Three<W::V> {
    [w.sub(a[0], b[0]), w.sub(a[1], b[1]), w.sub(a[2], b[2])]
}

#[inline(always)]
fn dot<W: Wide>(w: W, a: Three<W::V>, b: Three<W::V>) -> W::V {
    w.add(w.add(w.mul(a[0], b[0]), w.mul(a[1], b[1])), w.mul(a[2], b[2]))
}

#[inline(always)]
fn cross<W: Wide>(w: W, a: Three<W::V>, b: Three<W::V>) -> Three<W::V> {
    [
        w.sub(w.mul(a[1], b[2]), w.mul(a[2], b[1])),
        w.sub(w.mul(a[2], b[0]), w.mul(a[0], b[2])),
        w.sub(w.mul(a[0], b[1]), w.mul(a[1], b[0])),
    ]
}

#[inline(always)]
fn splat<W: Wide>(w: W, of: &[[f32; 8]; 3], slot: usize) -> Three<W::V> {
    [w.splat(of[0][slot & 7]), w.splat(of[1][slot & 7]), w.splat(of[2][slot & 7])]
}

#[inline(always)]
fn load_eight<E: Wide>(e: E, of: &[[f32; 8]; 3]) -> Three<E::V> {
    [e.load(&of[0]), e.load(&of[1]), e.load(&of[2])]
}

/// Hits with t_min < t <= t_max.
#[inline(always)]
fn meet<W: Wide>(
    w: W,
    o: Three<W::V>,
    d: Three<W::V>,
    triangle: &Triangle<W::V>,
    [t_min, t_max, pad]: [W::V; 3],
    mask: u32,
) -> Option<Hits<W::V>> {
    let [e1, e2] = triangle.sides;
    let p = cross(w, d, e2);
    let det = dot(w, e1, p);
    let s = sub(w, o, triangle.corner);
    let u = w.mul_sign(dot(w, s, p), det);
    let q = cross(w, s, e1);
    let v = w.mul_sign(dot(w, d, q), det);
    let size = w.abs(det);
    let zero = w.splat(0.0);
    let lanes = mask & w.le(zero, w.min(u, v)) & w.le(w.add(u, v), size) & w.lt(zero, size);
    if lanes == 0 {
        return None;
    }
    let inverse = w.div(w.splat(1.0), size);
    let t = w.mul(w.mul_sign(dot(w, e2, q), det), inverse);
    let mut lanes = lanes & w.lt(t_min, t) & w.le(t, t_max);
    let [low, high] = triangle.bounds;
    for axis in 0..3 {
        let at = w.add(o[axis], w.mul(d[axis], t));
        lanes &= w.le(w.sub(low[axis], pad), at) & w.le(at, w.add(high[axis], pad));
    }
    if lanes == 0 {
        return None;
    }
    Some(Hits { lanes, t, u: w.mul(u, inverse), v: w.mul(v, inverse) })
}

impl<'a, const ANY_HIT: bool> MoellerTrumborePacket<'a, ANY_HIT> {
    #[inline(always)]
    fn id(&self, code: u32) -> u32 {
        self.blocks[(code >> 3) as usize].ids[code as usize & 7]
    }

    /// Whether a hit at the same t as the nearest one comes before it.
    #[inline(always)]
    fn is_first(&self, rows: &PlainRows, i: usize, code: u32) -> bool {
        let old = rows.best.0[i].to_bits();
        old == NONE || self.id(code) < self.id(old)
    }
}

impl<'a, const ANY_HIT: bool> PacketVisitor for MoellerTrumborePacket<'a, ANY_HIT> {
    type Source = &'a [TriangleBlock];
    type Rows = PlainRows;
    type Found = Option<TriangleHit>;
    const ANY_HIT: bool = ANY_HIT;
    /// All of them, since a ray alone may find something else.
    const LEAST: u32 = 1;
    /// Twice what `pad` has, so that the rounding of the hit point is in it.
    const SLACK: f32 = 16.0;

    /// Neither overflow nor zero in what boxes are tested with. Of the rounded numbers, which are all that a packet
    /// has.
    #[inline(always)]
    fn is_fit(ray: &Ray, extent: f64) -> bool {
        let (o, d) = (ray.origin.abs(), ray.direction.abs());
        let [o, d] = [o.max_element(), d.max_element()].map(|size| f64::from(size as f32));
        (o <= FAR) & (NEAR..=FAR).contains(&d) & (NEAR..=FAR).contains(&extent)
    }

    #[inline(always)]
    fn new(blocks: &'a [TriangleBlock]) -> Self {
        let zero = [[0.0; 8]; 3];
        Self { blocks, block: Sides { e1: zero, e2: zero, low: zero, high: zero } }
    }

    #[inline(always)]
    fn take<W: Wide>(&mut self, w: W, Room { together, rows, .. }: &mut PlainRoom, ends: &Ends, extent: f64) -> bool {
        let farthest = ends.origin.iter().flatten().fold(0.0, |far: f64, v| v.abs().max(far));
        let fastest = ends.direction.iter().flatten().fold(0.0, |far: f64, v| v.abs().max(far));
        let slowest = ends.direction.iter().fold(0.0, |most: f64, [low, high]| low.abs().min(high.abs()).max(most));
        let fit = farthest <= FAR && fastest <= FAR && slowest >= NEAR && (NEAR..=FAR).contains(&extent);
        if !fit && !(0..together.count.min(PACKET)).all(|i| Self::is_fit(&together.ray(i), extent)) {
            return false;
        }
        let filled = together.filled.min(PACKET);
        rows.best.0[..filled].fill(f32::from_bits(NONE));
        rows.t.0[..filled].copy_from_slice(&together.t_max.0[..filled]);
        let (part, extent) = (w.splat(8.0 / 16_777_216.0), w.splat(extent as f32));
        for at in (0..filled).step_by(W::LANES) {
            let size = largest(w, of_group(w, &together.origin, at));
            w.store(w.mul(part, w.add(size, extent)), &mut rows.pad.0[at..]);
        }
        true
    }

    #[inline(always)]
    fn expect(&self, block: u32) {
        prefetch(&self.blocks[block as usize]);
    }

    #[inline(always)]
    fn cull<E: Wide>(&mut self, e: E, beam: &Beam<E>, block: u32) -> u32 {
        let [a, b, c] = &self.blocks[block as usize].corners;
        let (a, b, c) = (load_eight(e, a), load_eight(e, b), load_eight(e, c));
        let (mut low, mut high) = (a, a);
        for axis in 0..3 {
            low[axis] = e.min(e.min(a[axis], b[axis]), c[axis]);
            high[axis] = e.max(e.max(a[axis], b[axis]), c[axis]);
            e.store(low[axis], &mut self.block.low[axis]);
            e.store(high[axis], &mut self.block.high[axis]);
            e.store(e.sub(b[axis], a[axis]), &mut self.block.e1[axis]);
            e.store(e.sub(c[axis], a[axis]), &mut self.block.e2[axis]);
        }
        // Empty slots are NaN, and are met by nothing.
        beam.meets(e, low, high) & e.le(low[0], high[0])
    }

    #[inline(always)]
    fn visit_across<W: Wide>(
        &mut self,
        w: W,
        room: &mut PlainRoom,
        block: u32,
        mut slots: u32,
        groups: u32,
        active: &mut RaySet,
    ) {
        let Room { together, slabs, rows } = room;
        while slots != 0 {
            let slot = slots.trailing_zeros() as usize & 7;
            slots &= slots - 1;
            let code = block << 3 | slot as u32;
            let triangle = Triangle {
                corner: splat(w, &self.blocks[block as usize].corners[0], slot),
                sides: [splat(w, &self.block.e1, slot), splat(w, &self.block.e2, slot)],
                bounds: [splat(w, &self.block.low, slot), splat(w, &self.block.high, slot)],
            };
            let mut left = groups;
            while left != 0 {
                let group = left.trailing_zeros() as usize % (PACKET / W::LANES);
                left &= left - 1;
                let (at, mask) = (group * W::LANES, active.group::<W>(group));
                // Ended by another triangle of the block (1 to 2 % of shadow rays, interior and blobs100k).
                if ANY_HIT && mask == 0 {
                    continue;
                }
                let limits = [together.t_min.group(w, at), rows.t.group(w, at), rows.pad.group(w, at)];
                let (o, d) = (of_group(w, &together.origin, at), of_group(w, &together.direction, at));
                let Some(mut hits) = meet(w, o, d, &triangle, limits, mask) else { continue };
                if ANY_HIT {
                    active.set_group::<W>(group, mask & !hits.lanes);
                    continue;
                }
                let mut same = hits.lanes & !w.lt(hits.t, limits[1]);
                while same != 0 {
                    let k = same.trailing_zeros() as usize;
                    same &= same - 1;
                    if !self.is_first(rows, (at + k) & (PACKET - 1), code) {
                        hits.lanes &= !(1 << k);
                    }
                }
                let Hits { lanes, t, u, v } = hits;
                let best = w.splat(f32::from_bits(code));
                for (to, new) in [(&mut rows.t, t), (&mut rows.u, u), (&mut rows.v, v), (&mut rows.best, best)] {
                    w.store(w.select(lanes, new, w.load(&to.0[at..])), &mut to.0[at..]);
                }
                let limit = w.select(lanes, t, w.load(&slabs.limit.0[at..]));
                w.store(limit, &mut slabs.limit.0[at..]);
            }
        }
    }

    #[inline(always)]
    fn visit_one<E: Wide>(&mut self, e: E, room: &mut PlainRoom, block: u32, i: usize) -> bool {
        let Room { together, slabs, rows } = room;
        let [a, b, c] = &self.blocks[block as usize].corners;
        let (a, b, c) = (load_eight(e, a), load_eight(e, b), load_eight(e, c));
        let (mut low, mut high) = (a, a);
        for axis in 0..3 {
            low[axis] = e.min(e.min(a[axis], b[axis]), c[axis]);
            high[axis] = e.max(e.max(a[axis], b[axis]), c[axis]);
        }
        let triangle = Triangle { corner: a, sides: [sub(e, b, a), sub(e, c, a)], bounds: [low, high] };
        let (o, d) = (ones(e, &together.origin, i), ones(e, &together.direction, i));
        let limits = [together.t_min.one(e, i), rows.t.one(e, i), rows.pad.one(e, i)];
        let Some(mut hits) = meet(e, o, d, &triangle, limits, 0xff) else { return false };
        if ANY_HIT {
            return true;
        }
        let (mut t, mut u, mut v) = ([0.0; 8], [0.0; 8], [0.0; 8]);
        e.store(hits.t, &mut t);
        e.store(hits.u, &mut u);
        e.store(hits.v, &mut v);
        while hits.lanes != 0 {
            let slot = hits.lanes.trailing_zeros() as usize & 7;
            hits.lanes &= hits.lanes - 1;
            let code = block << 3 | slot as u32;
            if t[slot] < rows.t.0[i] || (t[slot] == rows.t.0[i] && self.is_first(rows, i, code)) {
                (rows.t.0[i], rows.u.0[i], rows.v.0[i]) = (t[slot], u[slot], v[slot]);
                (rows.best.0[i], slabs.limit.0[i]) = (f32::from_bits(code), t[slot]);
            }
        }
        false
    }

    #[inline(always)]
    fn finish<W: Wide>(
        &mut self,
        _w: W,
        room: &mut PlainRoom,
        ended: &RaySet,
        mut found: impl FnMut(usize, Option<TriangleHit>),
    ) {
        let Room { together, rows, .. } = room;
        if ANY_HIT {
            return ended.each(|i| {
                found(together.number[i].into(), Some(TriangleHit { t: 0.0, triangle: 0, u: 0.0, v: 0.0 }));
            });
        }
        for i in 0..together.count.min(PACKET) {
            let code = rows.best.0[i].to_bits();
            let hit = if code == NONE {
                None
            } else {
                let wide = |row: &Row| f64::from(row.0[i]);
                Some(TriangleHit { t: wide(&rows.t), triangle: self.id(code), u: wide(&rows.u), v: wide(&rows.v) })
            };
            found(usize::from(together.number[i]), hit);
        }
    }
}
