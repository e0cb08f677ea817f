//! Four f64 at a time.

use glam::DVec4;
use std::ops::{Add, Div, Mul, Sub};

/// Four f64 that are computed with together: a vector of plain numbers, or a register where the processor has one
/// (`bvh::simd`). Every operation is rounded alike in all of them.
pub trait Four:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Mul<f64, Output = Self> + Div<Output = Self>
{
    /// The same number four times.
    fn splat(self, v: f64) -> Self;
    /// |self|
    fn abs(self) -> Self;
    /// The larger ones; `other` where one is NaN.
    fn max(self, other: Self) -> Self;
    /// The magnitudes of `self` with the signs of `sign`.
    fn copysign(self, sign: Self) -> Self;
    /// Rounded to nearest.
    fn as_f32(self) -> [f32; 4];
    /// The second, the third, the first and the fourth.
    fn yzxw(self) -> Self;
    /// The third, the first, the second and the fourth.
    fn zxyw(self) -> Self;
    /// Which are below zero, a bit each, the first lowest.
    fn negative(self) -> u32;
    /// Which are above zero.
    fn positive(self) -> u32;
    /// The four numbers.
    fn to_array(self) -> [f64; 4];
}

impl Four for DVec4 {
    #[inline(always)]
    fn splat(self, v: f64) -> Self {
        DVec4::splat(v)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        DVec4::abs(self)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        DVec4::select(self.cmpgt(other), self, other)
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        DVec4::copysign(self, sign)
    }
    #[inline(always)]
    fn as_f32(self) -> [f32; 4] {
        DVec4::to_array(&self).map(|v| v as f32)
    }
    #[inline(always)]
    fn yzxw(self) -> Self {
        DVec4::new(self.y, self.z, self.x, self.w)
    }
    #[inline(always)]
    fn zxyw(self) -> Self {
        DVec4::new(self.z, self.x, self.y, self.w)
    }
    #[inline(always)]
    fn negative(self) -> u32 {
        self.cmplt(DVec4::ZERO).bitmask()
    }
    #[inline(always)]
    fn positive(self) -> u32 {
        self.cmpgt(DVec4::ZERO).bitmask()
    }
    #[inline(always)]
    fn to_array(self) -> [f64; 4] {
        DVec4::to_array(&self)
    }
}
