//! Triangles of a mesh in blocks of eight, and the tests of a ray against a block.

use super::packet_rows::WatertightRows;
use super::packets::WatertightPacket;
use super::plain_packets::{MoellerTrumborePacket, PlainRows};
use super::simd::{Counted, Isa, Lanes, LeafVisitor, RaySet, Rays, Room, filled};
use super::{Bvh, BvhStats, EMPTY_SLOT, PACKET, Packets, TreeKernels};
use crate::geometry::{Aabb, Ray, TriangleRay};
use glam::Vec3;
use std::num::NonZeroUsize;

/// Eight triangles, coordinate by coordinate: `corners[corner][axis][lane]`. Absent ones are NaN, which fails every
/// comparison. 320 bytes, five cache lines.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct TriangleBlock {
    pub(super) corners: [[[f32; 8]; 3]; 3],
    pub(super) ids: [u32; 8],
}

impl TriangleBlock {
    /// The corners of a lane's triangle, their coordinates in the given order of axes.
    #[inline(always)]
    pub(super) fn corners(&self, lane: usize, [x, y, z]: [usize; 3]) -> [[f32; 3]; 3] {
        let lane = lane & 7;
        let [a, b, c] = &self.corners;
        [
            [a[x][lane], a[y][lane], a[z][lane]],
            [b[x][lane], b[y][lane], b[z][lane]],
            [c[x][lane], c[y][lane], c[z][lane]],
        ]
    }

    /// The corners of a lane's triangle, axis by axis in the given order; the fourth numbers are 0.
    #[inline(always)]
    fn triangle<L: Lanes>(&self, lanes: L, lane: usize, [x, y, z]: [usize; 3]) -> [L::F; 3] {
        let lane = lane & 7;
        let [a, b, c] = &self.corners;
        let [x, y, z] = [x, y, z].map(|k| [a[k][lane], b[k][lane], c[k][lane], 0.0]);
        [lanes.widened(x), lanes.widened(y), lanes.widened(z)]
    }
}

/// A hit with a triangle of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// In units of the ray's direction.
    pub t: f64,
    /// Index of the triangle.
    pub triangle: u32,
    /// Weight of the second corner.
    pub u: f64,
    /// Weight of the third corner.
    pub v: f64,
}

/// Room that packets of rays need while they are in a mesh; kept by whoever traces, so that it is not made anew for
/// each.
#[derive(Debug, Default)]
pub struct PacketRoom {
    watertight: Option<Box<Room<WatertightRows>>>,
    plain: Option<Box<Room<PlainRows>>>,
}

/// A tree with its triangles.
#[derive(Clone, Debug)]
pub struct Triangles {
    tree: Bvh,
    blocks: Vec<TriangleBlock>,
}

impl Triangles {
    /// Builds the tree over triangles, given by their corners.
    pub fn build(count: usize, corners: impl Fn(usize) -> [Vec3; 3] + Sync, isa: Isa, threads: NonZeroUsize) -> Self {
        let (tree, slots) = Bvh::build(count, |i| Aabb::of_points(corners(i)), 8, isa, threads);
        let blocks = filled(slots.len() / 8, threads, |k| {
            let mut block = TriangleBlock { corners: [[[f32::NAN; 8]; 3]; 3], ids: [EMPTY_SLOT; 8] };
            for (lane, &id) in slots[8 * k..][..8].iter().enumerate().filter(|&(_, &id)| id != EMPTY_SLOT) {
                for (corner, p) in corners(id as usize).into_iter().enumerate() {
                    for axis in 0..3 {
                        block.corners[corner][axis][lane] = p[axis];
                    }
                }
                block.ids[lane] = id;
            }
            block
        });
        Self { tree, blocks }
    }

    /// The tree.
    pub fn tree(&self) -> &Bvh {
        &self.tree
    }

    /// Describes the tree; its bytes are those of nodes and blocks.
    pub fn stats(&self) -> BvhStats {
        let stats = self.tree.stats();
        BvhStats { bytes: stats.bytes + size_of_val(&*self.blocks), ..stats }
    }

    /// The closest hit of a ray; of hits at the same t the one of the smallest index.
    #[inline(always)]
    pub fn intersect<K: TreeKernels>(&self, ray: &Ray) -> Option<TriangleHit> {
        self.tree.traverse::<K::Boxes, Visitor<'_, K::Triangles, false>>(ray, self).1
    }

    /// Whether a ray meets any triangle.
    #[inline(always)]
    pub fn occluded<K: TreeKernels>(&self, ray: &Ray) -> bool {
        self.tree.traverse::<K::Boxes, Visitor<'_, K::Triangles, true>>(ray, self).0
    }

