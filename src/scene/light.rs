//! Light sources.

use crate::description::{Falloff, LightDesc, LightKind};
use crate::math::Rgb;
use glam::DVec3;

/// A light source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where it shines from.
    pub kind: LightKind,
    /// Colour times intensity.
    pub radiance: Rgb,
}

/// How a light reaches a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Illumination {
    /// Unit, toward the light.
    pub direction: DVec3,
    /// I_i at the point, unless something is in the way.
    pub radiance: Rgb,
    /// Where the light is; `None` if infinitely far.
    pub position: Option<DVec3>,
}

impl Light {
    /// From a description; directional lights with their direction made unit.
    pub fn new(desc: &LightDesc) -> Self {
        let kind = match desc.kind {
            LightKind::Directional { direction } => {
                LightKind::Directional { direction: direction.normalize_or(DVec3::NEG_Y) }
            }
            point => point,
        };
        Self { kind, radiance: desc.color * desc.intensity }
    }

    /// How the light reaches `point`; `None` for a point light that is there itself.
    pub fn illuminate(&self, point: DVec3) -> Option<Illumination> {
        let (illumination, is_apart) = self.shine(point);
        is_apart.then_some(illumination)
    }

    /// The same without a branch, and whether it is true: not for a point light that is there itself.
    #[inline(always)]
    pub fn shine(&self, point: DVec3) -> (Illumination, bool) {
        match self.kind {
            LightKind::Directional { direction } => {
                (Illumination { direction: -direction, radiance: self.radiance, position: None }, true)
            }
            LightKind::Point { position, falloff } => {
                let way = position - point;
                let distance = way.length();
                let radiance = match falloff {
                    Falloff::None => self.radiance,
                    Falloff::InverseSquare => self.radiance / (distance * distance),
                };
                let illumination = Illumination { direction: way / distance, radiance, position: Some(position) };
                (illumination, distance != 0.0)
            }
        }
    }
}
