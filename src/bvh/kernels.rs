//! The presets of arithmetic, as far as trees are concerned.

use super::simd::Lanes;
use super::triangles::{BlockTest, MoellerTrumboreTest, PlainWoopTest, WatertightTest};
use crate::geometry::{Classic, Fast, Kernels, PaddedSlab, PlainSlab, Reference, Robust, Slab, WideSlab};

/// Kernels for boxes and blocks of triangles that belong to a preset.
pub trait TreeKernels: Kernels {
    /// Boxes of eight children.
    type Boxes: BoxTest;
    /// Blocks of eight triangles.
    type Triangles: BlockTest;
}

impl TreeKernels for Robust {
    type Boxes = PaddedSlab;
    type Triangles = WatertightTest;
}

impl TreeKernels for Reference {
    type Boxes = WideSlab;
    type Triangles = PlainWoopTest;
}

impl TreeKernels for Fast {
    type Boxes = PlainSlab;
    type Triangles = MoellerTrumboreTest<false>;
}

impl TreeKernels for Classic {
    type Boxes = PlainSlab;
    type Triangles = MoellerTrumboreTest<true>;
}

/// A ray against the boxes of eight children at once. Every lane does what [`Slab::entry`] does for one box.
pub trait BoxTest: Slab {
    /// The ray's numbers, spread over lanes.
    type Prepared<L: Lanes>: Copy;

    /// Spreads the ray over lanes.
    fn prepare<L: Lanes>(&self, lanes: L) -> Self::Prepared<L>;

    /// Which boxes the ray meets up to `limit`, a bit each, and where it enters them.
    fn entries<L: Lanes>(
        &self,
        lanes: L,
        prepared: &Self::Prepared<L>,
        planes: &[[f32; 8]; 6],
        limit: f32,
    ) -> (u32, L::V);
}

/// Reciprocal direction, constants of the near and the far planes, and t_min, spread over lanes; which rows of planes are near
/// and which far.
#[derive(Clone, Copy)]
pub struct SlabLanes<L: Lanes> {
    reciprocal: [L::V; 3],
    near: [L::V; 3],
    far: [L::V; 3],
    t_min: L::V,
    near_rows: [usize; 3],
    far_rows: [usize; 3],
}

impl<L: Lanes> SlabLanes<L> {
    #[inline(always)]
    fn new(lanes: L, reciprocal: [f32; 3], near: [f32; 3], far: [f32; 3], t_min: f32) -> Self {
        let negative = [reciprocal[0] < 0.0, reciprocal[1] < 0.0, reciprocal[2] < 0.0];
        let row = |axis: usize, upper: bool| axis + 3 * usize::from(upper);
        let spread = |v: [f32; 3]| [lanes.splat(v[0]), lanes.splat(v[1]), lanes.splat(v[2])];
        Self {
            reciprocal: spread(reciprocal),
            near: spread(near),
            far: spread(far),
            t_min: lanes.splat(t_min),
            near_rows: [row(0, negative[0]), row(1, negative[1]), row(2, negative[2])],
            far_rows: [row(0, !negative[0]), row(1, !negative[1]), row(2, !negative[2])],
        }
    }

    /// plane * reciprocal - constant, the largest of the near and the smallest of the far ones. `min` and `max` return their
    /// second argument where the first is NaN, so a NaN (from overflow) bounds nothing.
    #[inline(always)]
    fn entries(&self, lanes: L, planes: &[[f32; 8]; 6], limit: f32) -> (u32, L::V) {
        let near = |k: usize| lanes.mul_sub(lanes.load(&planes[self.near_rows[k]]), self.reciprocal[k], self.near[k]);
        let far = |k: usize| lanes.mul_sub(lanes.load(&planes[self.far_rows[k]]), self.reciprocal[k], self.far[k]);
        let enter = lanes.max(near(2), lanes.max(near(1), lanes.max(near(0), self.t_min)));
        let exit = lanes.min(far(2), lanes.min(far(1), lanes.min(far(0), lanes.splat(limit))));
        (lanes.le(enter, exit), enter)
    }
}

impl BoxTest for PaddedSlab {
    type Prepared<L: Lanes> = SlabLanes<L>;

    #[inline(always)]
    fn prepare<L: Lanes>(&self, lanes: L) -> SlabLanes<L> {
        SlabLanes::new(lanes, self.reciprocal, self.near, self.far, self.t_min)
    }
    #[inline(always)]
    fn entries<L: Lanes>(&self, lanes: L, p: &SlabLanes<L>, planes: &[[f32; 8]; 6], limit: f32) -> (u32, L::V) {
        p.entries(lanes, planes, limit)
    }
}

impl BoxTest for PlainSlab {
    type Prepared<L: Lanes> = SlabLanes<L>;

    #[inline(always)]
    fn prepare<L: Lanes>(&self, lanes: L) -> SlabLanes<L> {
        SlabLanes::new(lanes, self.reciprocal, self.offset, self.offset, self.t_min)
    }
    #[inline(always)]
    fn entries<L: Lanes>(&self, lanes: L, p: &SlabLanes<L>, planes: &[[f32; 8]; 6], limit: f32) -> (u32, L::V) {
        p.entries(lanes, planes, limit)
    }
}

impl BoxTest for WideSlab {
    type Prepared<L: Lanes> = ();

    #[inline(always)]
    fn prepare<L: Lanes>(&self, _lanes: L) {}
    /// One by one, in f64: the yardstick need not be fast.
    #[inline(always)]
    fn entries<L: Lanes>(&self, lanes: L, (): &(), planes: &[[f32; 8]; 6], limit: f32) -> (u32, L::V) {
        let (mut mask, mut distances) = (0, [0.0; 8]);
        for k in 0..8 {
            let bounds = crate::geometry::Aabb {
                lower: glam::Vec3::new(planes[0][k], planes[1][k], planes[2][k]),
                upper: glam::Vec3::new(planes[3][k], planes[4][k], planes[5][k]),
            };
            if let Some(entry) = self.entry(&bounds, limit) {
                mask |= 1 << k;
                distances[k] = entry;
            }
        }
        (mask, lanes.load(&distances))
    }
}
