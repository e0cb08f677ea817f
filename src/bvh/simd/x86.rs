//! Lanes as AVX registers.

use super::Lanes;
use crate::math::Four;
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

/// AVX2 and FMA. Compiled again with AVX-512VL enabled, where the compiler has more registers and mask instructions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2(());

impl Avx2 {
    /// # Safety
    /// The processor has what [`Isa::Avx2`](super::Isa::Avx2) names.
    #[inline(always)]
    pub unsafe fn new() -> Self {
        Self(())
    }
}

/// Calls an intrinsic inside of an `Avx2` method.
macro_rules! avx {
    ($call:expr) => {
        // SAFETY: an `Avx2` is made only where the processor has the instructions (`Avx2::new`).
        unsafe { $call }
    };
}

impl Lanes for Avx2 {
    type V = __m256;
    type M = __m256;
    type F = Avx2Four;

    #[inline(always)]
    fn splat(self, v: f32) -> __m256 {
        avx!(_mm256_set1_ps(v))
    }
    #[inline(always)]
    fn four(self, [a, b, c, d]: [f64; 4]) -> Avx2Four {
        Avx2Four(avx!(_mm256_setr_pd(a, b, c, d)))
    }
    #[inline(always)]
    fn widened(self, [a, b, c, d]: [f32; 4]) -> Avx2Four {
        Avx2Four(avx!(_mm256_cvtps_pd(_mm_setr_ps(a, b, c, d))))
    }
    #[inline(always)]
    fn splat3(self, v: [f32; 4]) -> [__m256; 3] {
        // SAFETY: see `avx`.
        unsafe {
            let v = _mm_loadu_ps(v.as_ptr());
            let (y, z) = (_mm_movehdup_ps(v), _mm_movehl_ps(v, v));
            [_mm256_broadcastss_ps(v), _mm256_broadcastss_ps(y), _mm256_broadcastss_ps(z)]
        }
    }
    #[inline(always)]
    fn load(self, v: &[f32; 8]) -> __m256 {
        avx!(_mm256_loadu_ps(v.as_ptr()))
    }
    #[inline(always)]
    fn store(self, v: __m256) -> [f32; 8] {
        let mut out = [0.0; 8];
        avx!(_mm256_storeu_ps(out.as_mut_ptr(), v));
        out
    }
    #[inline(always)]
    fn add(self, a: __m256, b: __m256) -> __m256 {
        avx!(_mm256_add_ps(a, b))
    }
    #[inline(always)]
    fn sub(self, a: __m256, b: __m256) -> __m256 {
        avx!(_mm256_sub_ps(a, b))
    }
    #[inline(always)]
    fn mul(self, a: __m256, b: __m256) -> __m256 {
        avx!(_mm256_mul_ps(a, b))
    }
    #[inline(always)]
    fn div(self, a: __m256, b: __m256) -> __m256 {
        avx!(_mm256_div_ps(a, b))
    }
    #[inline(always)]
    fn mul_add(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        avx!(_mm256_fmadd_ps(a, b, c))
    }
    #[inline(always)]
    fn mul_sub(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        avx!(_mm256_fmsub_ps(a, b, c))
    }
    #[inline(always)]
    fn neg_mul_add(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        avx!(_mm256_fnmadd_ps(a, b, c))
    }
    #[inline(always)]
    fn min(self, a: __m256, b: __m256) -> __m256 {
        avx!(_mm256_min_ps(a, b))
    }
    #[inline(always)]
    fn max(self, a: __m256, b: __m256) -> __m256 {
        avx!(_mm256_max_ps(a, b))
    }
    #[inline(always)]
    fn max_unsigned(self, a: __m256, b: __m256) -> __m256 {
        // Compares as whole numbers, which takes one cycle instead of four.
        avx!(_mm256_castsi256_ps(_mm256_max_epu32(_mm256_castps_si256(a), _mm256_castps_si256(b))))
    }
    #[inline(always)]
    fn abs(self, a: __m256) -> __m256 {
        avx!(_mm256_andnot_ps(_mm256_set1_ps(-0.0), a))
    }
    #[inline(always)]
    fn mul_sign(self, a: __m256, b: __m256) -> __m256 {
        avx!(_mm256_xor_ps(a, _mm256_and_ps(b, _mm256_set1_ps(-0.0))))
    }
    #[inline(always)]
    fn le(self, a: __m256, b: __m256) -> __m256 {
        avx!(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b))
    }
    #[inline(always)]
    fn and(self, a: __m256, b: __m256) -> __m256 {
        avx!(_mm256_and_ps(a, b))
    }
    #[inline(always)]
    fn or(self, a: __m256, b: __m256) -> __m256 {
        avx!(_mm256_or_ps(a, b))
    }
    #[inline(always)]
    fn bits(self, m: __m256) -> u32 {
        avx!(_mm256_movemask_ps(m) as u32)
    }
}

/// Four f64 in a register. Made by an [`Avx2`] only, and so also proof of the instructions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2Four(__m256d);

