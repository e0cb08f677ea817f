//! Vectors of as many f32 as an instruction set has lanes, for packets: a lane a ray, or a lane a triangle.

use super::Lanes;
use super::packet::PACKET;

/// One number a ray of a packet.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Row(pub [f32; PACKET]);

impl Default for Row {
    fn default() -> Self {
        Self::ZERO
    }
}

impl Row {
    /// Nothing but zeros.
    pub const ZERO: Self = Self([0.0; PACKET]);

    /// Those of the group of rays that starts at this place. (Functions in place of closures, which may not be
    /// inlined.)
    #[inline(always)]
    pub fn group<W: Wide>(&self, w: W, at: usize) -> W::V {
        w.load(&self.0[at..])
    }

    /// That of one ray, in all lanes.
    #[inline(always)]
    pub fn one<W: Wide>(&self, w: W, ray: usize) -> W::V {
        w.splat(self.0[ray & (PACKET - 1)])
    }
}

/// Those of a group of rays, by axis.
#[inline(always)]
pub fn of_group<W: Wide>(w: W, [x, y, z]: &[Row; 3], at: usize) -> [W::V; 3] {
    [x.group(w, at), y.group(w, at), z.group(w, at)]
}

/// Those of one ray, by axis, each in all lanes.
#[inline(always)]
pub fn ones<W: Wide>(w: W, [x, y, z]: &[Row; 3], ray: usize) -> [W::V; 3] {
    [x.one(w, ray), y.one(w, ray), z.one(w, ray)]
}

/// As [`Lanes`](super::Lanes), of any width; what lanes are compared for comes as bits, lane 0 lowest. Comparisons are
/// false for NaN.
pub trait Wide: Copy {
    /// How many lanes; divides [`PACKET`].
    const LANES: usize;
    /// So many f32.
    type V: Copy;
    /// The same value in every lane.
    fn splat(self, v: f32) -> Self::V;
    /// The first numbers of a slice of at least so many.
    fn load(self, v: &[f32]) -> Self::V;
    /// To the first places of a slice of at least so many.
    fn store(self, v: Self::V, to: &mut [f32]);
    /// a + b
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    /// a - b
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    /// a b
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    /// a / b
    fn div(self, a: Self::V, b: Self::V) -> Self::V;
    /// a b + c, rounded once or twice
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// a b - c, rounded once or twice
    fn mul_sub(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// c - a b, rounded once or twice
    fn neg_mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// The smaller; `b` if either is NaN
    fn min(self, a: Self::V, b: Self::V) -> Self::V;
    /// The larger; `b` if either is NaN
    fn max(self, a: Self::V, b: Self::V) -> Self::V;
    /// |a|
    fn abs(self, a: Self::V) -> Self::V;
    /// a, with its sign changed where b has a minus sign
    fn mul_sign(self, a: Self::V, b: Self::V) -> Self::V;
    /// Lanes where a <= b
    fn le(self, a: Self::V, b: Self::V) -> u32;
    /// Lanes where a < b
    fn lt(self, a: Self::V, b: Self::V) -> u32;
    /// `a` in the lanes of `mask`, else `b`
    fn select(self, mask: u32, a: Self::V, b: Self::V) -> Self::V;

    /// The smallest and the largest of all lanes. A NaN may or may not show.
    #[inline(always)]
    fn ends(self, low: Self::V, high: Self::V) -> [f32; 2] {
        let (mut a, mut b) = ([0.0; 16], [0.0; 16]);
        self.store(low, &mut a);
        self.store(high, &mut b);
        let mut half = Self::LANES / 2;
        while half > 0 {
            for k in 0..half {
                a[k] = if a[k] < a[k + half] { a[k] } else { a[k + half] };
                b[k] = if b[k] > b[k + half] { b[k] } else { b[k + half] };
            }
            half /= 2;
        }
        [a[0], b[0]]
    }
}

/// Forwards to [`Lanes`](super::Lanes) of eight.
macro_rules! eight {
    ($type:ty) => {
        impl Wide for $type {
            const LANES: usize = 8;
            type V = <$type as Lanes>::V;
            #[inline(always)]
            fn splat(self, v: f32) -> Self::V {
                Lanes::splat(self, v)
            }
            #[inline(always)]
            fn load(self, v: &[f32]) -> Self::V {
                Lanes::load(self, v.first_chunk().expect("eight"))
            }
            #[inline(always)]
            fn store(self, v: Self::V, to: &mut [f32]) {
                *to.first_chunk_mut().expect("eight") = Lanes::store(self, v);
            }
            eight!(two: add sub mul div min max mul_sign);
            eight!(three: mul_add mul_sub neg_mul_add);
            #[inline(always)]
            fn abs(self, a: Self::V) -> Self::V {
                Lanes::abs(self, a)
            }
            #[inline(always)]
            fn le(self, a: Self::V, b: Self::V) -> u32 {
                Lanes::bits(self, Lanes::le(self, a, b))
            }
            #[inline(always)]
            fn lt(self, a: Self::V, b: Self::V) -> u32 {
                self.less(a, b)
            }
            #[inline(always)]
            fn select(self, mask: u32, a: Self::V, b: Self::V) -> Self::V {
                self.choose(mask, a, b)
            }
        }
    };
    (two: $($op:ident)*) => {$(
        #[inline(always)]
        fn $op(self, a: Self::V, b: Self::V) -> Self::V {
            Lanes::$op(self, a, b)
        }
    )*};
    (three: $($op:ident)*) => {$(
        #[inline(always)]
        fn $op(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V {
            Lanes::$op(self, a, b, c)
        }
    )*};
}

eight!(super::Portable);

impl super::Portable {
    #[inline(always)]
    fn less(self, a: [f32; 8], b: [f32; 8]) -> u32 {
        let mut mask = 0;
        for k in 0..8 {
            mask |= u32::from(a[k] < b[k]) << k;
        }
        mask
    }

    #[inline(always)]
    fn choose(self, mask: u32, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        let mut v = b;
        for k in 0..8 {
            v[k] = if mask >> k & 1 != 0 { a[k] } else { b[k] };
        }
        v
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Lanes, Wide};
    use crate::bvh::simd::x86::Avx2;
    use std::arch::x86_64::*;

    /// Calls an intrinsic inside of a method of `Avx2` or `Avx512`.
    macro_rules! avx {
        ($call:expr) => {
            // SAFETY: an `Avx2` or `Avx512` is made only where the processor has the instructions (see their `new`).
            unsafe { $call }
        };
    }

    eight!(Avx2);

    impl Avx2 {
        #[inline(always)]
        fn less(self, a: __m256, b: __m256) -> u32 {
            avx!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)) as u32)
        }

