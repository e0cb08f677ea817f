//! Rendering without a terminal.
