//! Boxes of primitives, and the bins that they are sorted into to find a cut.

use super::Isa;
use super::simd::add;
use crate::geometry::Aabb;
use glam::Vec3;

/// Bins along an axis.
pub const BINS: usize = 16;

/// A box in eight lanes: the lower corner, a spare lane, the negated upper corner, a spare lane. So the box of two
/// boxes is one minimum.
pub type LaneBox = [f32; 8];

/// Contains nothing.
pub const EMPTY_BOX: LaneBox = [f32::INFINITY; 8];

/// A primitive's box, moved as a whole so that every pass over a range reads memory in order; its index is in the first
/// spare lane.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
pub struct PrimRef(pub LaneBox);

impl PrimRef {
    /// The box of primitive `index`.
    pub fn new(Aabb { lower, upper }: Aabb, index: u32) -> Self {
        Self([lower.x, lower.y, lower.z, f32::from_bits(index), -upper.x, -upper.y, -upper.z, 0.0])
    }

    /// Which primitive it is.
    #[inline(always)]
    pub fn index(&self) -> u32 {
        self.0[3].to_bits()
    }

    /// Twice the centre along an axis.
    #[inline(always)]
    pub fn centre(&self, axis: usize) -> f32 {
        self.0[axis] - self.0[axis + 4]
    }
}

/// The box of both.
#[inline(always)]
pub fn union(a: &LaneBox, b: &LaneBox) -> LaneBox {
    let mut out = *a;
    for k in 0..8 {
        out[k] = if b[k] < a[k] { b[k] } else { a[k] };
    }
    out
}

/// The box as corners.
pub fn aabb(b: &LaneBox) -> Aabb {
    Aabb { lower: Vec3::new(b[0], b[1], b[2]), upper: -Vec3::new(b[4], b[5], b[6]) }
}

/// Half the surface of a box that is not empty.
#[inline(always)]
pub fn half_area(b: &LaneBox) -> f32 {
    // All three are the negative of the size.
    let (x, y, z) = (b[0] + b[4], b[1] + b[5], b[2] + b[6]);
    x * y + y * z + z * x
}

/// Maps doubled centres to bins.
#[derive(Clone, Copy)]
pub struct Grid {
    lower: [f32; 3],
    scale: [f32; 3],
}

/// Added to a number from 0 to 16, leaves its whole part from the ninth bit on: conversions of floats to integers
/// saturate in Rust, which costs more than the rest of a bin's number.
const SHIFTER: f32 = 49_152.0;

impl Grid {
    /// Over doubled centres from `lower` on, `size` wide. An axis without extent gets all its primitives into bin 0.
    pub fn new(lower: [f32; 3], size: [f32; 3]) -> Self {
        // A little less than 16, for the rounding of the shifter.
        let scale = |size: f32| if size > 0.0 { (15.99 / size).min(f32::MAX) } else { 0.0 };
        Self { lower, scale: size.map(scale) }
    }

    /// The bin of a primitive along an axis.
    #[inline(always)]
    pub fn bin(&self, p: &PrimRef, axis: usize) -> usize {
        let place = (p.centre(axis) - self.lower[axis]) * self.scale[axis];
        ((place + SHIFTER).to_bits() >> 8) as usize % BINS
    }
}

/// Boxes and counts of the primitives in each bin, along all three axes.
#[derive(Clone)]
pub struct Bins {
    /// Box of each bin; spare lanes mean nothing.
    pub boxes: [[LaneBox; BINS]; 3],
    /// Primitives in each bin.
    pub counts: [[u32; BINS]; 3],
}

impl Bins {
    /// Puts primitives into bins.
    pub fn of(refs: &[PrimRef], grid: &Grid, isa: Isa) -> Self {
        let mut bins = Self { boxes: [[EMPTY_BOX; BINS]; 3], counts: [[0; BINS]; 3] };
        add(&mut bins, refs, grid, isa);
        bins
    }

    /// Adds what is in other bins.
    pub fn join(&mut self, other: &Self) {
        for axis in 0..3 {
            for k in 0..BINS {
                self.boxes[axis][k] = union(&self.boxes[axis][k], &other.boxes[axis][k]);
                self.counts[axis][k] += other.counts[axis][k];
            }
        }
    }
}
