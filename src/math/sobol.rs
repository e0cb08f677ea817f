//! Sample positions inside a pixel.

use super::hash::{hash_pixel, lowbias32};

/// Position of sample `index` in pixel (x, y), in [0, 1)²; sample 0 is the pixel's centre.
///
/// The first two dimensions of Sobol' form a (0,2) sequence: every prefix of 2^k samples puts one into each of the 2^k
/// elementary intervals of any shape. They are Owen-scrambled by hashing (Laine and Karras 2011 in the form of Burley,
/// "Practical Hash-based Owen Scrambling", JCGT 9(4) 2020), with a seed a pixel. A digital shift then moves sample 0 to
/// the centre: it permutes elementary intervals, so the stratification is untouched, and one sample a pixel is exactly
/// the pixel centre that closed forms speak of. Half of the pixels have their centre at the upper end of its interval,
/// half at the lower, in either direction: the mean over pixels is that of the square.
///
/// The position depends on the pixel and the index alone, so any order of tracing gives the same picture. No branches:
/// loops over samples become vector code.
#[inline(always)]
pub fn sample_in_pixel(x: u32, y: u32, index: u32) -> (f64, f64) {
    let seed = hash_pixel(x, y);
    let (seed_u, seed_v) = (lowbias32(seed ^ 0x68bc_21eb), lowbias32(seed ^ 0x02e5_be93));
    // Of index 0 nothing remains but the shift, which may be to just below the centre.
    let place = |v: u32, seed: u32| {
        let shifted = (scramble(v, seed) ^ scramble(0, seed)).reverse_bits() ^ centre_of(seed);
        f64::from(if index == 0 { 1 << 31 } else { shifted }) / (1u64 << 32) as f64
    };
    (place(sobol_0(index), seed_u), place(sobol_1(index), seed_v))
}

/// Bends a position in 0..1 so that uniform positions get the density of a tent two pixels wide around the middle of
/// the pixel: from -1/2 to 3/2. Importance sampling of the filter: every sample counts the same and stays with its
/// pixel. Of the filters that are better than a box the tent is the one whose inverse is exact, monotone and two square
/// roots, so that elementary intervals stay intervals; it has no negative weights to ring, and the middle stays the
/// middle.
#[inline(always)]
pub fn tent(u: f64) -> f64 {
    let root = (2.0 * if u < 0.5 { u } else { 1.0 - u }).sqrt();
    if u < 0.5 { root - 0.5 } else { 1.5 - root }
}

/// 1/2 or just below it, by a bit of the seed that the scrambling does not depend on in the same way.
#[inline(always)]
fn centre_of(seed: u32) -> u32 {
    if lowbias32(!seed) >> 31 == 0 { 0x8000_0000 } else { 0x7fff_ffff }
}

/// First Sobol' dimension, the lowest bit first: the radical inverse in base 2.
#[inline(always)]
fn sobol_0(index: u32) -> u32 {
    index
}

/// Second Sobol' dimension (primitive polynomial x + 1), the lowest bit first: the direction number of bit k is row k
/// of Pascal's triangle mod 2, which is (1 + x)^k. So it is P(1 + x) where the index is P(x), and that is found by
/// halves: with P = A + x^n B for a power of two n, (1 + x)^n is 1 + x^n.
#[inline(always)]
fn sobol_1(index: u32) -> u32 {
    let mut p = index;
    p ^= p >> 16;
    p ^= (p >> 8) & 0x00ff_00ff;
    p ^= (p >> 4) & 0x0f0f_0f0f;
    p ^= (p >> 2) & 0x3333_3333;
    p ^ ((p >> 1) & 0x5555_5555)
}

