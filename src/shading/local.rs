//! The light that surfaces send toward the viewer by themselves: ambient, diffuse and highlights.
//!
//! With an error to reach, no shadow ray is traced where what hangs on it is too little: weight of the path times all
//! that the light can bring there. It is taken for half lit, which is wrong by half of that at most. Each sample may
//! leave [`Scene::spare_light`] unasked in all, a light no more than half of what is left of it: so many lights
//! together are wrong by no more than one, and small terms find room after large ones. Spent in the order of the
//! sample's own ray tree, it depends on nothing else in the packet.

use super::crossing::{Crossing, cross, slack};
use super::packet::{Beam, Level, Lighting, Path, Surface};
use super::record::Recorder;
use super::sampler::terms;
use crate::bvh::TreeKernels;
use crate::description::Shadows;
use crate::geometry::{Hit, Ray};
use crate::math::Rgb;
use crate::scene::{Light, Material, MediumStack, PacketScratch, Scene, Way};
use std::sync::atomic::{AtomicBool, Ordering};

/// Adds k_d sum I_i (n, l_i) C + k_s sum I_i (v, r_i)^s to the sums of a packet, light after light. Returns how many
/// shadow rays that took; they are traced for lights in front of a surface only.
pub(super) fn add_lights<K: TreeKernels, const TERMS: u8, R: Recorder>(
    scene: &Scene,
    lighting: &mut Lighting,
    level: &mut Level,
    packets: &mut PacketScratch,
    recorder: &mut R,
    stop: &AtomicBool,
) -> u64 {
    let mut traced = 0;
    for (index, light) in scene.lights.iter().enumerate() {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        lighting.gather::<K, TERMS>(scene, light, &level.paths);
        if TERMS & terms::SHADOWS != 0 {
            traced += lighting.shadow_rays.len() as u64;
            if TERMS & terms::GLASS != 0 && scene.has_media() && scene.render.shadows == Shadows::Filtered {
                lighting.filter::<K>(scene, &level.media, packets, stop);
            } else {
                lighting.occlude::<K>(scene, packets);
            }
        }
        lighting.beams.append(&mut lighting.unasked);
        recorder.light::<K>(scene, index, lighting);
        for beam in lighting.beams.iter().filter(|beam| beam.part != 0.0) {
            let surface = &lighting.surfaces[beam.surface as usize];
            let material = &scene.materials[surface.material as usize];
            let diffuse = diffuse(material, surface, beam);
            let (mut response, mut specular) = (diffuse, 0.0);
            if TERMS & terms::HIGHLIGHTS != 0 && material.specular > 0.0 {
                specular = highlight::<K>(material, surface, beam);
                response += Rgb::grey(specular);
            }
            let sum = beam.radiance * response * beam.part;
            recorder.add(beam, diffuse, specular, sum);
            level.sums[surface.index as usize] += sum;
        }
    }
    traced
}

/// k_d (n, l) C
fn diffuse(material: &Material, surface: &Surface, beam: &Beam) -> Rgb {
    surface.color * (material.diffuse * beam.cosine)
}

/// k_s (v, r)^s
fn highlight<K: TreeKernels>(material: &Material, surface: &Surface, beam: &Beam) -> f64 {
    let mirrored = surface.normal * (2.0 * beam.cosine) - beam.direction;
    material.specular * K::highlight(mirrored.dot(surface.view), material.shininess)
}

impl Lighting {
    /// What a light sends to the surfaces that it is in front of, and the shadow rays. `paths`: those of the packet.
    #[inline(never)]
    fn gather<K: TreeKernels, const TERMS: u8>(&mut self, scene: &Scene, light: &Light, paths: &[Path]) {
        self.beams.clear();
        self.shadow_rays.clear();
        for (number, surface) in (0..).zip(&self.surfaces) {
            let Surface { point, shadow_start, normal, .. } = surface;
            let Some(light) = light.illuminate(*point) else { continue };
            let cosine = normal.dot(light.direction);
            if cosine <= 0.0 {
                continue;
            }
            let (direction, radiance) = (light.direction, light.radiance);
            let beam = Beam { surface: number, direction, cosine, radiance, part: 1.0, doubt: None };
            let path = &paths[surface.index as usize];
            if let (true, Some(spent)) = (TERMS & terms::SHADOWS != 0, self.spent.get_mut(path.sample as usize)) {
                let material = &scene.materials[surface.material as usize];
                let room = 0.5 * (scene.spare_light - *spent);
                let mut most = path.weight * (radiance * diffuse(material, surface, &beam)).largest();
                // A power, so only if there is need of it.
                if most <= room && TERMS & terms::HIGHLIGHTS != 0 && material.specular > 0.0 {
                    most += path.weight * radiance.largest() * highlight::<K>(material, surface, &beam);
                }
                if most <= room {
                    *spent += most;
                    self.unasked.push(Beam { part: 0.5, doubt: Some(0.5 * most), ..beam });
                    continue;
                }
            }
            if TERMS & terms::SHADOWS != 0 {
                let ray = match light.position {
                    Some(position) => shadow_start.ray_to::<K>(position),
                    None => Some(shadow_start.ray_along::<K>(light.direction)),
                };
                let Some(ray) = ray else { continue };
                self.shadow_rays.push(ray);
            }
            self.beams.push(beam);
        }
    }