    /// Nodes and blocks that [`Triangles::intersect`] looks at; with `any`, those of [`Triangles::occluded`].
    pub fn visits<K: TreeKernels>(&self, ray: &Ray, any: bool) -> u64 {
        if any {
            self.tree.traverse::<K::Boxes, Counted<Visitor<'_, K::Triangles, true>>>(ray, self).0
        } else {
            self.tree.traverse::<K::Boxes, Counted<Visitor<'_, K::Triangles, false>>>(ray, self).0
        }
    }

    /// Hands to `found` the number of each ray and what [`Triangles::intersect`] gives for it ([`Packets`] says how
    /// far); quicker where up to [`PACKET`] rays run alike. Returns those of the first [`PACKET`] that were traced
    /// alone.
    pub fn intersect_packet<K: TreeKernels>(
        &self,
        rays: &(impl Rays + ?Sized),
        room: &mut PacketRoom,
        mut found: impl FnMut(usize, Option<TriangleHit>),
    ) -> RaySet {
        let left = match K::PACKETS {
            None => RaySet::first(PACKET),
            Some(Packets::Watertight) => {
                let room = room.watertight.get_or_insert_default();
                self.tree.traverse_packet::<WatertightPacket<false>, _>(rays, &self.blocks, room, &mut found)
            }
            Some(Packets::MoellerTrumbore) => {
                let room = room.plain.get_or_insert_default();
                self.tree.traverse_packet::<MoellerTrumborePacket<false>, _>(rays, &self.blocks, room, &mut found)
            }
        };
        for i in (0..rays.count()).filter(|&i| i >= PACKET || left.contains(i)) {
            found(i, self.intersect::<K>(&rays.ray(i)));
        }
        left
    }

    /// The same with [`Triangles::occluded`]; `found` hears of those only that meet a triangle.
    pub fn occluded_packet<K: TreeKernels>(
        &self,
        rays: &(impl Rays + ?Sized),
        room: &mut PacketRoom,
        mut found: impl FnMut(usize),
    ) -> RaySet {
        let mut any = |i, _: Option<TriangleHit>| found(i);
        let left = match K::PACKETS {
            None => RaySet::first(PACKET),
            Some(Packets::Watertight) => {
                let room = room.watertight.get_or_insert_default();
                self.tree.traverse_packet::<WatertightPacket<true>, _>(rays, &self.blocks, room, &mut any)
            }
            Some(Packets::MoellerTrumbore) => {
                let room = room.plain.get_or_insert_default();
                self.tree.traverse_packet::<MoellerTrumborePacket<true>, _>(rays, &self.blocks, room, &mut any)
            }
        };
        for i in (0..rays.count()).filter(|&i| i >= PACKET || left.contains(i)) {
            if self.occluded::<K>(&rays.ray(i)) {
                found(i);
            }
        }
        left
    }
}

struct Visitor<'a, T, const ANY_HIT: bool> {
    blocks: &'a [TriangleBlock],
    test: T,
    best: Option<TriangleHit>,
}

impl<'a, T: BlockTest, const ANY_HIT: bool> LeafVisitor for Visitor<'a, T, ANY_HIT> {
    type Source = &'a Triangles;
    /// Whether there is a hit, and unless any will do the closest.
    type Found = (bool, Option<TriangleHit>);
    const ANY_HIT: bool = ANY_HIT;

    #[inline(always)]
    fn new(source: &'a Triangles, ray: &Ray) -> Self {
        Self { blocks: &source.blocks, test: T::new(ray, source.tree.extent()), best: None }
    }

    #[inline(always)]
    fn visit<L: Lanes>(&mut self, lanes: L, block: u32, t_max: &mut f64) -> bool {
        let block = &self.blocks[block as usize];
        let mut candidates = self.test.candidates(lanes, block);
        while candidates != 0 {
            let lane = candidates.trailing_zeros() as usize;
            candidates &= candidates - 1;
            let Some((t, u, v)) = self.test.decide(lanes, block, lane, *t_max) else { continue };
            if ANY_HIT {
                return true;
            }
            // Branches: selections instead made every later node wait for the division, 1 to 6 % slower.
            let triangle = block.ids[lane & 7];
            if t < *t_max || self.best.is_none_or(|b| triangle < b.triangle) {
                self.best = Some(TriangleHit { t, triangle, u, v });
                *t_max = t;
                self.test.shorten(t);
            }
        }
        false
    }