macro_rules! operator {
    ($operator:ident, $method:ident, $intrinsic:ident) => {
        impl $operator for Avx2Four {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(avx!($intrinsic(self.0, other.0)))
            }
        }
    };
}
operator!(Add, add, _mm256_add_pd);
operator!(Sub, sub, _mm256_sub_pd);
operator!(Mul, mul, _mm256_mul_pd);
operator!(Div, div, _mm256_div_pd);

impl Mul<f64> for Avx2Four {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self * self.splat(factor)
    }
}

impl Four for Avx2Four {
    #[inline(always)]
    fn splat(self, v: f64) -> Self {
        Self(avx!(_mm256_set1_pd(v)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(avx!(_mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(avx!(_mm256_max_pd(self.0, other.0)))
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Self(avx!(_mm256_or_pd(self.abs().0, _mm256_and_pd(_mm256_set1_pd(-0.0), sign.0))))
    }
    #[inline(always)]
    fn as_f32(self) -> [f32; 4] {
        let mut out = [0.0; 4];
        avx!(_mm_storeu_ps(out.as_mut_ptr(), _mm256_cvtpd_ps(self.0)));
        out
    }
    #[inline(always)]
    fn yzxw(self) -> Self {
        Self(avx!(_mm256_permute4x64_pd::<0b11_00_10_01>(self.0)))
    }
    #[inline(always)]
    fn zxyw(self) -> Self {
        Self(avx!(_mm256_permute4x64_pd::<0b11_01_00_10>(self.0)))
    }
    #[inline(always)]
    fn negative(self) -> u32 {
        avx!(_mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(self.0, _mm256_setzero_pd())) as u32)
    }
    #[inline(always)]
    fn positive(self) -> u32 {
        avx!(_mm256_movemask_pd(_mm256_cmp_pd::<_CMP_GT_OQ>(self.0, _mm256_setzero_pd())) as u32)
    }
    #[inline(always)]
    fn to_array(self) -> [f64; 4] {
        let mut out = [0.0; 4];
        avx!(_mm256_storeu_pd(out.as_mut_ptr(), self.0));
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::{Isa, simd::Portable};
    use crate::math::SplitMix64;

    /// Everything that four f64 can do, as bits.
    fn results<F: Four>(a: F, b: F) -> Vec<u64> {
        let fours =
            [a + b, a - b, a * b, a / b, a * 3.7, a.splat(2.3), a.abs(), a.max(b), a.copysign(b), a.yzxw(), a.zxyw()];
        let bits = |v: F| v.to_array().map(f64::to_bits);
        let narrow = a.as_f32().map(|v| u64::from(v.to_bits()));
        let masks = [u64::from(a.negative()), u64::from(a.positive())];
        fours.into_iter().flat_map(bits).chain(narrow).chain(masks).collect()
    }

    /// What is made of four numbers, and of two times eight.
    fn spread<L: Lanes>(lanes: L, v: [f32; 4], a: &[f32; 8], b: &[f32; 8]) -> (Vec<u64>, Vec<u32>) {
        let larger = lanes.max_unsigned(lanes.abs(lanes.load(a)), lanes.abs(lanes.load(b)));
        let eights = lanes.splat3(v).into_iter().chain([larger]).flat_map(|v| lanes.store(v)).map(f32::to_bits);
        (lanes.widened(v).to_array().map(f64::to_bits).to_vec(), eights.collect())
    }

    #[test]
    fn registers_do_what_plain_numbers_do_bit_for_bit() {
        if !Isa::Avx2.is_available() {
            return println!("skipped: this processor has no AVX2");
        }
        // SAFETY: it has.
        let lanes = unsafe { Avx2::new() };
        let mut rng = SplitMix64(91);
        let special = [0.0, -0.0, 1.0, -1.0, f64::INFINITY, f64::NEG_INFINITY, f64::MIN_POSITIVE, f64::MAX, 1e-310];
        for _ in 0..20_000 {
            let mut number = || match rng.next_u64() as usize % 20 {
                k if k < special.len() => special[k],
                _ => rng.range(-1.0, 1.0) * 2f64.powi((rng.next_u64() % 80) as i32 - 40),
            };
            let (a, b) = ([(); 4].map(|()| number()), [(); 4].map(|()| number()));
            // What is not a number has no bits to compare.
            let same = |(x, y): (u64, u64)| x == y || (f64::from_bits(x).is_nan() && f64::from_bits(y).is_nan());
            let (here, there) = (results(lanes.four(a), lanes.four(b)), results(Portable.four(a), Portable.four(b)));
            assert!(here.iter().copied().zip(there.iter().copied()).all(same), "{a:?} {b:?}: {here:x?} {there:x?}");
            let (p, q) = ([(); 8].map(|()| number() as f32), [(); 8].map(|()| number() as f32));
            let v = [p[0], q[1], p[2], q[3]];
            assert_eq!(spread(lanes, v, &p, &q), spread(Portable, v, &p, &q), "{p:?} {q:?}");
        }
    }
}
