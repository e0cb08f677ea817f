//! Rays, boxes and shapes.
/// Placeholder
pub struct Ray;
/// Placeholder
pub struct Hit;
/// Placeholder
pub struct SurfaceInteraction;
/// Placeholder
pub struct Aabb;
