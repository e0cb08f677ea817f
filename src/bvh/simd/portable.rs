//! Lanes as arrays: any processor, and the twin that the others are tested against.

use super::Lanes;
use glam::DVec4;

/// Plain Rust.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

macro_rules! map {
    ($a:ident, $b:ident, $f:expr) => {{
        let f = $f;
        [
            f($a[0], $b[0]),
            f($a[1], $b[1]),
            f($a[2], $b[2]),
            f($a[3], $b[3]),
            f($a[4], $b[4]),
            f($a[5], $b[5]),
            f($a[6], $b[6]),
            f($a[7], $b[7]),
        ]
    }};
}

impl Lanes for Portable {
    type V = [f32; 8];
    /// A bit a lane.
    type M = u32;
    type F = DVec4;

    #[inline(always)]
    fn splat(self, v: f32) -> [f32; 8] {
        [v; 8]
    }
    #[inline(always)]
    fn four(self, v: [f64; 4]) -> DVec4 {
        DVec4::from_array(v)
    }
    #[inline(always)]
    fn widened(self, v: [f32; 4]) -> DVec4 {
        DVec4::from_array(v.map(f64::from))
    }
    #[inline(always)]
    fn splat3(self, [x, y, z, _]: [f32; 4]) -> [[f32; 8]; 3] {
        [[x; 8], [y; 8], [z; 8]]
    }
    #[inline(always)]
    fn load(self, v: &[f32; 8]) -> [f32; 8] {
        *v
    }
    #[inline(always)]
    fn store(self, v: [f32; 8]) -> [f32; 8] {
        v
    }
    #[inline(always)]
    fn add(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        map!(a, b, |a: f32, b: f32| a + b)
    }
    #[inline(always)]
    fn sub(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        map!(a, b, |a: f32, b: f32| a - b)
    }
    #[inline(always)]
    fn mul(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        map!(a, b, |a: f32, b: f32| a * b)
    }
    #[inline(always)]
    fn div(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        map!(a, b, |a: f32, b: f32| a / b)
    }
    #[inline(always)]
    fn mul_add(self, a: [f32; 8], b: [f32; 8], c: [f32; 8]) -> [f32; 8] {
        self.add(self.mul(a, b), c)
    }
    #[inline(always)]
    fn mul_sub(self, a: [f32; 8], b: [f32; 8], c: [f32; 8]) -> [f32; 8] {
        self.sub(self.mul(a, b), c)
    }
    #[inline(always)]
    fn neg_mul_add(self, a: [f32; 8], b: [f32; 8], c: [f32; 8]) -> [f32; 8] {
        self.sub(c, self.mul(a, b))
    }
    #[inline(always)]
    fn min(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        map!(a, b, |a: f32, b: f32| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        map!(a, b, |a: f32, b: f32| if a > b { a } else { b })
    }
    #[inline(always)]
    fn max_unsigned(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        map!(a, b, |a: f32, b: f32| f32::from_bits(a.to_bits().max(b.to_bits())))
    }
    #[inline(always)]
    fn abs(self, a: [f32; 8]) -> [f32; 8] {
        map!(a, a, |a: f32, _: f32| a.abs())
    }
    #[inline(always)]
    fn mul_sign(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        map!(a, b, |a: f32, b: f32| f32::from_bits(a.to_bits() ^ (b.to_bits() & (1 << 31))))
    }
    #[inline(always)]
    fn le(self, a: [f32; 8], b: [f32; 8]) -> u32 {
        let bits = map!(a, b, |a: f32, b: f32| u32::from(a <= b));
        let mut mask = 0;
        let mut k = 0;
        while k < 8 {
            mask |= bits[k] << k;
            k += 1;
        }
        mask
    }
    #[inline(always)]
    fn and(self, a: u32, b: u32) -> u32 {
        a & b
    }
    #[inline(always)]
    fn or(self, a: u32, b: u32) -> u32 {
        a | b
    }
    #[inline(always)]
    fn bits(self, m: u32) -> u32 {
        m
    }
}
