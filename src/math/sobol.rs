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
/// The position depends on the pixel and the index alone, so any order of tracing gives the same picture.
pub fn sample_in_pixel(x: u32, y: u32, index: u32) -> (f64, f64) {
    let seed = hash_pixel(x, y);
    let (seed_u, seed_v) = (lowbias32(seed ^ 0x68bc_21eb), lowbias32(seed ^ 0x02e5_be93));
    if index == 0 {
        return (0.5, 0.5);
    }
    let u = owen_scramble(sobol_0(index), seed_u) ^ owen_scramble(0, seed_u) ^ centre_of(seed_u);
    let v = owen_scramble(sobol_1(index), seed_v) ^ owen_scramble(0, seed_v) ^ centre_of(seed_v);
    let scale = 2f64.powi(-32);
    (f64::from(u) * scale, f64::from(v) * scale)
}

/// Bends a position in 0..1 so that uniform positions get the density of a tent two pixels wide around the middle of
/// the pixel: from -1/2 to 3/2. Importance sampling of the filter: every sample counts the same and stays with its
/// pixel. Of the filters that are better than a box the tent is the one whose inverse is exact, monotone and two square
/// roots, so that elementary intervals stay intervals; it has no negative weights to ring, and the middle stays the
/// middle.
pub fn tent(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 0.5 } else { 1.5 - (2.0 - 2.0 * u).sqrt() }
}

/// 1/2 or just below it, by a bit of the seed that the scrambling does not depend on in the same way.
fn centre_of(seed: u32) -> u32 {
    if lowbias32(!seed) >> 31 == 0 { 0x8000_0000 } else { 0x7fff_ffff }
}

/// First Sobol' dimension: the radical inverse in base 2.
fn sobol_0(index: u32) -> u32 {
    index.reverse_bits()
}

/// Second Sobol' dimension (primitive polynomial x + 1): direction numbers are the rows of Pascal's triangle mod 2.
fn sobol_1(mut index: u32) -> u32 {
    let (mut result, mut direction) = (0, 1u32 << 31);
    while index != 0 {
        if index & 1 != 0 {
            result ^= direction;
        }
        index >>= 1;
        direction ^= direction >> 1;
    }
    result
}

/// Nested uniform scrambling: bit k of the result depends on bits 0..=k of the input only, counted from the top.
fn owen_scramble(v: u32, seed: u32) -> u32 {
    let mut v = v.reverse_bits();
    v = v.wrapping_add(seed);
    v ^= v.wrapping_mul(0x6c50_b47c);
    v ^= v.wrapping_mul(0xb82f_1e52);
    v ^= v.wrapping_mul(0xc7af_e638);
    v ^= v.wrapping_mul(0x8d22_f6e6);
    v.reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sample_zero_is_the_pixel_centre() {
        for (x, y) in [(0, 0), (7, 3), (1919, 1079), (u32::MAX, 0)] {
            assert_eq!(sample_in_pixel(x, y, 0), (0.5, 0.5));
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
