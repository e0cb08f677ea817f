//! Colour, hashing, sample sequences and affine transforms: arithmetic that knows nothing of scenes.

mod affine;
mod hash;
mod rgb;
mod sobol;
mod srgb;

pub use affine::Affine;
pub use hash::{SplitMix64, hash_pixel, lowbias32};
pub use rgb::Rgb;
pub use sobol::{sample_in_pixel, tent};
pub use srgb::{
    STEEPEST, linear_to_srgb, linear_to_srgb_near, linear_to_srgb8, srgb_to_linear, srgb_to_linear_near,
    srgb8_to_linear,
};
