//! Which code traces a scene.

use super::packet::Scratch;
use super::radiance::trace;
use super::ray_tree::RayTree;
use super::record::{Recorder, TreeRecorder};
use super::sample::{RayCounts, Sample};
use crate::bvh::TreeKernels;
use crate::description::{Numerics, SceneDesc, Shading};
use crate::geometry::{Classic, Fast, Reference, Robust};
use crate::scene::Scene;
use glam::DVec2;
use std::sync::atomic::AtomicBool;

/// Traces what the camera sees through points of the film, in pixels from its upper left corner, into as many samples.
/// Counts the rays that it takes. What a sample is does not depend on what else is in the slice; some hundred points
/// that are close together are traced quickest.
///
/// The flag ends it early: once it is set, no further packet of rays is traced, and what is returned means nothing.
pub type Sampler<R = ()> = fn(&Scene, &[DVec2], &mut [Sample], &mut RayCounts, &mut Scratch<R>, &AtomicBool);

/// Terms of the lighting equation beyond ambient and diffuse light, a bit each: what the code is compiled for.
pub(super) mod terms {
    pub const HIGHLIGHTS: u8 = 1;
    pub const SHADOWS: u8 = 2;
    pub const MIRRORS: u8 = 4;
    pub const GLASS: u8 = 8;

    pub const PHONG: u8 = HIGHLIGHTS;
    pub const OPAQUE: u8 = HIGHLIGHTS | SHADOWS;
    pub const MIRRORED: u8 = OPAQUE | MIRRORS;
    pub const WHITTED: u8 = MIRRORED | GLASS;
}

/// The sampler for a scene's numerics, lighting model and materials.
pub fn sampler(scene: &Scene) -> Sampler {
    recording_sampler::<()>(scene)
}

/// The same code with a recorder.
pub(super) fn recording_sampler<R: Recorder>(scene: &Scene) -> Sampler<R> {
    match scene.render.numerics {
        Numerics::Classic => for_model::<Classic, R>(scene.render.shading),
        Numerics::Fast => for_scene::<Fast, R>(scene),
        Numerics::Robust => for_scene::<Robust, R>(scene),
        Numerics::Reference => for_model::<Reference, R>(scene.render.shading),
    }
}

/// Traces the sample at a point of the film with the code that renders, and writes down its ray tree. `desc`: what the
/// scene was compiled from, for the names.
pub fn trace_tree(scene: &Scene, desc: &SceneDesc, point: DVec2) -> (Sample, RayTree) {
    let mut scratch = Scratch::with(TreeRecorder::new(desc));
    let (mut sample, mut counts, stop) = ([Sample::default()], RayCounts::default(), AtomicBool::new(false));
    recording_sampler(scene)(scene, &[point], &mut sample, &mut counts, &mut scratch, &stop);
    let tree = scratch.recorder.finish().expect("a tracer that is not stopped ends what it begins");
    (sample[0], tree)
}

/// Code without what the scene does not have: 1.08 times as fast without mirrors and glass, 1.01 to 1.03 without glass.
/// Without textures it was no faster (0.96 to 1.04 of the time, meshes and sphereflake: noise); smooth normals, meshes
/// and the other shapes are told apart once a packet (see `scene::Surfaces`), and lights are gone through once a
/// packet, so nothing can be had there.
fn for_scene<K: TreeKernels, R: Recorder>(scene: &Scene) -> Sampler<R> {
    match scene.render.shading {
        Shading::Whitted if scene.has_media() => trace::<K, { terms::WHITTED }, R>,
        Shading::Whitted if scene.materials.iter().any(|m| m.reflect != 0.0) => trace::<K, { terms::MIRRORED }, R>,
        Shading::Whitted => trace::<K, { terms::OPAQUE }, R>,
        local => for_model::<K, R>(local),
    }
}

/// Code that serves every scene.
fn for_model<K: TreeKernels, R: Recorder>(shading: Shading) -> Sampler<R> {
    match shading {
        Shading::Lambert => trace::<K, 0, R>,
        Shading::Phong => trace::<K, { terms::PHONG }, R>,
        Shading::Whitted => trace::<K, { terms::WHITTED }, R>,
    }
}
