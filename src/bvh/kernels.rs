//! The presets of arithmetic, as far as trees are concerned.

use super::simd::{Lanes, SlabLanes};
use super::triangles::{BlockTest, MoellerTrumboreTest, PlainWoopTest, WatertightTest};
use crate::geometry::{Classic, Fast, Kernels, PaddedSlab, PlainSlab, Ray, Reference, Robust, Slab, WideSlab};

/// Kernels for boxes and blocks of triangles that belong to a preset.
pub trait TreeKernels: Kernels {
    /// Boxes of eight children.
    type Boxes: BoxTest;
    /// Blocks of eight triangles.
    type Triangles: BlockTest;
    /// Whether the boxes keep every ray that a shape or triangle inside would accept. What is found does not depend on
    /// the way through the tree then.
    const CONSERVATIVE: bool;
    /// How rays that run alike meet triangles together, if they do.
    const PACKETS: Option<Packets> = None;
}

/// Tests of many rays against triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packets {
    /// What each ray finds alone, to the last bit, but for phantoms (see `WatertightPacket`).
    Watertight,
    /// In f32. A hit counts where it lies in the triangle's box, so that what is found depends on the ray alone; a ray
    /// that is not in a packet may find something else where it grazes.
    MoellerTrumbore,
}

impl TreeKernels for Robust {
    type Boxes = PaddedSlab;
    type Triangles = WatertightTest;
    const CONSERVATIVE: bool = true;
    const PACKETS: Option<Packets> = Some(Packets::Watertight);
}

impl TreeKernels for Reference {
    type Boxes = WideSlab;
    type Triangles = PlainWoopTest;
    const CONSERVATIVE: bool = true;
}

impl TreeKernels for Fast {
    type Boxes = PlainSlab;
    type Triangles = MoellerTrumboreTest<false>;
    const CONSERVATIVE: bool = false;
    const PACKETS: Option<Packets> = Some(Packets::MoellerTrumbore);
}

impl TreeKernels for Classic {
    type Boxes = PlainSlab;
    type Triangles = MoellerTrumboreTest<true>;
    const CONSERVATIVE: bool = false;
}

/// A ray against the boxes of eight children at once. Every lane does what [`Slab::entry`] does for one box.
pub trait BoxTest: Slab {
    /// The ray's numbers, spread over lanes.
    type Prepared<L: Lanes>: Copy;

    /// [`Slab::new`] in registers, where that is quicker. It is for [`PaddedSlab`]: 7 % of robust rays. Neither for
    /// [`PlainSlab`] nor for the ray of the triangle tests.
    #[inline(always)]
    fn of<L: Lanes>(_lanes: L, ray: &Ray, extent: f64) -> Self {
        Self::new(ray, extent)
    }

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

impl BoxTest for PaddedSlab {
    type Prepared<L: Lanes> = SlabLanes<L>;

    #[inline(always)]
    fn of<L: Lanes>(lanes: L, ray: &Ray, extent: f64) -> Self {
        let (o, d) = (ray.origin, ray.direction);
        Self::with(ray, lanes.four([o.x, o.y, o.z, 0.0]), lanes.four([d.x, d.y, d.z, 0.0]), extent)
    }

    #[inline(always)]
    fn prepare<L: Lanes>(&self, lanes: L) -> SlabLanes<L> {
        SlabLanes::new(lanes, [self.near_reciprocal, self.near], [self.reciprocal, self.far], self.t_min)
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
        let [x, y, z] = self.reciprocal;
        let [p, q, r] = self.offset;
        let planes = [[x, y, z, 0.0], [p, q, r, 0.0]];
        SlabLanes::new(lanes, planes, planes, self.t_min)
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
                lower: glam::Vec3::new(planes[0][k], planes[2][k], planes[4][k]),
                upper: glam::Vec3::new(planes[1][k], planes[3][k], planes[5][k]),
            };
            if let Some(entry) = self.entry(&bounds, limit) {
                mask |= 1 << k;
                distances[k] = entry;
            }
        }
        (mask, lanes.load(&distances))
    }
}
