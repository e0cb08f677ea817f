//! Angles of points.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// The angle of the point (x, y) about the origin, -π to π, counted from the x axis to the y axis, within 3 ulp,
/// without branches and calls, so that loops over it become vector code.
///
/// As IEEE 754 wants it where a coordinate is zero, signs included: 0 for (0, 0), ±π where x is -0. For coordinates up
/// to half of the largest number; NaN where one is NaN or both are infinite.
///
/// The tangent of an angle up to π/4 is the quotient of the smaller by the larger coordinate; above tan π/8 it is
/// turned by π/4 with the numbers that are divided, so that a single quotient remains. For |t| <= tan π/8 is artan t =
/// t + t³ P(t²), P minimax, off by 2^-54.
#[inline(always)]
pub fn atan2(y: f64, x: f64) -> f64 {
    /// tan π/8
    const TURNED: f64 = 0.414_213_562_373_095_05;
    let (width, height) = (x.abs(), y.abs());
    let steep = height > width;
    let (small, large) = if steep { (width, height) } else { (height, width) };
    let turned = small > TURNED * large;
    let above = if turned { small - large } else { small };
    let below = if turned { small + large } else { large };
    let t = above / if large == 0.0 { 1.0 } else { below };
    let z = t * t;
    let (z2, z4) = (z * z, z * z * (z * z));
    let first = (-0.333_333_333_333_302_2 + z * 0.199_999_999_991_046_76)
        + z2 * (-0.142_857_141_965_271_52 + z * 0.111_111_067_035_588_79);
    let second = (-0.090_907_835_283_059_61 + z * 0.076_900_833_466_905_86)
        + z2 * (-0.066_412_461_557_501_4 + z * 0.056_931_642_431_409_37);
    let third = -0.043_608_236_085_051_9 + z * 0.021_280_118_874_233_86;
    let angle = t + t * (z * (first + z4 * (second + z4 * third)));
    // From here on the angle grows, and with it what may be wrong.
    let angle = if turned { FRAC_PI_4 + angle } else { angle };
    let angle = if steep { FRAC_PI_2 - angle } else { angle };
    let angle = if x.is_sign_negative() { PI - angle } else { angle };
    angle.copysign(y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SplitMix64;

    /// Against the library's, which is within 1 ulp.
    fn check(y: f64, x: f64) {
        let (angle, exact) = (atan2(y, x), y.atan2(x));
        let ulp = exact.abs().next_up() - exact.abs();
        assert!((angle - exact).abs() <= 4.0 * ulp, "{y}, {x}: {angle}, {exact}");
        assert_eq!(angle.is_sign_negative(), exact.is_sign_negative(), "{y}, {x}: {angle}, {exact}");
    }

    #[test]
    fn angles_are_those_of_the_library_within_4_ulp() {
        let mut random = SplitMix64(6);
        for i in 0..2_000_000 {
            let angle = random.range(-PI, PI);
            check(angle.sin(), angle.cos());
            // Beside the axes, the diagonals and where the tangent is turned.
            let beside = 10f64.powf(random.range(-18.0, 0.0));
            let angle = FRAC_PI_4 / 2.0 * f64::from(i % 32 - 16) + beside;
            let length = 10f64.powf(random.range(-140.0, 140.0));
            check(length * angle.sin(), length * angle.cos());
            check(beside, length);
            check(length, -beside);
        }
    }

    #[test]
    fn axes_and_zeros_have_the_angles_of_the_library() {
        let all = [0.0, -0.0, 1.0, -1.0, 5e-324, -5e-324, 1e307, -1e307];
        for (y, x) in all.iter().flat_map(|y| all.map(|x| (*y, x))) {
            let (angle, exact) = (atan2(y, x), y.atan2(x));
            assert_eq!(angle.to_bits(), exact.to_bits(), "{y}, {x}: {angle}, {exact}");
        }
        for angle in [atan2(f64::NAN, 1.0), atan2(1.0, f64::NAN), atan2(f64::NAN, 0.0), atan2(0.0, f64::NAN)] {
            assert!(angle.is_nan());
        }
    }
}
