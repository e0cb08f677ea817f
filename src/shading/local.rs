//! The light that surfaces send toward the viewer by themselves: ambient, diffuse and highlights.
//!
//! With an error to reach, no shadow ray is traced where what hangs on it is too little: weight of the path times all
//! that the light can bring there. It is taken for half lit, which is wrong by half of that at most. Each sample may
//! leave [`Scene::spare_light`] unasked in all, a light no more than half of what is left of it: so many lights
//! together are wrong by no more than one, and small terms find room after large ones. Spent in the order of the
//! sample's own ray tree, it depends on nothing else in the packet.

use super::crossing::{Crossing, cross, slack};
use super::lit::{Respond, Shine};
use super::media::Media;
use super::packet::{Level, Lighting, Path};
use super::record::Recorder;
use super::sampler::terms;
use crate::bvh::TreeKernels;
use crate::description::Shadows;
use crate::geometry::{Hit, Ray};
use crate::scene::{Light, MediumStack, PacketScratch, Scene, SurfaceRows, Way};
use std::marker::PhantomData;
use std::sync::atomic::{AtomicBool, Ordering};

/// Adds k_d sum I_i (n, l_i) C + k_s sum I_i (v, r_i)^s to what the surfaces of a packet send out, light after light.
/// Returns how many shadow rays that took; they are traced for lights in front of a surface only.
pub(super) fn add_lights<K: TreeKernels, const TERMS: u8, R: Recorder>(
    scene: &Scene,
    rows: &SurfaceRows,
    lighting: &mut Lighting,
    (level, media): (&Level, &Media),
    packets: &mut PacketScratch,
    recorder: &mut R,
    stop: &AtomicBool,
) -> u64 {
    let mut traced = 0;
    for (index, light) in scene.lights.iter().enumerate() {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        lighting.gather::<K, TERMS>(scene, light, rows, &level.paths);
        if TERMS & terms::SHADOWS != 0 {
            traced += lighting.asked.len() as u64;
            if TERMS & terms::GLASS != 0 && scene.has_media() && scene.render.shadows == Shadows::Filtered {
                lighting.filter::<K>(scene, rows, (&level.paths, media), packets, stop);
            } else {
                lighting.occlude::<K>(scene, packets);
            }
        }
        recorder.light::<K, TERMS>(scene, index, lighting);
        let Lighting { lit, beams, .. } = lighting;
        scene.run(Respond::<K, TERMS>(PhantomData), &**beams, lit);
    }
    traced
}

impl Lighting {
    /// What a light sends to the surfaces that it is in front of, and the shadow rays. `paths`: those of the packet.
    #[inline(never)]
    fn gather<K: TreeKernels, const TERMS: u8>(
        &mut self,
        scene: &Scene,
        light: &Light,
        rows: &SurfaceRows,
        paths: &[Path],
    ) {
        let Self { lit, beams, asked, unasked, spent, .. } = self;
        let spare = TERMS & terms::SHADOWS != 0 && !spent.is_empty();
        scene.run(Shine::<K, TERMS> { light: *light, spare, kernels: PhantomData }, &**lit, beams);
        asked.clear();
        unasked.clear();
        for slot in 0..lit.count {
            if !beams.reaches(slot) {
                continue;
            }
            if spare {
                let spent = &mut spent[paths[usize::from(rows.ray[slot])].sample as usize];
                let (mut most, room) = (beams.most(slot), 0.5 * (scene.spare_light - *spent));
                // A power, so only if there is need of it.
                if most <= room && lit.get(slot).shines::<TERMS>() {
                    let beam = beams.get(slot);
                    most += lit.weight[slot] * beam.radiance.largest() * lit.get(slot).highlight::<K>(&beam);
                }
                if most <= room {
                    *spent += most;
                    beams.part[slot] = 0.5;
                    unasked.push((slot as u16, 0.5 * most));
                    continue;
                }
            }
            if TERMS & terms::SHADOWS == 0 || beams.has_ray(slot) {
                beams.part[slot] = 1.0;
                asked.push(slot as u16);
            }
        }
        if TERMS & terms::SHADOWS != 0 {
            beams.shadow_rays.set_len(lit.count);
            beams.shadow_rays.keep(asked);
        }
    }

    /// Takes away the beams that meet something.
    fn occlude<K: TreeKernels>(&mut self, scene: &Scene, packets: &mut PacketScratch) {
        let Self { beams, asked, occluded, .. } = self;
        occluded.clear();
        occluded.resize(asked.len(), false);
        scene.occluded_packet::<K>(&beams.shadow_rays.all(), occluded, packets);
        for (&slot, &occluded) in asked.iter().zip(&*occluded) {
            beams.part[usize::from(slot)] = if occluded { 0.0 } else { 1.0 };
        }
    }

    /// Weakens the beams that pass transparent surfaces by the product of their k_t. `paths`: those of the packet, and
    /// what they may be in.
    #[inline(never)]
    fn filter<K: TreeKernels>(
        &mut self,
        scene: &Scene,
        rows: &SurfaceRows,
        (paths, media): (&[Path], &Media),
        packets: &mut PacketScratch,
        stop: &AtomicBool,
    ) {
        let Self { beams, asked, inside, ways, glass: hits, .. } = self;
        let number = |slot: u16| paths[usize::from(rows.ray[usize::from(slot)])].media;
        ways.resize(asked.len(), Way::Unknown);
        inside.clear();
        inside.extend(asked.iter().map(|&slot| media.facts(number(slot)).inside));
        scene.look_along_packet::<K>(&beams.shadow_rays.all(), inside, ways, packets);
        for (k, (&slot, way)) in asked.iter().zip(&*ways).enumerate() {
            let part = &mut beams.part[usize::from(slot)];
            let (known, is_followed) = match *way {
                Way::Clear => (1.0, false),
                Way::Blocked => (0.0, false),
                Way::Part(part) => (part, false),
                Way::Glass | Way::Unknown => (1.0, true),
            };
            *part = known;
            if !is_followed {
                continue;
            }
            if stop.load(Ordering::Relaxed) {
                return;
            }
            let ray = beams.shadow_rays.ray(k);
            let reached = if *way == Way::Glass {
                scene.glass_along::<K>(&ray, hits);
                true
            } else {
                !scene.blocked::<K>(&ray, hits)
            };
            if !reached {
                *part = 0.0;
            } else if !hits.is_empty() {
                *part = transmittance::<K>(scene, ray, *media.stack(number(slot)), hits);
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
