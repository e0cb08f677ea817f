//! The light that a surface sends toward the viewer by itself: ambient, diffuse and highlights.

use crate::geometry::{Kernels, SurfaceInteraction};
use crate::math::Rgb;
use crate::scene::{Illumination, Material, Scene};
use glam::DVec3;

/// k_a I_a C + k_d sum I_i (n, l_i) C + k_s sum I_i (v, r_i)^s at a surface with its colour `C`. `view`: unit, toward the
/// viewer; `normal`: unit, on the viewer's side. `visible` tells which part of a light arrives; it is asked only for lights
/// in front of the surface.
pub(super) fn local_radiance<K: Kernels, const HIGHLIGHTS: bool>(
    scene: &Scene,
    material: &Material,
    interaction: &SurfaceInteraction,
    normal: DVec3,
    view: DVec3,
    mut visible: impl FnMut(&Illumination) -> f64,
) -> Rgb {
    let color = material.color(|| scene.uv(interaction));
    let mut sum = scene.world.ambient * color * material.ambient;
    let highlights = HIGHLIGHTS && material.specular > 0.0;
    if material.diffuse == 0.0 && !highlights {
        return sum;
    }
    for light in &scene.lights {
        let Some(light) = light.illuminate(interaction.point) else { continue };
        let cosine = normal.dot(light.direction);
        if cosine <= 0.0 {
            continue;
        }
        let part = visible(&light);
        if part == 0.0 {
            continue;
        }
        let mut response = color * (material.diffuse * cosine);
        if highlights {
            let mirrored = normal * (2.0 * cosine) - light.direction;
            response += Rgb::grey(material.specular * K::highlight(mirrored.dot(view), material.shininess));
        }
        sum += light.radiance * response * part;
    }
    sum
}
