//! The recursive function.

use super::crossing::{Crossing, cross, slack};
use super::lit::Begin;
use super::local::add_lights;
use super::onward::Onward;
use super::packet::{Level, Lighting, Path, Scratch};
use super::ray_tree::{Cut, RayKind};
use super::record::{Recorder, SurfaceEnd};
use super::sample::{RayCounts, Sample};
use super::sampler::terms;
use super::tail::Tail;
use crate::bvh::{PACKET, TreeKernels};
use crate::geometry::{Hit, Ray, SurfaceInteraction};
use crate::math::Rgb;
use crate::scene::{MediumStack, PacketScratch, Scene, Surfaces};
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
    for (points, samples) in points.chunks(PACKET).zip(samples.chunks_mut(PACKET)) {
        trace_packet::<K, TERMS, R>(scene, points, samples, counts, scratch, stop);
    }
}

/// The same for no more samples than rays go into a packet. Every ray sends on one of a kind at most, so that no packet
/// that follows is larger than the first.
fn trace_packet<K: TreeKernels, const TERMS: u8, R: Recorder>(
    scene: &Scene,
    points: &[DVec2],
    samples: &mut [Sample],
    counts: &mut RayCounts,
    scratch: &mut Scratch<R>,
    stop: &AtomicBool,
) {
    let Scratch { levels, lighting, onward, packets, surfaces, tails, recorder } = scratch;
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
    scene.primary_rays(K::T_MIN, points, &mut first.rays);
    for sample in 0..points.len() {
        if TERMS & terms::GLASS != 0 {
            first.media.push(scene.media_at_start(first.rays.ray(sample).origin));
        }
        first.paths.push(Path::of(sample as u32));
    }
    first.outside = points.len();
    counts.camera += points.len() as u64;
    let mut tracer = Tracer { scene, samples, counts, lighting, onward, packets, surfaces, tails, recorder, stop };
    tracer.recorder.begin::<K>(scene, &levels[0]);
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
    onward: &'a mut Onward,
    packets: &'a mut PacketScratch,
    surfaces: &'a mut Surfaces,
    /// Empty if nothing that matters is cut.
    tails: &'a mut [Tail],
    recorder: &'a mut R,
    stop: &'a AtomicBool,
}

