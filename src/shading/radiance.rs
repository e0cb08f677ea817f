//! The recursive function.

use super::crossing::{Crossing, Split, cross, slack, split};
use super::local::add_lights;
use super::packet::{Level, Lighting, Path, Scratch, Surface};
use super::ray_tree::{Cut, RayKind};
use super::record::Recorder;
use super::sample::{RayCounts, Sample};
use super::sampler::terms;
use super::tail::Tail;
use crate::bvh::TreeKernels;
use crate::geometry::{Hit, Ray, SurfaceInteraction, reflect};
use crate::math::Rgb;
use crate::scene::{MediumStack, PacketScratch, Scene};
use glam::DVec2;
use std::sync::atomic::{AtomicBool, Ordering};

/// A [`Sampler`](super::Sampler) for scenes that need no more than `TERMS`.
pub(super) fn trace<K: TreeKernels, const TERMS: u8, R: Recorder>(
    scene: &Scene,
    points: &[DVec2],
    samples: &mut [Sample],
    counts: &mut RayCounts,
    scratch: &mut Scratch<R>,
    stop: &AtomicBool,
) {
    let Scratch { levels, lighting, packets, tails, recorder } = scratch;
    let depths = if TERMS & terms::MIRRORS != 0 { scene.render.max_depth as usize + 1 } else { 1 };
    if levels.len() < depths {
        levels.resize_with(depths, Level::default);
    }
    samples.fill(Sample::default());
    tails.clear();
    // Without an error to reach, what is cut is below all that a film can hold.
    if TERMS & terms::MIRRORS != 0 && scene.render.error.is_some() {
        tails.resize(samples.len(), Tail::default());
    }
    lighting.spent.clear();
    if TERMS & terms::SHADOWS != 0 && scene.spare_light > 0.0 {
        lighting.spent.resize(samples.len(), 0.0);
    }
    let first = &mut levels[0];
    first.clear();
    for (sample, point) in (0..).zip(points) {
        let ray = Ray { t_min: K::T_MIN, ..scene.camera.ray(point.x, point.y) };
        if TERMS & terms::GLASS != 0 {
            first.media.push(scene.media_at_start(ray.origin));
        }
        first.rays.push(ray);
        first.paths.push(Path { sample, parent: 0, share: 1.0, weight: 1.0 });
    }
    counts.camera += points.len() as u64;
    let mut tracer = Tracer { scene, samples, counts, lighting, packets, tails, recorder, stop };
    tracer.recorder.begin::<K>(scene, RayKind::Camera, &levels[0]);
    tracer.radiance::<K, TERMS>(&mut levels[..depths], 0);
    tracer.recorder.end(&levels[0]);
    for (sample, &sum) in samples.iter_mut().zip(&levels[0].sums) {
        sample.radiance = sum;
    }
    // Half of it was taken, so that it is wrong by the other half at most.
    let doubt = 0.5 / scene.largest_radiance.unwrap_or(f64::INFINITY);
    for (sample, spent) in samples.iter_mut().zip(&lighting.spent).filter(|(_, spent)| **spent > 0.0) {
        sample.cut += spent * doubt;
    }
    for (sample, tail) in samples.iter_mut().zip(tails) {
        sample.tail = tail.estimate(scene.largest_radiance);
        sample.radiance += sample.tail;
    }
}

struct Tracer<'a, R> {
    scene: &'a Scene,
    samples: &'a mut [Sample],
    counts: &'a mut RayCounts,
    lighting: &'a mut Lighting,
    packets: &'a mut PacketScratch,
    /// Empty if nothing that matters is cut.
    tails: &'a mut [Tail],
    recorder: &'a mut R,
    stop: &'a AtomicBool,
}

