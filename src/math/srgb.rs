//! The exact sRGB transfer curve (IEC 61966-2-1), both ways.

use std::sync::LazyLock;

/// sRGB-encoded value in 0..=1 to linear.
pub fn srgb_to_linear(v: f64) -> f64 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// Linear to sRGB-encoded, 0..=1, clamped. NaN gives 0.
pub fn linear_to_srgb(v: f64) -> f64 {
    let v = if v > 0.0 { v.min(1.0) } else { 0.0 };
    if v <= 0.0031308 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// 8-bit codes for a unit of linear light in black, where the curve is steepest.
pub const STEEPEST: f64 = 255.0 * 12.92;

/// The linear value of each 8-bit code.
static DECODE: LazyLock<[f64; 256]> = LazyLock::new(|| std::array::from_fn(|c| srgb_to_linear(c as f64 / 255.0)));

/// `THRESHOLD[c]` is the smallest linear value whose code is above `c`: the curve at (c + 1/2) / 255. Comparing with
/// these rounds the exact curve half up without evaluating a power per pixel.
static THRESHOLD: LazyLock<[f64; 255]> =
    LazyLock::new(|| std::array::from_fn(|c| srgb_to_linear((c as f64 + 0.5) / 255.0)));

/// Segments an octave and octaves of [`CURVE`], which ends at 1: 2^-9 is on the straight part of the curve.
const SEGMENT_BITS: u32 = 6;
const OCTAVES: usize = 9;

/// Bits of an f64 below those that number a segment, and the number of the first.
const BELOW: u32 = f64::MANTISSA_DIGITS - 1 - SEGMENT_BITS;
const FIRST: u64 = (1023 - OCTAVES as u64) << SEGMENT_BITS;

/// The exact curve where its segments meet.
static CURVE: LazyLock<[f64; (OCTAVES << SEGMENT_BITS) + 2]> =
    LazyLock::new(|| std::array::from_fn(|i| linear_to_srgb(f64::from_bits((FIRST + i as u64) << BELOW))));

/// As [`linear_to_srgb`] within 1e-5 (0.003 codes), without evaluating a power: for telling how wrong pixels are.
pub fn linear_to_srgb_near(v: f64) -> f64 {
    if v <= 0.0031308 || v.is_nan() {
        return 12.92 * v.max(0.0);
    }
    let bits = v.min(1.0).to_bits();
    let at = ((bits >> BELOW) - FIRST) as usize;
    let part = (bits & ((1 << BELOW) - 1)) as f64 / (1u64 << BELOW) as f64;
    CURVE[at] + part * (CURVE[at + 1] - CURVE[at])
}

/// As [`linear_to_srgb`] within 5e-5 (0.0125 codes), its slope within 1 %, by square roots alone: a loop over many
/// numbers becomes vector code. (Weighted least squares of the curve by v and its roots.)
#[inline]
pub fn linear_to_srgb_by_roots(v: f32) -> f32 {
    let v = if v > 0.0 { v } else { 0.0 };
    let v = if v < 1.0 { v } else { 1.0 };
    let second = v.sqrt();
    let fourth = second.sqrt();
    let curve = 0.642_417_3 * second + 0.712_051_45 * fourth - 0.336_845_46 * fourth.sqrt() - 0.017_580_585 * v;
    if v <= 0.0031308 { 12.92 * v } else { curve }
}

/// As [`srgb_to_linear`] of 256ths of 8-bit codes within 1e-5, without evaluating a power.
pub fn srgb_to_linear_near(code: u16) -> f64 {
    let (at, part) = (code as usize >> 8, f64::from(code & 255) / 256.0);
    DECODE[at] + part * (DECODE[(at + 1).min(255)] - DECODE[at])
}

/// 8-bit sRGB code to linear.
pub fn srgb8_to_linear(code: u8) -> f64 {
    srgb8_table()[code as usize]
}

/// The linear value of each 8-bit sRGB code: whoever looks up many asks only once whether the table is made.
pub fn srgb8_table() -> &'static [f64; 256] {
    &DECODE
}

/// Linear value to the nearest 8-bit sRGB code, half up, clamped. NaN gives 0.
pub fn linear_to_srgb8(v: f64) -> u8 {
    THRESHOLD.partition_point(|&t| t <= v) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_survives_decoding_and_encoding() {
        for c in 0..=255 {
            assert_eq!(linear_to_srgb8(srgb8_to_linear(c)), c);
        }
    }

    #[test]
    fn the_two_curves_are_inverse_to_each_other() {
        for i in 0..=1000 {
            let v = f64::from(i) / 1000.0;
            assert!((linear_to_srgb(srgb_to_linear(v)) - v).abs() < 1e-6, "at {v}");
        }
        assert_eq!([-1.0, f64::NAN].map(linear_to_srgb), [0.0, 0.0]);
        assert!((linear_to_srgb(2.0) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn what_takes_no_power_is_near_the_curves() {
        for i in 0..=100_000 {
            let v = (f64::from(i) / 90_000.0).powi(3) - 0.001;
            let (near, exact) = (linear_to_srgb_near(v), linear_to_srgb(v));
            assert!((near - exact).abs() <= 1e-5, "at {v}: {near}, {exact}");
        }
        assert_eq!([-1.0, f64::NAN].map(linear_to_srgb_near), [0.0, 0.0]);
        for i in 0..=100_000 {
            let v = (f64::from(i) / 90_000.0).powi(3) - 0.001;
            let (near, exact) = (linear_to_srgb_by_roots(v as f32), linear_to_srgb(v));
            assert!((f64::from(near) - exact).abs() <= 5e-5, "at {v}: {near}, {exact}");
        }
        assert_eq!([-1.0, f32::NAN].map(linear_to_srgb_by_roots), [0.0, 0.0]);
        assert!((linear_to_srgb_by_roots(f32::INFINITY) - 1.0).abs() < 5e-5);
        assert!((linear_to_srgb_near(f64::INFINITY) - 1.0).abs() < 1e-15);
        for code in 0..=65280 {
            let (near, exact) = (srgb_to_linear_near(code), srgb_to_linear(f64::from(code) / 65280.0));
            assert!((near - exact).abs() <= 1e-5, "at {code}: {near}, {exact}");
        }
    }

    #[test]
    fn encoding_rounds_the_curve_half_up_and_clamps() {
        let curve = |v: f64| if v <= 0.0031308 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
        for i in 0..=200_000 {
            let v = i as f64 / 190_000.0 - 0.02;
            let exact = curve(v).clamp(0.0, 1.0) * 255.0;
            // Within rounding of a half-way point either neighbour is right.
            if (exact.fract() - 0.5).abs() > 1e-9 {
                assert_eq!(linear_to_srgb8(v), exact.round() as u8, "at {v}");
            }
        }
        assert_eq!(linear_to_srgb8(f64::NAN), 0);
        assert_eq!(linear_to_srgb8(f64::INFINITY), 255);
        assert_eq!(linear_to_srgb8(f64::NEG_INFINITY), 0);
    }
}