        #[inline(always)]
        fn choose(self, mask: u32, a: __m256, b: __m256) -> __m256 {
            avx!({
                let lanes = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
                let chosen = _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(mask as i32), lanes), lanes);
                _mm256_blendv_ps(b, a, _mm256_castsi256_ps(chosen))
            })
        }
    }

    /// AVX-512 F, VL, DQ and BW.
    #[derive(Clone, Copy, Debug)]
    pub struct Avx512(());

    impl Avx512 {
        /// # Safety
        /// The processor has what [`Isa::Avx512`](crate::bvh::Isa::Avx512) names.
        #[inline(always)]
        pub unsafe fn new() -> Self {
            Self(())
        }
    }

    impl Wide for Avx512 {
        const LANES: usize = 16;
        type V = __m512;
        #[inline(always)]
        fn splat(self, v: f32) -> __m512 {
            avx!(_mm512_set1_ps(v))
        }
        #[inline(always)]
        fn load(self, v: &[f32]) -> __m512 {
            let v: &[f32; 16] = v.first_chunk().expect("sixteen");
            avx!(_mm512_loadu_ps(v.as_ptr()))
        }
        #[inline(always)]
        fn store(self, v: __m512, to: &mut [f32]) {
            let to: &mut [f32; 16] = to.first_chunk_mut().expect("sixteen");
            avx!(_mm512_storeu_ps(to.as_mut_ptr(), v));
        }
        #[inline(always)]
        fn add(self, a: __m512, b: __m512) -> __m512 {
            avx!(_mm512_add_ps(a, b))
        }
        #[inline(always)]
        fn sub(self, a: __m512, b: __m512) -> __m512 {
            avx!(_mm512_sub_ps(a, b))
        }
        #[inline(always)]
        fn mul(self, a: __m512, b: __m512) -> __m512 {
            avx!(_mm512_mul_ps(a, b))
        }
        #[inline(always)]
        fn div(self, a: __m512, b: __m512) -> __m512 {
            avx!(_mm512_div_ps(a, b))
        }
        #[inline(always)]
        fn mul_add(self, a: __m512, b: __m512, c: __m512) -> __m512 {
            avx!(_mm512_fmadd_ps(a, b, c))
        }
        #[inline(always)]
        fn mul_sub(self, a: __m512, b: __m512, c: __m512) -> __m512 {
            avx!(_mm512_fmsub_ps(a, b, c))
        }
        #[inline(always)]
        fn neg_mul_add(self, a: __m512, b: __m512, c: __m512) -> __m512 {
            avx!(_mm512_fnmadd_ps(a, b, c))
        }
        #[inline(always)]
        fn min(self, a: __m512, b: __m512) -> __m512 {
            avx!(_mm512_min_ps(a, b))
        }
        #[inline(always)]
        fn max(self, a: __m512, b: __m512) -> __m512 {
            avx!(_mm512_max_ps(a, b))
        }
        #[inline(always)]
        fn abs(self, a: __m512) -> __m512 {
            avx!(_mm512_abs_ps(a))
        }
        #[inline(always)]
        fn mul_sign(self, a: __m512, b: __m512) -> __m512 {
            avx!(_mm512_xor_ps(a, _mm512_and_ps(b, _mm512_set1_ps(-0.0))))
        }
        #[inline(always)]
        fn le(self, a: __m512, b: __m512) -> u32 {
            avx!(u32::from(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b)))
        }
        #[inline(always)]
        fn lt(self, a: __m512, b: __m512) -> u32 {
            avx!(u32::from(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b)))
        }
        #[inline(always)]
        fn select(self, mask: u32, a: __m512, b: __m512) -> __m512 {
            avx!(_mm512_mask_blend_ps(mask as u16, b, a))
        }
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use x86::Avx512;

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::super::x86::Avx2;
    use super::super::{Isa, Portable};
    use super::*;
    use crate::math::SplitMix64;

    /// What each operation makes of 16 numbers a row, by vectors of any width.
    fn results<W: Wide>(w: W, [a, b, c]: &[[f32; 16]; 3]) -> Vec<u32> {
        let mut all = vec![];
        let (mut low, mut high) = (w.splat(f32::MAX), w.splat(f32::MIN));
        for at in (0..16).step_by(W::LANES) {
            let (x, y, z) = (w.load(&a[at..]), w.load(&b[at..]), w.load(&c[at..]));
            let masks = [w.le(x, y), w.lt(x, y), w.le(y, y)];
            let values = [
                [w.add(x, y), w.sub(x, y), w.mul(x, y), w.div(x, y), w.min(x, y), w.max(x, y)],
                [w.abs(x), w.mul_sign(x, y), w.select(masks[0], x, z), w.select(masks[1], y, x), x, w.splat(a[0])],
            ];
            (low, high) = (w.min(z, low), w.max(z, high));
            for lane in 0..W::LANES {
                let bits = masks.iter().map(|mask| mask >> lane & 1);
                let stored = values.iter().flatten().map(|v| {
                    let mut to = [0.0; 16];
                    w.store(*v, &mut to);
                    // One NaN is as good as another.
                    if to[lane].is_nan() { u32::MAX } else { to[lane].to_bits() }
                });
                all.extend(bits.chain(stored));
            }
        }
        all.extend(w.ends(low, high).map(f32::to_bits));
        all
    }

    #[test]
    fn vectors_of_every_width_do_what_plain_rust_does() {
        let mut rng = SplitMix64(36);
        for _ in 0..2_000 {
            let odd = [f32::NAN, f32::INFINITY, 0.0, -0.0, 1.0];
            let mut number = || match rng.next_u64() % 8 {
                0 => odd[(rng.next_u64() % 5) as usize],
                _ => rng.range(-2.0, 2.0) as f32,
            };
            let [a, b] = [(); 2].map(|()| [0.0; 16].map(|_: f32| number()));
            let c = [0.0; 16].map(|_: f32| rng.range(-2.0, 2.0) as f32);
            let expected = results(Portable, &[a, b, c]);
            if Isa::Avx2.is_available() {
                // SAFETY: the processor has it.
                assert_eq!(results(unsafe { Avx2::new() }, &[a, b, c]), expected);
            }
            if Isa::Avx512.is_available() {
                // SAFETY: the processor has it.
                assert_eq!(results(unsafe { Avx512::new() }, &[a, b, c]), expected);
            }
        }
    }
}
