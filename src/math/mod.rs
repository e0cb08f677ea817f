//! Colour, hashing, sample sequences and affine transforms: arithmetic that knows nothing of scenes.

mod affine;
mod four;
mod hash;
mod rgb;
mod sobol;
mod srgb;

pub use affine::Affine;
pub use four::Four;
pub use hash::{SplitMix64, hash_pixel, lowbias32};
pub use rgb::Rgb;
pub use sobol::{sample_in_pixel, tent};
pub use srgb::{linear_to_srgb, linear_to_srgb8, srgb_to_linear, srgb8_to_linear};
