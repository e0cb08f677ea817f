//! Optical properties.

use super::texture::Texture;
use crate::description::MaterialDesc;
use crate::math::Rgb;
use glam::DVec2;

/// The coefficients of the lighting equation, ready for lookup.
#[derive(Clone, Debug)]
pub struct Material {
    pub(super) color: Rgb,
    pub(super) texture: Option<Texture>,
    /// k_a
    pub ambient: f64,
    /// k_d
    pub diffuse: f64,
    /// k_s
    pub specular: f64,
    /// s
    pub shininess: f64,
    /// k_r
    pub reflect: f64,
    /// k_t
    pub transmit: f64,
    /// Refractive index inside.
    pub ior: f64,
    /// Whether k_r + k_t is split by Fresnel's equations.
    pub fresnel: bool,
    /// Rank among overlapping media.
    pub priority: i32,
}

impl Material {
    /// From a description and its compiled texture.
    pub fn new(desc: &MaterialDesc, texture: Option<Texture>) -> Self {
        Self {
            color: desc.color,
            texture,
            ambient: desc.ambient,
            diffuse: desc.diffuse,
            specular: desc.specular,
            shininess: desc.shininess,
            reflect: desc.reflect,
            transmit: desc.transmit,
            ior: desc.ior,
            fresnel: desc.fresnel,
            priority: desc.priority,
        }
    }

    /// No channel of C is above that of this colour.
    pub fn brightest(&self) -> Rgb {
        self.texture.as_ref().map_or(self.color, Texture::brightest)
    }

    /// C at the texture coordinates `uv`, which are asked for only if there is a texture.
    pub fn color(&self, uv: impl FnOnce() -> DVec2) -> Rgb {
        self.texture.as_ref().map_or(self.color, |t| t.lookup(uv()))
    }
}