    #[inline(always)]
    fn found(self, ended: bool) -> Self::Found {
        (ended, self.best)
    }
}

/// A ray against blocks of triangles: candidates eight at a time, decisions one by one.
pub trait BlockTest {
    /// Prepares a ray for triangles whose coordinates are at most `extent` in magnitude.
    fn new(ray: &Ray, extent: f64) -> Self;

    /// The lanes that `decide` has to look at, a bit each: all that it might accept, and few others.
    fn candidates<L: Lanes>(&mut self, lanes: L, block: &TriangleBlock) -> u32;

    /// (t, u, v) of the hit with a lane's triangle, if there is one with t_min < t <= `t_max`.
    fn decide<L: Lanes>(&self, lanes: L, block: &TriangleBlock, lane: usize, t_max: f64) -> Option<(f64, f64, f64)>;

    /// Tells that hits beyond `t_max` do not count any more.
    fn shorten(&mut self, t_max: f64);
}

/// The watertight f64 test alone, for every triangle: the yardstick.
pub struct PlainWoopTest(TriangleRay);

impl BlockTest for PlainWoopTest {
    #[inline(always)]
    fn new(ray: &Ray, _extent: f64) -> Self {
        Self(TriangleRay::new(ray))
    }

    #[inline(always)]
    fn candidates<L: Lanes>(&mut self, _lanes: L, block: &TriangleBlock) -> u32 {
        (0..8).filter(|&lane| block.ids[lane] != EMPTY_SLOT).map(|lane| 1 << lane).sum()
    }

    #[inline(always)]
    fn decide<L: Lanes>(&self, lanes: L, block: &TriangleBlock, lane: usize, t_max: f64) -> Option<(f64, f64, f64)> {
        self.0.intersect_corners(block.triangle(lanes, lane, self.0.axes), t_max)
    }

    #[inline(always)]
    fn shorten(&mut self, _t_max: f64) {}
}

/// f32 candidates with a proven bound, decided by the watertight f64 test: the same hits as [`PlainWoopTest`], bit for
/// bit (robust-leaf.md, design A with the slack of each lane).
///
/// To let f32 with a proven depth decide here too, as in packets, and to find t once at the end, lost: 1.5 % less time
/// for shadow rays, but 1 to 9 % more for the others (interior and blobs100k).
///
/// With u = 2^-24, R the extent, L <= 2R the size of a triangle, S = (dx/dz, dy/dz) and c = S oz - o in f64: a corner
/// is sheared as a = (v - S vz) + c. Rounding: slope uR, product uR (none if fused), difference 2uR, c 2uR (if the
/// triangle holds the ray, |c| <= 2R), sum 2uL <= 4uR, and the f64 test's own 2^-50(|o| + R) < 0.2uR while |o| <= 1e7
/// R: together less than d = 13uR. An edge function cx by - cy bx of coordinates of magnitude at most M is then off by
/// at most 4dM + 2d², and by 4u(M + d)² of rounding (3u if fused); with M <= 2L + d <= 4R + d that is less than M(4d +
/// 16uR) + 6d².
pub struct WatertightTest {
    exact: TriangleRay,
    slope: [f32; 2],
    offset: [f32; 2],
    slack: [f32; 2],
    /// Lanes that are candidates in any case: all of them where the bound does not hold.
    always: u32,
    /// Coordinates along the largest axis at t_min and at t_max, rounded outward.
    start: f32,
    end: f32,
    /// `end` comes from here, in steps of `direction_z`.
    end_from: f64,
    direction_z: f64,
}

impl BlockTest for WatertightTest {
    #[inline(always)]
    fn new(ray: &Ray, extent: f64) -> Self {
        let exact = TriangleRay::new(ray);
        let ([ox, oy, oz], [sx, sy, _]) = (exact.origin, exact.shear);
        let u = 1.0 / 16_777_216.0;
        let d = 13.0 * u * extent;
        let origin_size = ray.origin.abs().max_element();
        // Beyond 1e7 extents the bound does not hold, and f32 products overflow and underflow beyond these: every lane
        // goes to the f64 test.
        let holds = (origin_size <= 1e7 * extent) & (1e-15..=1e15).contains(&extent);
        let direction_z = ray.direction.to_array()[exact.axes[2]];
        // Rounding of t dz and of the sum, and to f32 of what is not beyond the tree. What is beyond it stays there.
        let pad = (8e-15 * (oz.abs() + extent) + 1.3e-7 * extent).copysign(direction_z);
        let mut test = Self {
            slope: [sx as f32, sy as f32],
            offset: [(sx * oz - ox) as f32, (sy * oz - oy) as f32],
            slack: [((4.0 * d + 16.0 * u * extent) * 1.001) as f32, (6.0 * d * d * 1.001) as f32],
            always: if holds { 0 } else { 0xff },
            start: (oz - pad + ray.t_min * direction_z) as f32,
            end: 0.0,
            end_from: oz + pad,
            direction_z,
            exact,
        };
        test.shorten(ray.t_max);
        test
    }

