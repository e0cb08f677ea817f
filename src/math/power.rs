//! Powers of cosines.

use std::f64::consts::{FRAC_1_SQRT_2, LOG2_E};

/// ln 2 in two parts. The first ends in 21 zeros: its products with exponents are exact.
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];

/// Bits of an f64 below its exponent.
const MANTISSA: u32 = f64::MANTISSA_DIGITS - 1;

/// x^s for x from [`f64::MIN_POSITIVE`] to 1 and s >= 0, without branches, calls and tables: loops over it become
/// vector code, which the library's `powf` keeps them from. No other x is allowed, NaN neither.
///
/// 1 where x = 1 or s = 0, x where s = 1; powers below 9.8e-301 are 0. With u = 2^-53 the relative error is below
/// (3 + 4 |s ln x|) u: 3 u of ln x and 1 u of the product, where what is wrong with y is the relative error of e^y, and
/// the rest of e^y itself. So it is below 1e-14 down to powers of 1e-9, and less than 1e-23 is wrong with smaller ones.
#[inline(always)]
pub fn pow(x: f64, s: f64) -> f64 {
    let power = exp(s * ln(x));
    if s == 1.0 { x } else { power }
}

/// ln x of a normal x > 0 within 3 u, in the form of fdlibm's `e_log.c` (Sun Microsystems 1993): x = 2^k (1 + f) with
/// 1 + f in [√½, √2), and with r = f / (2 + f) is ln (1 + f) = 2 artanh r = f - f²/2 + r (f²/2 + R(r²)). What is
/// rounded before the last sum stands in terms of a quarter of the size at most. R is minimax, off by 2^-58.
#[inline(always)]
fn ln(x: f64) -> f64 {
    const ONE: u64 = 1f64.to_bits();
    const LOWEST: u64 = FRAC_1_SQRT_2.to_bits();
    const EXACT: f64 = (1u64 << MANTISSA) as f64;
    // √½ is moved to 1: above the mantissa stands the exponent of x, then, and below how far on it is.
    let moved = x.to_bits().wrapping_add(ONE - LOWEST);
    let f = f64::from_bits((moved & ((1 << MANTISSA) - 1)) + LOWEST) - 1.0;
    // Not every instruction set converts whole numbers of 64 bits: put into the mantissa of 2^52, they are added to it.
    let k = f64::from_bits((moved >> MANTISSA) | EXACT.to_bits()) - (EXACT + 1023.0);
    let r = f / (2.0 + f);
    let z = r * r;
    let z2 = z * z;
    let lower = (0.666_666_666_666_673_4 + z * 0.399_999_999_994_146_76)
        + z2 * (0.285_714_287_423_881_2 + z * 0.222_221_985_731_192_95);
    let upper = (0.181_835_643_301_512_14 + z * 0.153_140_504_342_658_16) + z2 * 0.147_959_510_131_139_12;
    let half_square = 0.5 * f * f;
    let rest = r * (half_square + z * (lower + z2 * z2 * upper));
    k * LN_2[0] + (f - (half_square - (rest + k * LN_2[1])))
}

/// e^y for y <= 0 within 2 u, 0 below y = -690.8: y = n ln 2 + r with |r| <= ln 2 / 2, where e^r is minimax, off by
/// 2^-57, and n is added to the exponent.
#[inline(always)]
fn exp(y: f64) -> f64 {
    const LEAST: f64 = -690.8;
    /// Added, it leaves the nearest whole number in the lowest bits.
    const WHOLE: f64 = (3u64 << (MANTISSA - 1)) as f64;
    let within = if y > LEAST { y } else { LEAST };
    let whole = within * LOG2_E + WHOLE;
    let n = whole - WHOLE;
    let r = (within - n * LN_2[0]) - n * LN_2[1];
    let (r2, r4) = (r * r, r * r * (r * r));
    let first = (0.500_000_000_000_001_1 + r * 0.166_666_666_666_664_13)
        + r2 * (0.041_666_666_666_530_27 + r * 0.008_333_333_333_493_442);
    let second = (0.001_388_888_894_359_8 + r * 0.000_198_412_695_067_615_2)
        + r2 * (2.480_149_313_582_919_8e-5 + r * 2.755_758_628_275_414_2e-6);
    let third = 2.763_023_406_020_366e-7 + r * 2.500_006_713_429_732_2e-8;
    let near_one = 1.0 + (r + r2 * (first + r4 * (second + r4 * third)));
    let power = f64::from_bits(near_one.to_bits().wrapping_add(whole.to_bits() << MANTISSA));
    if y > LEAST { power } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SplitMix64;

    const U: f64 = f64::EPSILON / 2.0;

    /// Against the library's power, which is within 2 u itself.
    fn check(x: f64, s: f64) {
        let (power, exact) = (pow(x, s), x.powf(s));
        let (wrong, y) = ((power - exact).abs(), (s * x.ln()).abs());
        if exact < 1e-300 {
            assert!((0.0..1e-300).contains(&power), "{x}^{s}: {power}, {exact}");
            return;
        }
        assert!(wrong <= (5.0 + 4.0 * y) * U * exact, "{x}^{s}: {power}, {exact}");
        assert!(wrong <= if exact > 1e-9 { 1e-14 * exact } else { 1e-23 }, "{x}^{s}: {power}, {exact}");
    }

    #[test]
    fn powers_are_those_of_the_library_within_the_stated_bound() {
        let mut random = SplitMix64(3);
        for _ in 0..1_000_000 {
            // Any cosine with the shininess that a scene may have.
            check(1.0 - random.unit(), 10f64.powf(random.range(-3.0, 6.0)));
            // Beside 1, where large powers are not small.
            check(1.0 - 10f64.powf(random.range(-16.0, -1.0)), 10f64.powf(random.range(0.0, 6.0)));
            // Small cosines, to the least one, and powers of all sizes.
            let x = 10f64.powf(random.range(-307.6, 0.0));
            check(x, random.range(0.0, 720.0) / -x.ln());
        }
        for k in 0..1100 {
            for beside in [1.0, 1.0 + f64::EPSILON, 1.0 - f64::EPSILON, FRAC_1_SQRT_2, FRAC_1_SQRT_2.next_down()] {
                let x = (beside * 0.5f64.powi(k)).clamp(f64::MIN_POSITIVE, 1.0);
                for s in [0.0, 1e-300, 0.5, 1.0, 2.0, 3.0, 1e6] {
                    check(x, s);
                }
            }
        }
    }

    #[test]
    fn powers_of_one_and_with_0_and_1_are_exact() {
        let mut random = SplitMix64(4);
        for _ in 0..10_000 {
            let x = random.unit().max(f64::MIN_POSITIVE);
            assert_eq!((pow(x, 0.0), pow(x, 1.0), pow(1.0, 1e6 * x)), (1.0, x, 1.0));
        }
        assert_eq!((pow(f64::MIN_POSITIVE, 1e6), pow(0.5, 1e6), pow(0.5, 1100.0)), (0.0, 0.0, 0.0));
        // Exact as well: no part of a power of two is lost.
        assert_eq!((pow(0.25, 0.5), pow(0.5, 10.0)), (0.5, 0.5f64.powi(10)));
    }
}