impl<R: Recorder> Tracer<'_, R> {
    /// What the rays of the first level see, which have been reflected and refracted `depth` times. The other levels
    /// are room for what follows.
    fn radiance<K: TreeKernels, const TERMS: u8>(&mut self, levels: &mut [Level], depth: u32) {
        let Some((level, deeper)) = levels.split_first_mut() else { return };
        // Each is written when its ray ends.
        level.sums.resize(level.rays.len(), Rgb::BLACK);
        if level.rays.is_empty() || self.stop.load(Ordering::Relaxed) {
            return;
        }
        level.hits.resize(level.rays.len(), None);
        self.intersect::<K>(level);
        self.scene.surfaces::<K>(&level.rays.all(), &level.hits, self.surfaces);
        if TERMS & terms::GLASS != 0 {
            self.cross_glass::<K>(level);
        }
        self.meet::<TERMS>(level, depth);
        if TERMS & terms::MIRRORS != 0 {
            self.branch::<K, TERMS>(level, depth);
        }
        let (rows, lighting) = (self.surfaces.rows(), &mut *self.lighting);
        self.counts.shadow +=
            add_lights::<K, TERMS, R>(self.scene, rows, lighting, level, self.packets, self.recorder, self.stop);
        for (slot, &ray) in rows.ray[..rows.count].iter().enumerate() {
            level.sums[usize::from(ray)] = lighting.lit.sum(slot);
        }
        self.miss(level);
        if TERMS & terms::MIRRORS != 0 && !self.tails.is_empty() {
            for (path, &own) in level.paths.iter().zip(&level.sums) {
                self.tails[path.sample as usize].meet(own);
            }
        }
        if TERMS & terms::MIRRORS != 0 && !deeper.is_empty() {
            for packet in 0..level.branches.sort() {
                deeper[0].take(level, packet);
                self.recorder.begin::<K>(self.scene, &deeper[0]);
                self.radiance::<K, TERMS>(deeper, depth + 1);
                self.recorder.end(&deeper[0]);
                deeper[0].give(&mut level.branches);
            }
            level.branches.add(&mut level.sums);
        }
    }

    /// Finds what the rays of a packet meet.
    fn intersect<K: TreeKernels>(&mut self, level: &mut Level) {
        let (scene, outside) = (self.scene, level.outside);
        scene.intersect_packet::<K>(&level.rays.first(outside), &mut level.hits[..outside], self.packets);
        for number in outside..level.rays.len() {
            let ray = &level.rays.ray(number);
            let exit = level.media[number].only().and_then(|body| scene.exit::<K>(ray, body));
            level.hits[number] = exit.or_else(|| scene.intersect::<K>(ray));
        }
    }

    /// Finds out what is behind the transparent surfaces of a packet, and takes its rays past those that change
    /// nothing.
    #[inline(never)]
    fn cross_glass<K: TreeKernels>(&mut self, level: &mut Level) {
        let scene = self.scene;
        level.beyond.clear();
        level.beyond.resize(level.rays.len(), None);
        for (media, path) in level.media.iter().zip(&level.paths) {
            self.samples[path.sample as usize].overfull |= media.is_overfull();
        }
        for slot in 0..self.surfaces.rows().count {
            let rows = self.surfaces.rows();
            let index = usize::from(rows.ray[slot]);
            let is_glass = rows.material(scene, slot).is_some_and(|material| material.transmit != 0.0);
            let Some(hit) = level.hits[index].filter(|_| is_glass) else { continue };
            let mut interaction = self.surfaces.get(slot, &hit);
            let (mut ray, media) = (level.rays.ray(index), &mut level.media[index]);
            let beyond = &mut level.beyond[index];
            let pass = |hit: &Hit| self.recorder.pass(scene, index, hit);
            let ends = surface::<K>(scene, &mut ray, &mut interaction, media, beyond, pass);
            level.hits[index] = ends.then_some(interaction.hit);
            self.surfaces.set(slot, ends.then_some(&interaction));
            let overfull = media.is_overfull() || beyond.is_some_and(|beyond| beyond.is_overfull());
            self.samples[level.paths[index].sample as usize].overfull |= overfull;
        }
    }

    /// Gives rays that meet nothing the background.
    fn miss(&mut self, level: &mut Level) {
        let hits = level.hits.iter().enumerate();
        for (index, _) in hits.filter(|(_, hit)| hit.is_none()) {
            level.sums[index] = self.scene.background(level.rays.ray(index).direction);
            self.samples[level.paths[index].sample as usize].cost += 1;
        }
    }

    /// Finds out what the surfaces of a packet are made of, and shades them as far as each can be done alone: ambient
    /// light.
    #[inline(never)]
    fn meet<const TERMS: u8>(&mut self, level: &mut Level, depth: u32) {
        let (scene, lit) = (self.scene, &mut *self.lighting.lit);
        self.onward.slots.clear();
        let mut start = 0;
        while start < self.surfaces.rows().count {
            let slots = self.surfaces.rows().alike(start);
            let material = self.surfaces.rows().material(scene, start);
            start = slots.end;
            lit.made_of(slots.clone(), material);
            let Some(material) = material else { continue };
            self.surfaces.colors(scene, slots.clone(), material, &level.hits, &mut lit.color);
            if TERMS & terms::MIRRORS != 0 {
                self.onward.take(slots, material);
            }
        }
        let rows = self.surfaces.rows();
        for (ray, (path, hit)) in level.paths.iter().zip(&level.hits).enumerate() {
            let (Some(slot), Some(hit)) = (rows.slot(ray), hit) else { continue };
            lit.weight[slot] = path.weight;
            let normal = (depth == 0).then(|| rows.normal(slot));
            self.samples[path.sample as usize].meet(hit.object, path.way, normal, scene.lights.len());
        }
        scene.run(Begin { ambient: scene.world.ambient }, &*self.surfaces, lit);
        for slot in 0..if R::LISTENS { rows.count } else { 0 } {
            let index = usize::from(rows.ray[slot]);
            let Some(hit) = &level.hits[index] else { continue };
            let beyond = level.beyond.get(index).and_then(Option::as_ref);
            let (interaction, color, ambient) = (self.surfaces.get(slot, hit), lit.get(slot).color, lit.sum(slot));
            self.recorder.meet(scene, index, SurfaceEnd { interaction, color, ambient, beyond });
        }
    }

    /// Sends on mirrored and refracted rays from the surfaces of a packet.
    #[inline(never)]
    fn branch<K: TreeKernels, const TERMS: u8>(&mut self, level: &mut Level, depth: u32) {
        level.branches.clear(level.rays.len());
        if depth >= self.scene.render.max_depth {
            return self.end_paths(level);
        }
        let (scene, rows) = (self.scene, self.surfaces.rows());
        let mut is_glass = false;
        for k in 0..self.onward.slots.len() {
            let slot = usize::from(self.onward.slots[k]);
            let number = usize::from(rows.ray[slot]);
            let before = || level.media.get(number).map_or(scene.world.ior, |media| media.ior(scene));
            if let Some(beyond) = level.beyond.get(number).and_then(Option::as_ref) {
                self.onward.put_glass(slot, before() / beyond.ior(scene));
                is_glass = true;
            } else if let Some(material) = rows.material(scene, slot).filter(|material| material.fresnel) {
                self.onward.put_varnish(slot, before() / material.ior);
            }
        }
        self.onward.divide::<K>(scene, self.surfaces, TERMS & terms::GLASS != 0 && is_glass);
        // By ray, since a sample's rays are in an order of its own.
        for index in 0..level.paths.len() {
            let Some(slot) = self.surfaces.rows().slot(index).filter(|&slot| self.onward.has(slot)) else { continue };
            let Path { sample, way, weight, .. } = level.paths[index];
            if let Some(tail) = self.tails.get_mut(sample as usize) {
                tail.send_on(self.onward.gain(slot));
            }
            let beyond = level.beyond.get(index).and_then(Option::as_ref);
            let mirrored = self.onward.mirrored(slot);
            let transmit = self.onward.refracted(slot).filter(|_| is_glass).zip(beyond);
            // A material that gives back more than it gets is weighed by shares, or its ray tree would grow without
            // end.
            let gain = (mirrored + transmit.map_or(0.0, |(weight, _)| weight)).max(1.0);
            let path = |share: f64, way: u32| Path {
                sample,
                parent: index as u32,
                way,
                share,
                weight: weight * (share / gain),
            };
            // Whether a ray has only to find the way out of a body.
            let inside = |media: &MediumStack| media.only().is_some_and(|body| scene.is_free::<K>(body));
            let onward = path(mirrored, way << 1);
            if self.worth_it(index, &onward, RayKind::Reflection) {
                let media = level.media.get(index);
                let direction = self.onward.mirrored_rays().ray(slot).direction;
                level.branches.push(slot, direction, onward, media.is_some_and(inside));
                self.counts.reflection += 1;
            }
            if let Some((share, beyond)) = transmit {
                let onward = path(share, way << 1 | 1);
                if self.worth_it(index, &onward, RayKind::Refraction) {
                    let direction = self.onward.refracted_rays().ray(slot).direction;
                    level.branches.push(slot, direction, onward, inside(beyond));
                    self.counts.refraction += 1;
                }
            }
        }
        self.onward.give(&mut level.branches.mirrored, &mut level.branches.refracted);
    }

    /// Ends all paths at the surfaces of a packet: they are as long as they may be.
    fn end_paths(&mut self, level: &Level) {
        for (index, &Path { sample, weight, .. }) in level.paths.iter().enumerate() {
            let Some(slot) = self.surfaces.rows().slot(index).filter(|&slot| self.onward.has(slot)) else { continue };
            let gain = self.onward.gain(slot);
            if let Some(tail) = self.tails.get_mut(sample as usize) {
                tail.send_on(gain);
            }
            self.samples[sample as usize].cut += weight * gain;
            self.recorder.cut(index, Cut { kind: None, weight: weight * gain, depth: true });
        }
    }

    /// Whether a path from the surface where a ray ends is worth following; if not, its weight is noted.
    fn worth_it(&mut self, ray: usize, path: &Path, kind: RayKind) -> bool {
        let worth_it = path.weight >= self.scene.least_weight;
        if !worth_it {
            self.samples[path.sample as usize].cut += path.weight;
            if let Some(tail) = self.tails.get_mut(path.sample as usize) {
                tail.cut(path.weight);
            }
            self.recorder.cut(ray, Cut { kind: Some(kind), weight: path.weight, depth: false });
        }
        worth_it
    }
}

