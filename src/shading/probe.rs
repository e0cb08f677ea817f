//! What else than light can be told of a pixel.

use super::packet::Scratch;
use super::record::TreeRecorder;
use super::sample::{RayCounts, Sample};
use super::sampler::{Sampler, recording_sampler, sampler};
use crate::bvh::TreeKernels;
use crate::description::Numerics;
use crate::geometry::{Classic, Fast, Ray, Reference, Robust};
use crate::math::Rgb;
use crate::scene::Scene;
use glam::DVec2;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// What to tell of the ray through a point of the film.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Probe {
    /// Unit shading normal where the ray ends, world space, on the viewer's side.
    Normals,
    /// Distance along the ray, scene units.
    Depth,
    /// Texture coordinates without their whole parts, and 1.
    Uv,
    /// 1 + index of the `[[object]]`.
    Object,
    /// 1 + index of the material in [`Scene::materials`].
    Material,
    /// Rays that the sample takes, of all kinds.
    Rays,
    /// Nodes and leaves of the hierarchies that those rays look at, each traced alone.
    Visits,
    /// Microseconds that the sample takes when it is traced alone: the least of [`TRIALS`].
    Time,
}

/// How often a time is measured.
const TRIALS: u32 = 3;

/// A [`Sampler`] whose samples hold as radiance what the probe tells: in all channels, or three numbers. All of it is 0
/// where the ray of a probe that asks for a surface meets nothing. What renders stays free of all this.
pub fn probe_sampler(scene: &Scene, probe: Probe) -> Sampler {
    match scene.render.numerics {
        Numerics::Classic => with::<Classic>(probe),
        Numerics::Fast => with::<Fast>(probe),
        Numerics::Robust => with::<Robust>(probe),
        Numerics::Reference => with::<Reference>(probe),
    }
}

fn with<K: TreeKernels>(probe: Probe) -> Sampler {
    match probe {
        Probe::Normals => trace::<K, { Probe::Normals as u8 }>,
        Probe::Depth => trace::<K, { Probe::Depth as u8 }>,
        Probe::Uv => trace::<K, { Probe::Uv as u8 }>,
        Probe::Object => trace::<K, { Probe::Object as u8 }>,
        Probe::Material => trace::<K, { Probe::Material as u8 }>,
        Probe::Rays => trace::<K, { Probe::Rays as u8 }>,
        Probe::Visits => trace::<K, { Probe::Visits as u8 }>,
        Probe::Time => trace::<K, { Probe::Time as u8 }>,
    }
}

fn trace<K: TreeKernels, const PROBE: u8>(
    scene: &Scene,
    points: &[DVec2],
    samples: &mut [Sample],
    counts: &mut RayCounts,
    scratch: &mut Scratch,
    stop: &AtomicBool,
) {
    let mut recording = Scratch::with(TreeRecorder::without_names());
    for (point, sample) in points.iter().zip(samples) {
        if stop.load(Ordering::Relaxed) {
            return;
        }
        *sample = Sample::default();
        let point = std::slice::from_ref(point);
        let one = std::slice::from_mut(sample);
        sample_value::<K, PROBE>(scene, point, one, counts, (scratch, &mut recording), stop);
    }
}

fn sample_value<K: TreeKernels, const PROBE: u8>(
    scene: &Scene,
    point: &[DVec2],
    sample: &mut [Sample],
    counts: &mut RayCounts,
    (scratch, recording): (&mut Scratch, &mut Scratch<TreeRecorder>),
    stop: &AtomicBool,
) {
    const RAYS: u8 = Probe::Rays as u8;
    const VISITS: u8 = Probe::Visits as u8;
    const TIME: u8 = Probe::Time as u8;
    let value = match PROBE {
        RAYS => {
            let mut rays = RayCounts::default();
            sampler(scene)(scene, point, sample, &mut rays, scratch, stop);
            *counts += rays;
            Rgb::grey(rays.total() as f64)
        }
        VISITS => {
            recording_sampler(scene)(scene, point, sample, counts, recording, stop);
            recording.recorder.finish().map_or(Rgb::BLACK, |tree| Rgb::grey(tree.all_visits() as f64))
        }
        TIME => {
            let sampler = sampler(scene);
            let mut once = || {
                let begun = Instant::now();
                sampler(scene, point, sample, counts, scratch, stop);
                begun.elapsed().as_secs_f64()
            };
            Rgb::grey(1e6 * (0..TRIALS).map(|_| once()).fold(f64::MAX, f64::min))
        }
        _ => {
            counts.camera += 1;
            first_hit::<K, PROBE>(scene, point[0])
        }
    };
    sample[0] = Sample { radiance: value, ..Sample::default() };
}

fn first_hit<K: TreeKernels, const PROBE: u8>(scene: &Scene, point: DVec2) -> Rgb {
    const NORMALS: u8 = Probe::Normals as u8;
    const DEPTH: u8 = Probe::Depth as u8;
    const UV: u8 = Probe::Uv as u8;
    const OBJECT: u8 = Probe::Object as u8;
    let ray = Ray { t_min: K::T_MIN, ..scene.camera.ray(point.x, point.y) };
    let Some(hit) = scene.intersect::<K>(&ray) else { return Rgb::BLACK };
    let interaction = scene.interaction::<K>(&ray, &hit);
    match PROBE {
        NORMALS => {
            let n = interaction.shading_normal * if interaction.entering { 1.0 } else { -1.0 };
            Rgb::new(n.x, n.y, n.z)
        }
        DEPTH => Rgb::grey(hit.t),
        UV => {
            let uv = scene.uv(&hit, interaction.point);
            Rgb::new(uv.x.rem_euclid(1.0), uv.y.rem_euclid(1.0), 1.0)
        }
        OBJECT => Rgb::grey(f64::from(scene.objects()[hit.object as usize].source) + 1.0),
        _ => Rgb::grey(f64::from(interaction.material) + 1.0),
    }
}
