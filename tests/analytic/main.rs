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
mod texture;

/// What a picture may lack where weights run down: paths of less than 2^-20 are not followed, and of such a path at
/// most the double is missing here.
const UNSPENT: f64 = 2.0 / 1_048_576.0;
