//! Double-double arithmetic: the yardstick of the kernels. A number is the unevaluated sum of two f64, good for 31
//! digits (Dekker 1971; Hida, Li, Bailey, "Algorithms for Quad-Double Precision Floating Point Arithmetic", 2001).

use glam::DVec3;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// `high + low`, |low| at most half a unit in the last place of `high`. Relative error of every operation below 2^-102.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Dd {
    high: f64,
    low: f64,
}

/// a + b and its rounding error.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

/// a b and its rounding error, by Dekker's splitting: without fused operations the same on every machine.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let split = |a: f64| {
        let c = 134_217_729.0 * a; // 2^27 + 1
        let high = c - (c - a);
        (high, a - high)
    };
    let product = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    (product, ((ah * bh - product) + ah * bl + al * bh) + al * bl)
}

impl Dd {
    /// 0
    pub const ZERO: Dd = Dd { high: 0.0, low: 0.0 };
    /// 1
    pub const ONE: Dd = Dd { high: 1.0, low: 0.0 };
    /// Beyond every number.
    pub const INFINITY: Dd = Dd { high: f64::INFINITY, low: 0.0 };

    /// The nearest f64.
    pub fn to_f64(self) -> f64 {
        self.high + self.low
    }

    /// Its square root; 0 for what is below 0.
    pub fn sqrt(self) -> Self {
        if self.high <= 0.0 {
            return Self::ZERO;
        }
        // One step of Newton's from the f64 root doubles its digits.
        let root = Self::from(self.high.sqrt());
        root + (self - root * root) / Self::from(2.0 * root.high)
    }

    /// |x|
    pub fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }

    fn normalised(high: f64, low: f64) -> Self {
        let sum = high + low;
        if sum.is_finite() { Self { high: sum, low: low - (sum - high) } } else { Self { high: sum, low: 0.0 } }
    }
}

impl From<f64> for Dd {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for Dd {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        let (high, error) = two_sum(self.high, o.high);
        let (low, of_low) = two_sum(self.low, o.low);
        let Self { high, low } = Self::normalised(high, error + low);
        Self::normalised(high, low + of_low)
    }
}

impl Neg for Dd {
    type Output = Self;
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for Dd {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl Mul for Dd {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let (product, error) = two_product(self.high, o.high);
        Self::normalised(product, error + (self.high * o.low + self.low * o.high))
    }
}

impl Div for Dd {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let first = self.high / o.high;
        let rest = self - o * Self::from(first);
        let second = rest.high / o.high;
        let rest = rest - o * Self::from(second);
        Self::normalised(first, second) + Self::from(rest.high / o.high)
    }
}

/// A vector of double-doubles.
#[derive(Clone, Copy, Debug)]
pub struct DdVec3(pub [Dd; 3]);

impl From<DVec3> for DdVec3 {
    fn from(v: DVec3) -> Self {
        Self(v.to_array().map(Dd::from))
    }
}

impl DdVec3 {
    /// (self, o)
    pub fn dot(self, o: Self) -> Dd {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        a * x + b * y + c * z
    }

    /// self x o
    pub fn cross(self, o: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    /// The sum of `self` and `o` times `k`.
    pub fn plus(self, o: Self, k: Dd) -> Self {
        Self([0, 1, 2].map(|i| self.0[i] + o.0[i] * k))
    }

    /// self - o
    pub fn minus(self, o: Self) -> Self {
        Self([0, 1, 2].map(|i| self.0[i] - o.0[i]))
    }

    /// The length.
    pub fn length(self) -> Dd {
        self.dot(self).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SplitMix64;

    #[test]
    fn sums_products_quotients_and_roots_are_exact_to_thirty_digits() {
        let mut rng = SplitMix64(1);
        for _ in 0..10_000 {
            // Identities whose f64 versions fail in the sixteenth digit.
            let [a, b, c] = [0; 3].map(|_| {
                let high = rng.range(-1.0, 1.0) * 10f64.powf(rng.range(-6.0, 6.0));
                Dd::from(high) + Dd::from(high * rng.unit() * 1e-17)
            });
            let near = |x: Dd, y: Dd, size: Dd| (x - y).abs().to_f64() <= 1e-30 * size.abs().to_f64();
            assert!(near((a + b) - b, a, a.abs() + b.abs()));
            assert!(near(a * (b + c), a * b + a * c, (a * b).abs() + (a * c).abs()));
            assert!(near(a / b * b, a, a));
            assert!(near((a * a).sqrt(), a.abs(), a));
        }
        let third = Dd::ONE / Dd::from(3.0);
        assert_eq!((third.high, third.low), (1.0 / 3.0, 1.850371707708594e-17));
    }

    #[test]
    fn a_product_of_two_f64_has_no_error_at_all() {
        // (2^52 + 1)² = 2^104 + 2^53 + 1
        let x = Dd::from(4_503_599_627_370_497.0);
        let square = x * x;
        assert_eq!(square.high + 0.0, 2f64.powi(104) + 2f64.powi(53));
        assert_eq!(square.low, 1.0);
    }
}
