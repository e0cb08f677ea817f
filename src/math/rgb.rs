//! Linear colour.

use serde::Serialize;
use std::ops::{Add, AddAssign, Div, Mul};

/// Linear Rec. 709 colour or radiance: unbounded, one f64 per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(into = "[f64; 3]")]
pub struct Rgb {
    /// Red.
    pub r: f64,
    /// Green.
    pub g: f64,
    /// Blue.
    pub b: f64,
}

impl Rgb {
    /// No light.
    pub const BLACK: Rgb = Rgb::grey(0.0);
    /// Unit light in every channel.
    pub const WHITE: Rgb = Rgb::grey(1.0);

    /// A colour from its linear channels.
    #[inline(always)]
    pub const fn new(r: f64, g: f64, b: f64) -> Self {
        Self { r, g, b }
    }

    /// A grey of linear value `v`.
    #[inline(always)]
    pub const fn grey(v: f64) -> Self {
        Self { r: v, g: v, b: v }
    }

    /// Whether every channel is finite.
    pub fn is_finite(self) -> bool {
        self.r.is_finite() && self.g.is_finite() && self.b.is_finite()
    }

    /// The largest channel.
    #[inline(always)]
    pub fn largest(self) -> f64 {
        self.r.max(self.g).max(self.b)
    }

    /// `self` at `t = 0`, `other` at `t = 1`.
    pub fn lerp(self, other: Self, t: f64) -> Self {
        self * (1.0 - t) + other * t
    }

    /// Channels as f32, for storage in a film.
    pub fn to_f32(self) -> [f32; 3] {
        [self.r as f32, self.g as f32, self.b as f32]
    }
}

impl From<Rgb> for [f64; 3] {
    fn from(c: Rgb) -> Self {
        [c.r, c.g, c.b]
    }
}

impl Add for Rgb {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self::new(self.r + o.r, self.g + o.g, self.b + o.b)
    }
}

impl AddAssign for Rgb {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Mul for Rgb {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self::new(self.r * o.r, self.g * o.g, self.b * o.b)
    }
}

impl Mul<f64> for Rgb {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: f64) -> Self {
        Self::new(self.r * s, self.g * s, self.b * s)
    }
}

impl Div<f64> for Rgb {
    type Output = Self;
    #[inline(always)]
    fn div(self, s: f64) -> Self {
        Self::new(self.r / s, self.g / s, self.b / s)
    }
}
