//! Rectangles of pixels and the sums that are gathered in them.

/// A rectangle of pixels of the film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// Leftmost column.
    pub x: u32,
    /// Topmost row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// The state of one rectangle between passes: moves from worker to worker by value.
pub struct Tile {
    /// Its pixels.
    pub rect: Rect,
}