    #[inline(always)]
    fn candidates<L: Lanes>(&mut self, lanes: L, block: &TriangleBlock) -> u32 {
        let [kx, ky, kz] = self.exact.axes;
        let coordinate = |corner: usize, axis: usize| lanes.load(&block.corners[corner][axis]);
        let (sx, sy) = (lanes.splat(self.slope[0]), lanes.splat(self.slope[1]));
        let (ox, oy) = (lanes.splat(self.offset[0]), lanes.splat(self.offset[1]));
        let (z0, z1, z2) = (coordinate(0, kz), coordinate(1, kz), coordinate(2, kz));
        let ax = lanes.add(lanes.neg_mul_add(z0, sx, coordinate(0, kx)), ox);
        let bx = lanes.add(lanes.neg_mul_add(z1, sx, coordinate(1, kx)), ox);
        let cx = lanes.add(lanes.neg_mul_add(z2, sx, coordinate(2, kx)), ox);
        let ay = lanes.add(lanes.neg_mul_add(z0, sy, coordinate(0, ky)), oy);
        let by = lanes.add(lanes.neg_mul_add(z1, sy, coordinate(1, ky)), oy);
        let cy = lanes.add(lanes.neg_mul_add(z2, sy, coordinate(2, ky)), oy);
        let u = lanes.mul_sub(cx, by, lanes.mul(cy, bx));
        let v = lanes.mul_sub(ax, cy, lanes.mul(ay, cx));
        let w = lanes.mul_sub(bx, ay, lanes.mul(by, ax));
        let low = lanes.min(lanes.min(u, v), w);
        let high = lanes.max(lanes.max(u, v), w);
        let size_a = lanes.max_unsigned(lanes.abs(ax), lanes.abs(ay));
        let size_b = lanes.max_unsigned(lanes.abs(bx), lanes.abs(by));
        let size_c = lanes.max_unsigned(lanes.abs(cx), lanes.abs(cy));
        let size = lanes.max_unsigned(lanes.max_unsigned(size_a, size_b), size_c);
        let (factor, least) = (lanes.splat(self.slack[0]), lanes.splat(self.slack[1]));
        let slack = lanes.mul_add(size, factor, least);
        let minus = lanes.neg_mul_add(size, factor, lanes.splat(-self.slack[1]));
        let inside = lanes.or(lanes.le(minus, low), lanes.le(high, slack));
        let z_min = lanes.min(lanes.min(z0, z1), z2);
        let z_max = lanes.max(lanes.max(z0, z1), z2);
        let (start, end) = (lanes.splat(self.start), lanes.splat(self.end));
        let above = lanes.le(lanes.min(start, end), z_max);
        let below = lanes.le(z_min, lanes.max(start, end));
        lanes.bits(lanes.and(inside, lanes.and(above, below))) | self.always
    }

    #[inline(always)]
    fn decide<L: Lanes>(&self, lanes: L, block: &TriangleBlock, lane: usize, t_max: f64) -> Option<(f64, f64, f64)> {
        self.exact.intersect_corners(block.triangle(lanes, lane, self.exact.axes), t_max)
    }

    #[inline(always)]
    fn shorten(&mut self, t_max: f64) {
        self.end = (self.end_from + t_max * self.direction_z) as f32;
    }
}

/// Möller and Trumbore (1997) in f32, eight at a time, without fused operations, so that every instruction set gives
/// the same bits (fused ones would take 1 to 7 % less time a ray). `CLASSIC`: determinants up to 1e-6 are taken for
/// parallel.
pub struct MoellerTrumboreTest<const CLASSIC: bool> {
    origin: [f32; 3],
    direction: [f32; 3],
    t_min: f64,
    /// No hit that counts is before or beyond these.
    bounds: [f32; 2],
    t: [f32; 8],
    u: [f32; 8],
    v: [f32; 8],
}

