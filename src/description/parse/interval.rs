//! Ranges of numbers.

use crate::description::limits;

/// The numbers that a key takes.
#[derive(Clone, Copy)]
pub(super) struct Interval {
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

    pub fn contains(self, v: f64) -> bool {
        if self.closed { self.low <= v && v <= self.high } else { self.low < v && v < self.high }
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
