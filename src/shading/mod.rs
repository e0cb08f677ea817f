//! Radiance along rays.
