//! Ranges of numbers.

use crate::description::limits;

/// The numbers that a key takes: one list for the parser and for whoever edits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    low: f64,
    high: f64,
    /// Whether the ends belong to it.
    closed: bool,
}

impl Interval {
    /// Coordinates.
    pub const PLACE: Self = Self::closed(-limits::MAX_LENGTH, limits::MAX_LENGTH);
    /// Radii, edges, heights.
    pub const LENGTH: Self = Self::closed(limits::MIN_LENGTH, limits::MAX_LENGTH);
    /// Linear light.
    pub const LIGHT: Self = Self::closed(0.0, limits::MAX_LIGHT);
    /// k_a, k_d, k_s.
    pub const COEFFICIENT: Self = Self::closed(0.0, limits::MAX_COEFFICIENT);
    /// Of Phong's highlight.
    pub const SHININESS: Self = Self::closed(1e-3, 1e6);
    /// Refractive indices, with room on both sides of nature.
    pub const IOR: Self = Self::closed(0.1, 10.0);
    /// Repeats and shifts of a texture.
    pub const UV: Self = Self::closed(-1e6, 1e6);
    /// Angles of rotation.
    pub const DEGREES: Self = Self::closed(-limits::MAX_ANGLE, limits::MAX_ANGLE);
    /// Angles of view, degrees.
    pub const FOV: Self = Self::open(0.0, 180.0);
    /// Crease angles, degrees.
    pub const CREASE: Self = Self::closed(0.0, 180.0);
    /// Errors of the picture in 8-bit codes.
    pub const ERROR: Self = Self::closed(*limits::ERROR.start(), *limits::ERROR.end());
    /// Shares of light.
    pub const SHARE: Self = Self::closed(0.0, 1.0);

    /// From `low` to `high`.
    pub const fn closed(low: f64, high: f64) -> Self {
        Self { low, high, closed: true }
    }

    /// Between `low` and `high`.
    pub const fn open(low: f64, high: f64) -> Self {
        Self { low, high, closed: false }
    }

    /// Whether the number belongs to it.
    pub fn contains(self, v: f64) -> bool {
        if self.closed { self.low <= v && v <= self.high } else { self.low < v && v < self.high }
    }

    /// The nearest number that belongs to it; of an open end one a little inside. NaN gives the lower end.
    pub fn clamp(self, v: f64) -> f64 {
        let inside = if self.closed { 0.0 } else { (self.high - self.low) * 1e-6 };
        v.max(self.low + inside).min(self.high - inside)
    }

    /// "from 0 to 1".
    pub fn words(self) -> String {
        let (low, high) = (short(self.low), short(self.high));
        if self.low == limits::MIN_LENGTH {
            format!("above 0 (from {low} to {high})")
        } else if self.closed {
            format!("from {low} to {high}")
        } else {
            format!("above {low} and below {high}")
        }
    }
}

/// A round number in few characters.
fn short(v: f64) -> String {
    if v != 0.0 && !(1e-3..1e6).contains(&v.abs()) { format!("{v:e}") } else { format!("{v}") }
}