/// Nested uniform scrambling: bit k of the result depends on bits 0..=k of the input only, counted from the lowest.
#[inline(always)]
fn scramble(v: u32, seed: u32) -> u32 {
    let mut v = v.wrapping_add(seed);
    v ^= v.wrapping_mul(0x6c50_b47c);
    v ^= v.wrapping_mul(0xb82f_1e52);
    v ^= v.wrapping_mul(0xc7af_e638);
    v ^ v.wrapping_mul(0x8d22_f6e6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SplitMix64;

    #[test]
    fn sample_zero_is_the_pixel_centre() {
        for (x, y) in [(0, 0), (7, 3), (1919, 1079), (u32::MAX, 0)] {
            assert_eq!(sample_in_pixel(x, y, 0), (0.5, 0.5));
        }
    }

    #[test]
    fn the_second_dimension_has_the_rows_of_pascals_triangle() {
        let mut random = SplitMix64(9);
        for i in 0..100_000 {
            let index = if i < 70_000 { i } else { random.next_u64() as u32 };
            let (mut expected, mut row) = (0, 1u32);
            for bit in 0..32 {
                expected ^= if index >> bit & 1 == 1 { row } else { 0 };
                row ^= row << 1;
            }
            assert_eq!(sobol_1(index), expected, "{index}");
        }
    }

    #[test]
    fn positions_are_what_they_always_were() {
        // As the sequence was first written, with a loop over the bits: pictures do not hang on how it is computed.
        let known = [
            ((0, 0, 1), [2_887_891_501, 3_697_760_551]),
            ((5, 3, 2), [223_462_758, 1_491_025_758]),
            ((639, 479, 15), [724_660_810, 1_675_417_292]),
            ((1919, 1079, 1000), [1_740_479_215, 1_505_877_543]),
            ((7, 9, u32::MAX), [2_687_017_259, 2_147_483_649u32]),
        ];
        for ((x, y, index), place) in known {
            let (u, v) = sample_in_pixel(x, y, index);
            assert_eq!([u, v], place.map(|place| f64::from(place) * 2f64.powi(-32)));
        }
    }

    #[test]
    fn the_tent_has_the_density_of_a_tent() {
        // The share of positions left of x is the integral of 1 - |x - 1/2| from -1/2.
        let share = |x: f64| if x < 0.5 { (x + 0.5).powi(2) / 2.0 } else { 1.0 - (1.5 - x).powi(2) / 2.0 };
        for i in 0..=1000 {
            let u = f64::from(i) / 1000.0;
            assert!((share(tent(u)) - u).abs() < 1e-14, "at {u}");
        }
        assert_eq!((tent(0.0), tent(0.5), tent(1.0)), (-0.5, 0.5, 1.5));
    }

    #[test]
    fn every_power_of_two_prefix_fills_all_elementary_intervals_once() {
        for (x, y) in [(0, 0), (5, 9), (639, 479)] {
            for log_n in 0..=8u32 {
                let n = 1u32 << log_n;
                for log_columns in 0..=log_n {
                    let (columns, rows) = (1u32 << log_columns, 1u32 << (log_n - log_columns));
                    let mut seen = vec![false; n as usize];
                    // Sample 0 may stand for the end of the interval below the centre.
                    let (below_u, below_v) = (centre_is_below(x, y).0, centre_is_below(x, y).1);
                    for i in 0..n {
                        let (mut u, mut v) = sample_in_pixel(x, y, i);
                        if i == 0 {
                            u -= if below_u { 1e-9 } else { 0.0 };
                            v -= if below_v { 1e-9 } else { 0.0 };
                        }
                        let cell = (u * f64::from(columns)) as u32 + columns * (v * f64::from(rows)) as u32;
                        assert!(!std::mem::replace(&mut seen[cell as usize], true), "{columns}x{rows} in ({x},{y})");
                    }
                }
            }
        }
    }

    fn centre_is_below(x: u32, y: u32) -> (bool, bool) {
        let seed = hash_pixel(x, y);
        let below = |seed: u32| centre_of(lowbias32(seed)) < 0x8000_0000;
        (below(seed ^ 0x68bc_21eb), below(seed ^ 0x02e5_be93))
    }

    #[test]
    fn the_mean_position_over_many_pixels_is_the_centre_within_five_standard_errors() {
        for n in [2, 4, 16] {
            let pixels = 1 << 14;
            let means: Vec<(f64, f64)> = (0..pixels)
                .map(|p| {
                    let sum = (0..n).fold((0.0, 0.0), |(su, sv), i| {
                        let (u, v) = sample_in_pixel(p % 128, p / 128, i);
                        (su + u, sv + v)
                    });
                    (sum.0 / f64::from(n) - 0.5, sum.1 / f64::from(n) - 0.5)
                })
                .collect();
            for axis in [|m: &(f64, f64)| m.0, |m: &(f64, f64)| m.1] {
                let mean = means.iter().map(axis).sum::<f64>() / f64::from(pixels);
                let variance = means.iter().map(|m| (axis(m) - mean).powi(2)).sum::<f64>() / f64::from(pixels);
                let standard_error = (variance / f64::from(pixels)).sqrt();
                assert!(mean.abs() < 5.0 * standard_error, "{n} samples: {mean} against {standard_error}");
            }
        }
    }
}
