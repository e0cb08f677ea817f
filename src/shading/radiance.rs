//! The recursive function.

use super::crossing::{Crossing, cross, slack};
use super::lit::Begin;
use super::local::add_lights;
use super::media::Media;
use super::onward::Onward;
use super::packet::{Level, Lighting, Path, Scratch};
use super::ray_tree::{Cut, RayKind};
use super::record::Recorder;
use super::sample::{RayCounts, Sample};
use super::sampler::terms;
use super::tail::Tail;
use crate::bvh::{PACKET, TreeKernels};
use crate::geometry::{Ray, SurfaceInteraction};
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
    let Scratch { levels, lighting, onward, media, packets, surfaces, tails, recorder } = scratch;
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
    media.clear();
    for (number, sample) in samples.iter_mut().enumerate() {
        let mut path = Path { sample: number as u32, media: 0, parent: 0, share: 1.0, weight: 1.0 };
        if TERMS & terms::GLASS != 0 {
            let around = scene.media_at_start(first.rays.ray(number).origin);
            sample.overfull = around.is_overfull();
            path.media = media.add::<K>(scene, &around);
        }
        first.paths.push(path);
    }
    first.outside = points.len();
    counts.camera += points.len() as u64;
    let mut tracer =
        Tracer { scene, samples, counts, lighting, onward, media, packets, surfaces, tails, recorder, stop };
    tracer.recorder.begin::<K>(scene, RayKind::Camera, &levels[0], tracer.media);
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
    media: &'a mut Media,
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
        self.counts.shadow += add_lights::<K, TERMS, R>(
            self.scene,
            rows,
            lighting,
            (level, self.media),
            self.packets,
            self.recorder,
            self.stop,
        );
        for (slot, &ray) in rows.ray[..rows.count].iter().enumerate() {
            level.sums[usize::from(ray)] = lighting.lit.sum(slot);
        }
        self.miss(level);
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

    /// Finds what the rays of a packet meet.
    fn intersect<K: TreeKernels>(&mut self, level: &mut Level) {
        let (scene, outside) = (self.scene, level.outside);
        scene.intersect_packet::<K>(&level.rays.first(outside), &mut level.hits[..outside], self.packets);
        let Level { rays, paths, hits, .. } = level;
        let body = |number: usize| self.media.facts(paths[number].media).free;
        scene.leave_packet::<K>(rays, outside..rays.len(), body, hits, self.packets);
    }

    /// Adds what the rays of the first level see to the sums of those that they come from.
    ///
    /// Mirrored and refracted rays apart. All rays of a depth together were fewer and fuller packets, but less alike:
    /// 1.07 of the time on the demo and on the terrain, 1.03 on the field of glass.
    fn follow<K: TreeKernels, const TERMS: u8>(
        &mut self,
        kind: RayKind,
        sums: &mut [Rgb],
        levels: &mut [Level],
        depth: u32,
    ) {
        self.recorder.begin::<K>(self.scene, kind, &levels[0], self.media);
        self.radiance::<K, TERMS>(levels, depth);
        self.recorder.end(&levels[0]);
        for (path, &sum) in levels[0].paths.iter().zip(&levels[0].sums) {
            sums[path.parent as usize] += sum * path.share;
        }
    }

    /// Finds out what is behind the transparent surfaces of a packet, and takes its rays past those that change
    /// nothing.
    #[inline(never)]
    fn cross_glass<K: TreeKernels>(&mut self, level: &mut Level) {
        let scene = self.scene;
        level.beyond.clear();
        level.beyond.resize(level.rays.len(), None);
        for slot in 0..self.surfaces.rows().count {
            let rows = self.surfaces.rows();
            let index = usize::from(rows.ray[slot]);
            let is_glass = rows.material(scene, slot).is_some_and(|material| material.transmit != 0.0);
            let Some(hit) = level.hits[index].filter(|_| is_glass) else { continue };
            let mut interaction = self.surfaces.get(slot, &hit);
            let path = &mut level.paths[index];
            let (mut ray, mut media, mut beyond) = (level.rays.ray(index), *self.media.stack(path.media), None);
            let ends = surface::<K, R>(scene, &mut ray, &mut interaction, &mut media, &mut beyond, self.recorder);
            level.hits[index] = ends.then_some(interaction.hit);
            self.surfaces.set(slot, ends.then_some(&interaction));
            let overfull = media.is_overfull() || beyond.is_some_and(|beyond| beyond.is_overfull());
            self.samples[path.sample as usize].overfull |= overfull;
            if media != *self.media.stack(path.media) {
                path.media = self.media.add::<K>(scene, &media);
            }
            level.beyond[index] = beyond.map(|beyond| self.media.add::<K>(scene, &beyond));
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
        lit.clear();
        let mut start = 0;
        while start < self.surfaces.rows().count {
            let slots = self.surfaces.rows().alike(start);
            let material = self.surfaces.rows().material(scene, start);
            start = slots.end;
            lit.made_of(slots.clone(), material);
            let Some(material) = material else { continue };
            self.surfaces.colors(scene, slots.clone(), material, &level.hits, &mut lit.color);
            if TERMS & terms::MIRRORS != 0 && (material.reflect != 0.0 || material.transmit != 0.0) {
                self.onward.take(slots, material);
            }
        }
        let rows = self.surfaces.rows();
        for slot in 0..rows.count {
            let index = usize::from(rows.ray[slot]);
            let path = &level.paths[index];
            lit.weight[slot] = path.weight;
            let Some(hit) = &level.hits[index] else { continue };
            let normal = (depth == 0).then(|| rows.normal(slot));
            self.samples[path.sample as usize].meet(hit.object, normal, scene.lights.len());
        }
        scene.run(Begin { ambient: scene.world.ambient }, &*self.surfaces, lit);
        for slot in 0..if R::LISTENS { rows.count } else { 0 } {
            let index = usize::from(rows.ray[slot]);
            let Some(hit) = &level.hits[index] else { continue };
            let beyond = beyond::<TERMS>(level, index).map(|beyond| self.media.stack(beyond));
            self.recorder.meet(scene, &self.surfaces.get(slot, hit), lit.get(slot).color, lit.sum(slot), beyond);
        }
    }

    /// Sends on mirrored and refracted rays from the surfaces of a packet.
    #[inline(never)]
    fn branch<K: TreeKernels, const TERMS: u8>(&mut self, level: &mut Level, depth: u32) {
        if depth >= self.scene.render.max_depth {
            return self.end_paths(level);
        }
        let (scene, rows) = (self.scene, self.surfaces.rows());
        let mut is_glass = false;
        for k in 0..self.onward.slots.len() {
            let slot = usize::from(self.onward.slots[k]);
            let number = usize::from(rows.ray[slot]);
            let is_in_media = TERMS & terms::GLASS != 0;
            let media = &*self.media;
            let before = || if is_in_media { media.facts(level.paths[number].media).ior } else { scene.world.ior };
            if let Some(beyond) = beyond::<TERMS>(level, number) {
                self.onward.put_glass(slot, before() / media.facts(beyond).ior);
                is_glass = true;
            } else if let Some(material) = rows.material(scene, slot).filter(|material| material.fresnel) {
                self.onward.put_varnish(slot, before() / material.ior);
            }
        }
        self.onward.divide::<K>(scene, self.surfaces, TERMS & terms::GLASS != 0 && is_glass);
        for branches in [&mut level.reflected, &mut level.refracted] {
            branches.clear();
        }
        for k in 0..self.onward.slots.len() {
            let slot = usize::from(self.onward.slots[k]);
            let index = self.surfaces.rows().ray[slot];
            let number = usize::from(index);
            let Path { sample, media, weight, .. } = level.paths[number];
            if let Some(tail) = self.tails.get_mut(sample as usize) {
                tail.send_on(self.onward.gain(slot));
            }
            let mirrored = self.onward.mirrored(slot);
            let beyond = beyond::<TERMS>(level, number);
            let transmit = self.onward.refracted(slot).filter(|_| is_glass).zip(beyond);
            // A material that gives back more than it gets is weighed by shares, or its ray tree would grow without
            // end.
            let gain = (mirrored + transmit.map_or(0.0, |(weight, _)| weight)).max(1.0);
            let path = |share: f64, media: u32| Path {
                sample,
                media,
                parent: index.into(),
                share,
                weight: weight * (share / gain),
            };
            let is_free = |media: u32| TERMS & terms::GLASS != 0 && self.media.facts(media).free.is_some();
            if let Some((share, beyond)) = transmit {
                let direction = self.onward.refracted_rays().ray(slot).direction;
                level.refracted.push(slot, direction, path(share, beyond), is_free(beyond));
            }
            let (onward, is_free) = (path(mirrored, media), is_free(media));
            if self.worth_it(&onward, RayKind::Reflection) {
                let direction = self.onward.mirrored_rays().ray(slot).direction;
                level.reflected.push(slot, direction, onward, is_free);
            }
        }
        level.reflected.sort(self.onward.mirrored_rays());
        if is_glass {
            level.refracted.sort(self.onward.refracted_rays());
        }
    }

    /// Ends all paths at the surfaces of a packet: they are as long as they may be.
    fn end_paths(&mut self, level: &Level) {
        for k in 0..self.onward.slots.len() {
            let slot = usize::from(self.onward.slots[k]);
            let Path { sample, weight, .. } = level.paths[usize::from(self.surfaces.rows().ray[slot])];
            let gain = self.onward.gain(slot);
            if let Some(tail) = self.tails.get_mut(sample as usize) {
                tail.send_on(gain);
            }
            self.samples[sample as usize].cut += weight * gain;
            self.recorder.cut(Cut { kind: None, weight: weight * gain, depth: true });
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

/// What is behind the surface where a ray ends, if light gets there.
fn beyond<const TERMS: u8>(level: &Level, ray: usize) -> Option<u32> {
    if TERMS & terms::GLASS != 0 { level.beyond[ray] } else { None }
}

/// Takes a ray on to the surface that it ends on, past those that change nothing; `beyond` gets the media behind that,
/// if light gets there. `ray`, `interaction` and `media` are brought to where the ray arrives. Whether there is such a
/// surface.
fn surface<K: TreeKernels, R: Recorder>(
    scene: &Scene,
    ray: &mut Ray,
    interaction: &mut SurfaceInteraction,
    media: &mut MediumStack,
    beyond: &mut Option<MediumStack>,
    recorder: &mut R,
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
                recorder.pass(scene, &hit);
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