/// Takes a ray on to the surface that it ends on, past those that change nothing; `beyond` gets the media behind that,
/// if light gets there, `pass` hears of those. `ray`, `interaction` and `media` are brought to where the ray arrives.
/// Whether there is such a surface.
fn surface<K: TreeKernels>(
    scene: &Scene,
    ray: &mut Ray,
    interaction: &mut SurfaceInteraction,
    media: &mut MediumStack,
    beyond: &mut Option<MediumStack>,
    mut pass: impl FnMut(&Hit),
) -> bool {
    while scene.materials[interaction.material as usize].transmit != 0.0 {
        let SurfaceInteraction { hit, geometric_normal, point_error, material, entering, .. } = *interaction;
        let slack = slack(ray, &hit, geometric_normal, point_error);
        let behind = beyond.insert(*media);
        match cross::<K>(scene, ray, &hit, (material, entering), behind, slack) {
            Crossing::Opaque(hit) => {
                *beyond = None;
                *interaction = scene.interaction::<K>(ray, &hit);
                return true;
            }
            Crossing::Surface(_) => return true,
            Crossing::Nothing => {
                pass(&hit);
                // On with the same ray: nothing is computed anew.
                ray.t_min = hit.t + slack;
                *media = *behind;
                *beyond = None;
                let Some(hit) = scene.intersect::<K>(ray) else { return false };
                *interaction = scene.interaction::<K>(ray, &hit);
            }
        }
    }
    true
}