impl<R: Recorder> Tracer<'_, R> {
    /// What the rays of the first level see, which have been reflected and refracted `depth` times. The other levels are room
    /// for what follows.
    fn radiance<K: TreeKernels, const TERMS: u8>(&mut self, levels: &mut [Level], depth: u32) {
        let Some((level, deeper)) = levels.split_first_mut() else { return };
        level.sums.clear();
        level.sums.resize(level.rays.len(), Rgb::BLACK);
        if level.rays.is_empty() || self.stop.load(Ordering::Relaxed) {
            return;
        }
        level.hits.resize(level.rays.len(), None);
        self.scene.intersect_packet::<K>(&level.rays, &mut level.hits, self.packets);
        self.lighting.surfaces.clear();
        for index in 0..level.rays.len() {
            self.meet::<K, TERMS>(level, index, depth);
        }
        self.counts.shadow +=
            add_lights::<K, TERMS, R>(self.scene, self.lighting, level, self.packets, self.recorder, self.stop);
        if TERMS & terms::MIRRORS != 0 && !self.tails.is_empty() {
            for (path, &own) in level.paths.iter().zip(&level.sums) {
                self.tails[path.sample as usize].meet(own);
            }
        }
        if TERMS & terms::MIRRORS != 0 {
            let Some(next) = deeper.first_mut() else { return };
            next.take(&mut level.reflected);
            self.counts.reflection += next.rays.len() as u64;
            self.follow::<K, TERMS>(RayKind::Reflection, &mut level.sums, deeper, depth + 1);
        }
        if TERMS & terms::GLASS != 0 {
            let Some(next) = deeper.first_mut() else { return };
            // Asked only now, so that what is cut off a sample is added up in the order of its ray tree.
            level.refracted.retain(|path| self.worth_it(path, RayKind::Refraction));
            next.take(&mut level.refracted);
            self.counts.refraction += next.rays.len() as u64;
            self.follow::<K, TERMS>(RayKind::Refraction, &mut level.sums, deeper, depth + 1);
        }
    }

    /// Adds what the rays of the first level see to the sums of those that they come from.
    fn follow<K: TreeKernels, const TERMS: u8>(
        &mut self,
        kind: RayKind,
        sums: &mut [Rgb],
        levels: &mut [Level],
        depth: u32,
    ) {
        self.recorder.begin::<K>(self.scene, kind, &levels[0]);
        self.radiance::<K, TERMS>(levels, depth);
        self.recorder.end(&levels[0]);
        for (path, &sum) in levels[0].paths.iter().zip(&levels[0].sums) {
            sums[path.parent as usize] += sum * path.share;
        }
    }

    /// Shades one ray of a packet as far as it can be done alone: background or ambient light, and the rays that go on.
    fn meet<K: TreeKernels, const TERMS: u8>(&mut self, level: &mut Level, index: usize, depth: u32) {
        let scene = self.scene;
        let mut ray = level.rays[index];
        let mut beyond = None;
        let met = match level.hits[index] {
            Some(hit) if TERMS & terms::GLASS != 0 => {
                surface::<K, R>(scene, &mut ray, hit, &mut level.media[index], &mut beyond, self.recorder)
            }
            hit => hit.map(|hit| scene.interaction::<K>(&ray, &hit)),
        };
        if TERMS & terms::GLASS != 0 {
            let overfull = level.media[index].is_overfull() || beyond.is_some_and(|beyond| beyond.is_overfull());
            self.samples[level.paths[index].sample as usize].overfull |= overfull;
        }
        let Some(interaction) = met else {
            level.sums[index] = scene.background(ray.direction);
            self.samples[level.paths[index].sample as usize].cost += 1;
            return;
        };
        let material = &scene.materials[interaction.material as usize];
        let Path { sample, weight, .. } = level.paths[index];
        self.samples[sample as usize].meet(&interaction, depth, scene.lights.len());
        let side = if interaction.entering { 1.0 } else { -1.0 };
        let normal = interaction.shading_normal * side;
        let color = material.color(|| scene.uv(&interaction));
        let ambient = scene.world.ambient * color * material.ambient;
        self.recorder.meet(scene, &interaction, color, ambient, beyond.as_ref());
        level.sums[index] = ambient;
        let index = index as u32;
        if material.diffuse != 0.0 || (TERMS & terms::HIGHLIGHTS != 0 && material.specular > 0.0) {
            self.lighting.surfaces.push(Surface {
                index,
                material: interaction.material,
                point: interaction.point,
                shadow_start: interaction.shadow_start(),
                normal,
                view: -ray.direction,
                color,
            });
        }
        if TERMS & terms::MIRRORS == 0 || (material.reflect == 0.0 && material.transmit == 0.0) {
            return;
        }
        if let Some(tail) = self.tails.get_mut(sample as usize) {
            tail.send_on(material.reflect + material.transmit);
        }
        if depth >= scene.render.max_depth {
            let weight = weight * (material.reflect + material.transmit);
            self.samples[sample as usize].cut += weight;
            self.recorder.cut(Cut { kind: None, weight, depth: true });
            return;
        }
        let media = level.media.get(index as usize);
        let outside = media.map_or(scene.world.ior, |media| media.ior(scene));
        let eta = beyond.map(|beyond| outside / beyond.ior(scene));
        let facet = interaction.geometric_normal * side;
        let Split { normal, reflect: mirrored, transmit } =
            split::<K>(material, &ray, normal, facet, (outside, eta), interaction.entering);
        // A material that gives back more than it gets is weighed by shares, or its ray tree would grow without end.
        let gain = (mirrored + transmit.map_or(0.0, |(weight, _)| weight)).max(1.0);
        let path = |share: f64| Path { sample, parent: index, share, weight: weight * (share / gain) };
        let onward = path(mirrored);
        if self.worth_it(&onward, RayKind::Reflection) {
            let direction = reflect(ray.direction, normal, facet);
            level.reflected.push(interaction.spawn_ray::<K>(direction), onward, media);
        }
        if let (Some((share, direction)), Some(beyond)) = (transmit, beyond) {
            level.refracted.push(interaction.spawn_ray::<K>(direction), path(share), Some(&beyond));
        }
    }

    /// Whether a path is worth following; if not, its weight is noted.
    fn worth_it(&mut self, path: &Path, kind: RayKind) -> bool {
        let worth_it = path.weight >= self.scene.least_weight;
        if !worth_it {
            self.samples[path.sample as usize].cut += path.weight;
            if let Some(tail) = self.tails.get_mut(path.sample as usize) {
                tail.cut(path.weight);
            }
            self.recorder.cut(Cut { kind: Some(kind), weight: path.weight, depth: false });
        }
        worth_it
    }
}

/// The surface that a ray ends on, past those that change nothing; `beyond` gets the media behind it, if light gets there. `ray`
/// and `media` are brought to where the ray arrives at it.
fn surface<K: TreeKernels, R: Recorder>(
    scene: &Scene,
    ray: &mut Ray,
    mut hit: Hit,
    media: &mut MediumStack,
    beyond: &mut Option<MediumStack>,
    recorder: &mut R,
) -> Option<SurfaceInteraction> {
    loop {
        let interaction = scene.interaction::<K>(ray, &hit);
        if scene.materials[interaction.material as usize].transmit == 0.0 {
            return Some(interaction);
        }
        let slack = slack(ray, &hit, &interaction);
        match cross::<K>(scene, ray, &hit, &interaction, media, slack) {
            Crossing::Opaque(hit) => return Some(scene.interaction::<K>(ray, &hit)),
            Crossing::Surface(behind, _) => {
                *beyond = Some(behind);
                return Some(interaction);
            }
            Crossing::Nothing(behind) => {
                recorder.pass(scene, &hit);
                // On with the same ray: nothing is computed anew.
                ray.t_min = hit.t + slack;
                *media = behind;
                hit = scene.intersect::<K>(ray)?;
            }
        }
    }
}
