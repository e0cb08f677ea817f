//! Colour, hashing, sample sequences, powers, angles and affine transforms: arithmetic that knows nothing of scenes.

mod affine;
mod angle;
mod four;
mod hash;
mod power;
mod rgb;
mod sobol;
mod srgb;

pub use affine::Affine;
pub use angle::atan2;
pub use four::Four;
pub use hash::{SplitMix64, hash_pixel, lowbias32};
pub use power::pow;
pub use rgb::Rgb;
pub use sobol::{sample_in_pixel, tent};
pub use srgb::{
    STEEPEST, linear_to_srgb, linear_to_srgb_by_roots, linear_to_srgb_near, linear_to_srgb8, srgb_to_linear,
    srgb_to_linear_near, srgb8_table, srgb8_to_linear,
};

/// The largest whole number that is not above `x`. What the standard library has is a call on the base instruction set
/// of x86-64: with it a frame of the demo took 1 to 2 % longer.
#[inline(always)]
pub fn floor(x: f64) -> f64 {
    /// From here on all numbers are whole. NaN is returned, too.
    const WHOLE: f64 = (1u64 << 52) as f64;
    if x.abs() < WHOLE {
        // Added, it leaves no room for a fraction: rounded to the nearest without the way through whole numbers, which
        // takes twice as long.
        let near = (x.abs() + WHOLE - WHOLE).copysign(x);
        near - if near > x { 1.0 } else { 0.0 }
    } else {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floor_is_that_of_the_library() {
        let mut random = SplitMix64(5);
        let scaled = (0..100_000).map(|i| random.range(-1.0, 1.0) * 2f64.powi(i % 80 - 20));
        let whole = (-1000..1000).map(f64::from);
        let beside = (-1000..1000).flat_map(|i| [f64::from(i).next_up(), f64::from(i).next_down()]);
        for x in scaled.chain(whole).chain(beside).chain([f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN]) {
            assert_eq!(floor(x), x.floor(), "{x}");
        }
        assert!(floor(f64::NAN).is_nan());
    }
}
