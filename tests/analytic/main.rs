//! Whole pictures against closed forms: numerics.md section 4, items 1 to 12. Every expected value is derived from the
//! physics in a comment; none comes from the renderer.

#[path = "../support/mod.rs"]
mod support;

mod lens;
mod light;
mod mirrors;
mod outline;
mod slab;
mod surface;
