//! Hierarchies of boxes.
/// Placeholder
pub struct Bvh;
