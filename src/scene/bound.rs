//! The largest radiance that a scene can have, in closed form.

use super::{Object, Scene, Shape};
use crate::description::{Background, Falloff, LightKind};
use crate::math::{Rgb, STEEPEST};
use glam::DVec3;

impl Scene {
    /// An upper bound of the radiance along any ray, over all channels: the L of the smallest value with L >=
    /// background and L >= (light that a material sends out itself) + (k_r + k_t) L for every material. `None` if there
    /// is none: where a material has k_r + k_t >= 1, or a light that falls off with distance may be as close to a
    /// surface as you like.
    pub(super) fn bound_radiance(&self) -> Option<f64> {
        let background = match self.world.background {
            Background::Solid(color) => color.largest(),
            Background::Gradient { top, bottom } => top.largest().max(bottom.largest()),
        };
        let mut lights = Rgb::BLACK;
        for light in &self.lights {
            let weakened = match light.kind {
                LightKind::Point { position, falloff: Falloff::InverseSquare } => {
                    let nearest = self.objects().iter().map(|o| o.least_distance(position)).fold(f64::MAX, f64::min);
                    if nearest <= 0.0 {
                        return None;
                    }
                    light.radiance / (nearest * nearest)
                }
                _ => light.radiance,
            };
            lights += weakened;
        }
        let mut bound = background;
        for material in &self.materials {
            let gain = material.reflect + material.transmit;
            if gain >= 1.0 {
                return None;
            }
            let color = material.brightest();
            let own = self.world.ambient * color * material.ambient
                + lights * (color * material.diffuse + Rgb::grey(material.specular));
            bound = bound.max(own.largest() / (1.0 - gain));
        }
        bound.is_finite().then_some(bound)
    }

    /// The weight below which a path can not matter: 2^-20, and with an error to reach what would change a pixel by
    /// that at most, were its code as steep as in the darks. What is cut is estimated then; in a mirror room with glass
    /// about a sixth of the error to reach was left of it.
    pub(super) fn bound_weight(&self) -> f64 {
        let brightest = self.largest_radiance.unwrap_or(1.0).max(1e-6);
        self.render.error.map_or(NEGLIGIBLE, |error| (error / STEEP / brightest).clamp(NEGLIGIBLE, 1.0 / 16.0))
    }

    /// What a sample may leave unasked of its lights: taken for half lit, it changes no pixel by more than half a code,
    /// nor by more than half of the error to reach, were the pixel black. Where radiance has no bound, weights are no
    /// shares.
    pub(super) fn bound_spare_light(&self) -> f64 {
        let error = self.render.error.filter(|_| self.largest_radiance.is_some());
        error.map_or(0.0, |error| error.min(1.0) / STEEPEST)
    }
}

/// Keeps ray trees from growing without end and changes nothing that a film can hold.
const NEGLIGIBLE: f64 = 1.0 / 1_048_576.0;

/// 8-bit codes for a unit of linear light at a code of 60: darker places are steeper, most of a picture is flatter.
const STEEP: f64 = 640.0;

impl Object {
    /// No point of the surface is closer to `point` than this.
    fn least_distance(&self, point: DVec3) -> f64 {
        match &self.shape {
            Shape::Ball { centre, radius } => (point.distance(*centre) - radius).abs(),
            Shape::Plane => {
                let normal = (self.map.inverse.matrix3.transpose() * DVec3::Y).normalize_or_zero();
                (point - self.map.forward.translation).dot(normal).abs()
            }
            _ => self.bounds().map_or(0.0, |bounds| {
                let (lower, upper) = (bounds.lower.as_dvec3(), bounds.upper.as_dvec3());
                (lower - point).max(point - upper).max(DVec3::ZERO).length()
            }),
        }
    }
}
