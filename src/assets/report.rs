//! What importing a model found, mended, dropped and missed.

/// Counts and warnings of one import.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImportReport {
    /// Triangles kept.
    pub triangles: usize,
    /// Triangles dropped because their area is exactly 0.
    pub dropped_degenerate: usize,
    /// One sentence each: what was computed, ignored or not found.
    pub notes: Vec<String>,
}
