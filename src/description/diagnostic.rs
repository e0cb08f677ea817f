//! Errors in scene files, shown with the offending text.

use std::path::PathBuf;

/// One mistake in a scene file: where it is, what it is, and what to do.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// The scene file.
    pub file: PathBuf,
    /// From 1.
    pub line: usize,
    /// From 1, in characters.
    pub column: usize,
    /// What is wrong, in one line.
    pub message: String,
}
