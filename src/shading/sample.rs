//! What comes out of tracing.

use crate::math::{Rgb, lowbias32};
use glam::{DVec3, Vec3};
use std::ops::AddAssign;

/// Rays by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// From the eye.
    pub camera: u64,
    /// To lights.
    pub shadow: u64,
    /// Mirrored.
    pub reflection: u64,
    /// Through glass.
    pub refraction: u64,
}

impl RayCounts {
    /// All kinds together.
    pub fn total(&self) -> u64 {
        self.camera + self.shadow + self.reflection + self.refraction
    }
}

impl AddAssign for RayCounts {
    fn add_assign(&mut self, o: Self) {
        self.camera += o.camera;
        self.shadow += o.shadow;
        self.reflection += o.reflection;
        self.refraction += o.refraction;
    }
}

/// What the camera sees through one point of the film.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Not finite where the arithmetic of `Classic` or `Fast` fails, or where light is beyond the range of f64.
    pub radiance: Rgb,
    /// Stands for the surface that the camera ray ends on; 0 where it meets nothing.
    pub surface: u32,
    /// Unit normal there in world space, on the viewer's side; 0 where it meets nothing.
    pub normal: Vec3,
    /// Hash of all surfaces that the ray tree meets, in order: samples of equal trees differ smoothly.
    pub tree: u32,
    /// About the rays that it takes: one a path, and one a light wherever that meets a surface.
    pub cost: u32,
    /// Sum of the weights of paths that were not followed, for their depth or because they weigh next to nothing, and
    /// of what lights may be wrong by that were not asked for: as weight of the largest radiance of the scene.
    pub cut: f64,
    /// Whether a ray was inside of more transparent bodies at once than are kept track of.
    pub overfull: bool,
    /// What those that weigh next to nothing are taken to bring: part of the radiance. See `tail`.
    pub tail: Rgb,
}

impl Sample {
    /// Notes a surface that the ray tree meets: its object, and its normal on the viewer's side if that is where the
    /// camera ray ends.
    #[inline(always)]
    pub(super) fn meet(&mut self, object: u32, normal: Option<DVec3>, lights: usize) {
        self.cost += 1 + lights as u32;
        // The parts of a mesh are told apart by their normals.
        let surface = object + 1;
        if let Some(normal) = normal {
            self.surface = surface;
            self.normal = normal.as_vec3();
        }
        self.tree = lowbias32(self.tree.wrapping_mul(31).wrapping_add(surface));
    }
}
