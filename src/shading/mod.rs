//! Radiance along rays: Lambert, Phong and Whitted.
//!
//! I = k_a I_a C + k_d sum I_i (n, l_i) C + k_s sum I_i (v, r_i)^s + k_r I_r + k_t I_t
//!
//! Samples are traced in packets: all their camera rays together, then the shadow rays of all surfaces toward one light
//! after the other, then all mirrored rays with everything that follows from them, then all refracted rays. That is the
//! order in which one sample alone would be traced, so every sum is made of the same numbers in the same order,
//! whatever else is in the packet. Rays, surfaces and light lie in rows, number by number, and what is done with all of
//! them are loops that become vector code ([`Task`](crate::bvh::Task)).
//!
//! [`sampler`] picks, once a render, the code that has just the terms and the arithmetic which the scene asks for.

mod crossing;
mod lit;
mod local;
mod media;
mod onward;
mod packet;
mod probe;
mod radiance;
mod ray_tree;
mod record;
mod sample;
mod sampler;
mod tail;

pub use packet::Scratch;
pub use probe::{Probe, probe_sampler};
pub use ray_tree::{
    Branch, Coefficients, Cut, Emphasis, End, LightTerm, Line, Medium, Passed, RayKind, RayTree, SurfaceTerms,
};
pub use sample::{RayCounts, Sample};
pub use sampler::{Sampler, sampler, trace_tree};
