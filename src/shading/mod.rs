//! Radiance along rays: Lambert, Phong and Whitted.
//!
//! I = k_a I_a C + k_d sum I_i (n, l_i) C + k_s sum I_i (v, r_i)^s + k_r I_r + k_t I_t
//!
//! [`sampler`] picks, once a render, the code that has just the terms and the arithmetic which the scene asks for.

mod local;
mod radiance;

pub use radiance::{RayCounts, Sample, Sampler, sampler};
