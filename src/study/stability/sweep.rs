//! What an experiment finds.

use super::trials::Tally;
use serde::{Deserialize, Serialize};

/// One measure against one axis of difficulty, for every preset.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Sweep {
    /// What is measured: "wrong hit or miss".
    pub measure: String,
    /// What makes it hard: "distance / radius".
    pub axis: String,
    /// From easy to hard.
    pub rows: Vec<Row>,
    /// What must be known to read it; may be empty.
    #[serde(default)]
    pub note: String,
}

/// The values of one difficulty.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Row {
    /// On the axis.
    pub difficulty: f64,
    /// How often it was tried.
    pub trials: u64,
    /// Of classic, fast, robust and reference: the part of trials that failed, or the largest error.
    pub values: [f64; 4],
    /// The most that `robust` may have; `None` where nothing is promised.
    pub threshold: Option<f64>,
}

impl Row {
    /// The part of the trials that failed, of which `threshold` may.
    pub fn rates(difficulty: f64, tally: &Tally, threshold: f64) -> Self {
        Self { difficulty, trials: tally.trials, values: tally.rates(), threshold: Some(threshold) }
    }

    /// The largest errors, of which none may be above `threshold`.
    pub fn worst(difficulty: f64, tally: &Tally, threshold: f64) -> Self {
        Self { difficulty, trials: tally.trials, values: tally.worst, threshold: Some(threshold) }
    }

    /// Whether `robust` keeps what is promised of it.
    pub fn holds(&self) -> bool {
        self.is_within(2)
    }

    /// Whether a preset keeps what is promised of `robust`. NaN does not, nor does what was never tried.
    pub fn is_within(&self, preset: usize) -> bool {
        self.threshold.is_none_or(|threshold| self.values[preset] <= threshold) && self.trials > 0
    }
}

impl Sweep {
    /// A table of these rows.
    pub fn new(measure: &str, axis: &str, rows: Vec<Row>) -> Self {
        Self { measure: measure.into(), axis: axis.into(), rows, note: String::new() }
    }

    /// With a note below its table.
    pub fn noted(self, note: impl Into<String>) -> Self {
        Self { note: note.into(), ..self }
    }

    /// Whether `robust` keeps what is promised in every row.
    pub fn holds(&self) -> bool {
        !self.rows.is_empty() && self.rows.iter().all(Row::holds)
    }
}