    /// Takes away the beams that meet something.
    fn occlude<K: TreeKernels>(&mut self, scene: &Scene, packets: &mut PacketScratch) {
        self.occluded.resize(self.shadow_rays.len(), false);
        scene.occluded_packet::<K>(&self.shadow_rays, &mut self.occluded, packets);
        for (beam, _) in self.beams.iter_mut().zip(&self.occluded).filter(|(_, occluded)| **occluded) {
            beam.part = 0.0;
        }
    }

    /// Weakens the beams that pass transparent surfaces by the product of their k_t. `media`: around the packet's rays.
    #[inline(never)]
    fn filter<K: TreeKernels>(
        &mut self,
        scene: &Scene,
        media: &[MediumStack],
        packets: &mut PacketScratch,
        stop: &AtomicBool,
    ) {
        self.ways.resize(self.shadow_rays.len(), Way::Unknown);
        self.inside.clear();
        let surfaces = &self.surfaces;
        self.inside.extend(self.beams.iter().map(|beam| surfaces[beam.surface as usize].inside));
        scene.look_along_packet::<K>(&self.shadow_rays, &self.inside, &mut self.ways, packets);
        for ((beam, ray), way) in self.beams.iter_mut().zip(&self.shadow_rays).zip(&self.ways) {
            if stop.load(Ordering::Relaxed) {
                return;
            }
            let hits = &mut self.glass;
            let reached = match way {
                Way::Clear => continue,
                Way::Blocked => false,
                Way::Part(part) => {
                    beam.part = *part;
                    continue;
                }
                Way::Glass => {
                    scene.glass_along::<K>(ray, hits);
                    true
                }
                Way::Unknown => !scene.blocked::<K>(ray, hits),
            };
            if !reached {
                beam.part = 0.0;
            } else if !hits.is_empty() {
                let media = media[surfaces[beam.surface as usize].index as usize];
                beam.part = transmittance::<K>(scene, *ray, media, hits);
            }
        }
    }
}

/// The part of the light that gets through to the end of a ray past transparent surfaces: the product of their k_t.
/// `hits`: the first with each object that may let light through; the others are not in the way.
#[inline(never)]
fn transmittance<K: TreeKernels>(scene: &Scene, mut ray: Ray, mut media: MediumStack, hits: &mut Vec<Hit>) -> f64 {
    let mut part = 1.0;
    while part > 0.0 {
        let Some(&first) = hits.iter().reduce(|best, hit| if hit.beats(best) { hit } else { best }) else { break };
        let (passed, entering) = pass::<K>(scene, &mut ray, &first, &mut media);
        part *= passed;
        // On to the next hits with the objects that are passed. What is convex is left for good.
        hits.retain_mut(|hit| {
            let object = &scene.objects()[hit.object as usize];
            if hit.t > ray.t_min {
                true
            } else if K::CONSERVATIVE && !entering && hit.object == first.object && object.is_convex() {
                false
            } else if let Some(next) = object.intersect::<K>(&ray, hit.object) {
                *hit = next;
                true
            } else {
                false
            }
        });
    }
    part
}

/// The part of the light that gets through what a shadow ray meets, and whether that is the way into a body. The same
/// ray goes on behind the hit: nothing is computed anew, so nothing is met twice or skipped.
fn pass<K: TreeKernels>(scene: &Scene, ray: &mut Ray, hit: &Hit, media: &mut MediumStack) -> (f64, bool) {
    let material = scene.material_of(hit.object, hit.primitive);
    if scene.materials[material as usize].transmit == 0.0 {
        return (0.0, true);
    }
    let facet = scene.facet::<K>(ray, hit);
    let slack = slack(ray, hit, facet.normal, facet.point_error);
    let part = match cross::<K>(scene, ray, hit, (material, facet.entering), media, slack) {
        Crossing::Opaque(_) => 0.0,
        Crossing::Nothing => 1.0,
        Crossing::Surface(transmit) => transmit,
    };
    ray.t_min = hit.t + slack;
    (part, facet.entering)
}