impl<const CLASSIC: bool> BlockTest for MoellerTrumboreTest<CLASSIC> {
    #[inline(always)]
    fn new(ray: &Ray, _extent: f64) -> Self {
        let (origin, direction) = (ray.origin.as_vec3().into(), ray.direction.as_vec3().into());
        let bounds = [(ray.t_min * (1.0 - WIDER)) as f32, (ray.t_max * (1.0 + WIDER)) as f32];
        Self { origin, direction, t_min: ray.t_min, bounds, t: [0.0; 8], u: [0.0; 8], v: [0.0; 8] }
    }

    /// Divides only where something is hit: u, v and t are compared times the determinant. To leave out t where no u
    /// and v are inside gained nothing.
    #[inline(always)]
    fn candidates<L: Lanes>(&mut self, lanes: L, block: &TriangleBlock) -> u32 {
        let corner = |corner: usize| Triple::load(lanes, &block.corners[corner]);
        let (a, b, c) = (corner(0), corner(1), corner(2));
        let (o, d) = (Triple::splat(lanes, self.origin), Triple::splat(lanes, self.direction));
        let (e1, e2) = (b.sub(lanes, a), c.sub(lanes, a));
        let p = d.cross(lanes, e2);
        let det = e1.dot(lanes, p);
        let s = o.sub(lanes, a);
        let q = s.cross(lanes, e1);
        let u = lanes.mul_sign(s.dot(lanes, p), det);
        let v = lanes.mul_sign(d.dot(lanes, q), det);
        let t = lanes.mul_sign(e2.dot(lanes, q), det);
        let det = lanes.abs(det);
        let zero = lanes.splat(0.0);
        let least = if CLASSIC { 1e-6f32.next_up() } else { f32::from_bits(1) };
        let met = lanes.and(
            lanes.and(lanes.le(zero, lanes.min(u, v)), lanes.le(lanes.add(u, v), det)),
            lanes.and(
                lanes.le(lanes.splat(least), det),
                lanes.and(
                    lanes.le(lanes.mul(det, lanes.splat(self.bounds[0])), t),
                    lanes.le(t, lanes.mul(det, lanes.splat(self.bounds[1]))),
                ),
            ),
        );
        let met = lanes.bits(met);
        if met != 0 {
            let inverse = lanes.div(lanes.splat(1.0), det);
            self.t = lanes.store(lanes.mul(t, inverse));
            self.u = lanes.store(lanes.mul(u, inverse));
            self.v = lanes.store(lanes.mul(v, inverse));
        }
        met
    }

    #[inline(always)]
    fn decide<L: Lanes>(&self, _: L, _: &TriangleBlock, lane: usize, t_max: f64) -> Option<(f64, f64, f64)> {
        let t = f64::from(self.t[lane & 7]);
        (t > self.t_min && t <= t_max).then(|| (t, f64::from(self.u[lane & 7]), f64::from(self.v[lane & 7])))
    }

    #[inline(always)]
    fn shorten(&mut self, t_max: f64) {
        self.bounds[1] = (t_max * (1.0 + WIDER)) as f32;
    }
}

/// The bounds of t are wider by this than the ray, since t is rounded otherwise where it is compared times the
/// determinant.
const WIDER: f64 = 1.0 / 1_048_576.0;

/// Three coordinates in lanes.
#[derive(Clone, Copy)]
struct Triple<V>(V, V, V);

impl<V: Copy> Triple<V> {
    #[inline(always)]
    fn load<L: Lanes<V = V>>(lanes: L, [x, y, z]: &[[f32; 8]; 3]) -> Self {
        Self(lanes.load(x), lanes.load(y), lanes.load(z))
    }
    #[inline(always)]
    fn splat<L: Lanes<V = V>>(lanes: L, [x, y, z]: [f32; 3]) -> Self {
        Self(lanes.splat(x), lanes.splat(y), lanes.splat(z))
    }
    #[inline(always)]
    fn sub<L: Lanes<V = V>>(self, lanes: L, o: Self) -> Self {
        Self(lanes.sub(self.0, o.0), lanes.sub(self.1, o.1), lanes.sub(self.2, o.2))
    }
    #[inline(always)]
    fn dot<L: Lanes<V = V>>(self, lanes: L, o: Self) -> V {
        lanes.add(lanes.add(lanes.mul(self.0, o.0), lanes.mul(self.1, o.1)), lanes.mul(self.2, o.2))
    }
    #[inline(always)]
    fn cross<L: Lanes<V = V>>(self, lanes: L, o: Self) -> Self {
        let term = |a: V, b: V, c: V, d: V| lanes.sub(lanes.mul(a, b), lanes.mul(c, d));
        Self(term(self.1, o.2, self.2, o.1), term(self.2, o.0, self.0, o.2), term(self.0, o.1, self.1, o.0))
    }
}
