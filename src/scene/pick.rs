//! What a pixel shows.

use super::Scene;
use crate::bvh::TreeKernels;
use crate::description::Numerics;
use crate::geometry::{Classic, Fast, Hit, Ray, Reference, Robust};
use glam::DVec3;

/// What the ray through the centre of a pixel meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// Index of the `[[object]]`.
    pub object: usize,
    /// Index of the `[[material]]`; `None` for the default one and those of a model's file.
    pub material: Option<usize>,
    /// Where the ray ends, world space.
    pub point: DVec3,
    /// Its hit with the compiled object.
    pub hit: Hit,
}

impl Scene {
    /// The first thing that the ray through the centre of pixel (x, y) meets, found by the arithmetic that renders;
    /// `None` outside of the picture and where the background is seen.
    pub fn pick(&self, x: u32, y: u32) -> Option<Pick> {
        if x >= self.width || y >= self.height {
            return None;
        }
        match self.render.numerics {
            Numerics::Classic => self.pick_with::<Classic>(x, y),
            Numerics::Fast => self.pick_with::<Fast>(x, y),
            Numerics::Robust => self.pick_with::<Robust>(x, y),
            Numerics::Reference => self.pick_with::<Reference>(x, y),
        }
    }

    fn pick_with<K: TreeKernels>(&self, x: u32, y: u32) -> Option<Pick> {
        let ray = self.camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let ray = Ray { t_min: K::T_MIN, ..ray };
        let hit = self.intersect::<K>(&ray)?;
        let interaction = self.interaction::<K>(&ray, &hit);
        let object = self.objects()[hit.object as usize].source as usize;
        let material = interaction.material as usize;
        Some(Pick {
            object,
            material: (material < self.described_materials).then_some(material),
            point: interaction.point,
            hit,
        })
    }
}
