//! Random vectors.

use crate::math::SplitMix64;
use glam::DVec3;

/// A unit vector, evenly distributed.
pub fn unit(rng: &mut SplitMix64) -> DVec3 {
    loop {
        let p = DVec3::new(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
        if (0.01..=1.0).contains(&p.length_squared()) {
            return p.normalize();
        }
    }
}

/// A unit vector at a right angle to a unit vector.
pub fn orthogonal(to: DVec3, rng: &mut SplitMix64) -> DVec3 {
    let (a, b) = to.any_orthonormal_pair();
    let (sin, cos) = (std::f64::consts::TAU * rng.unit()).sin_cos();
    a * cos + b * sin
}

/// A point of the cube of this half side about the origin.
pub fn within(rng: &mut SplitMix64, half: f64) -> DVec3 {
    DVec3::new(rng.range(-half, half), rng.range(-half, half), rng.range(-half, half))
}
