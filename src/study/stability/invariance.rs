//! S15 to S17: what must not change a picture.

use super::scenes::{ModelFile, NUMERICS, apart, compile, mixed, pictures, v};
use super::sweep::{Row, Sweep};
use super::trials::{Effort, Tally};
use super::triangles::icosphere;
use crate::description::{LightKind, SceneDesc};
use crate::render::{self, Film, RenderEvent, Settings};
use crate::scene::Scene;
use crate::shading::Sample;
use glam::DVec3;
use std::num::NonZeroUsize;
use std::sync::Arc;

fn model() -> ModelFile {
    ModelFile::new(&icosphere(2))
}

/// The scene of these experiments, larger in haste's absence.
fn scene(effort: &Effort, k: f64, offset: DVec3, model: &ModelFile) -> SceneDesc {
    let mut desc = mixed(k, offset, model.path());
    (desc.film.width, desc.film.height) = effort.choose((64, 48), (256, 192));
    desc
}

/// Part of the pixels in which two sets of pictures differ.
fn changed(
    right: &[Vec<Sample>; 4],
    pictures: &[Vec<Sample>; 4],
    differ: fn(&Sample, &Sample) -> bool,
    place: impl Fn(usize) -> usize,
) -> Tally {
    let mut tally = Tally::default();
    for pixel in 0..right[0].len() {
        tally.judge([0, 1, 2, 3].map(|k| differ(&right[k][pixel], &pictures[k][place(pixel)])));
    }
    tally
}

fn other_bits(a: &Sample, b: &Sample) -> bool {
    let bits = |s: &Sample| [s.radiance.r, s.radiance.g, s.radiance.b].map(f64::to_bits);
    bits(a) != bits(b)
}

/// The scene in a mirror: x to -x.
pub fn mirrored(desc: &SceneDesc) -> SceneDesc {
    let mut desc = desc.clone();
    let flip = v(-1.0, 1.0, 1.0);
    desc.camera.position *= flip;
    desc.camera.look_at *= flip;
    desc.camera.up *= flip;
    for object in &mut desc.objects {
        object.translate *= flip;
        object.scale *= flip;
        object.rotate *= v(1.0, -1.0, -1.0);
    }
    for light in &mut desc.lights {
        match &mut light.kind {
            LightKind::Point { position, .. } => *position *= flip,
            LightKind::Directional { direction } => *direction *= flip,
        }
    }
    desc
}

/// S15: all lengths times a power of two; the scene in a mirror.
pub fn equivariance(effort: &Effort) -> Vec<Sweep> {
    let model = model();
    let right = pictures(effort, &scene(effort, 1.0, DVec3::ZERO, &model));
    let scaled = |sign: i32| {
        [1, 5, 10, 20, 40].map(|exponent| {
            let desc = scene(effort, 2f64.powi(sign * exponent), DVec3::ZERO, &model);
            let tally = changed(&right, &pictures(effort, &desc), other_bits, |pixel| pixel);
            Row::rates(2f64.powi(exponent), &tally, 0.0)
        })
    };
    let (larger, smaller) = (scaled(1).to_vec(), scaled(-1).to_vec());
    let desc = scene(effort, 1.0, DVec3::ZERO, &model);
    let width = desc.film.width as usize;
    let across = |pixel: usize| pixel / width * width + (width - 1 - pixel % width);
    let tally = changed(&right, &pictures(effort, &mirrored(&desc)), apart, across);
    vec![
        Sweep::new("larger: pixels with other bits", "factor", larger),
        Sweep::new("smaller: pixels with other bits", "1 / factor", smaller),
        Sweep::new("mirrored: pixels off", "mirrors", vec![Row::rates(1.0, &tally, 0.0)]),
    ]
}

/// S16: everything, the camera too, away from the origin.
pub fn translation(effort: &Effort) -> Vec<Sweep> {
    let model = model();
    let right = pictures(effort, &scene(effort, 1.0, DVec3::ZERO, &model));
    let rows = (0..=7).map(|exponent| {
        let offset = 10f64.powi(exponent);
        let desc = scene(effort, 1.0, v(0.6, -0.5, 0.62) * offset, &model);
        let tally = changed(&right, &pictures(effort, &desc), apart, |pixel| pixel);
        let row = Row::rates(offset, &tally, 0.0);
        // Beyond a million sizes nothing is promised.
        if exponent > 6 { Row { threshold: None, ..row } } else { row }
    });
    vec![Sweep::new("pixels off", "offset / size", rows.collect())]
}

/// The finished picture of a render; with pauses between its events.
fn film(scene: &Arc<Scene>, threads: usize, tile_size: u32, pauses: u32) -> Film {
    let threads = NonZeroUsize::new(threads).unwrap_or(NonZeroUsize::MIN);
    let handle = render::start(Arc::clone(scene), Settings { threads, tile_size });
    let mut film = Film::new(scene.width, scene.height);
    let mut left = pauses;
    for event in handle.events() {
        if left > 0 {
            left -= 1;
            handle.pause();
            std::thread::yield_now();
            handle.resume();
        }
        match event {
            RenderEvent::TileFinished { tile, .. } => film.write(&tile),
            RenderEvent::Failed(error) => panic!("a render of the study failed: {error}"),
            _ => {}
        }
    }
    film
}

/// S17: threads, tiles and pauses.
pub fn determinism(effort: &Effort) -> Vec<Sweep> {
    let model = model();
    let mut desc = scene(effort, 1.0, DVec3::ZERO, &model);
    desc.render.samples = effort.choose(2, 9);
    let scenes = NUMERICS.map(|numerics| {
        desc.render.numerics = numerics;
        Arc::new(compile(&desc, None))
    });
    let right = scenes.each_ref().map(|scene| film(scene, 1, 64, 0));
    let rows = |settings: &[(f64, usize, u32, u32)]| {
        let rows = settings.iter().map(|&(difficulty, threads, tile_size, pauses)| {
            let films = scenes.each_ref().map(|scene| film(scene, threads, tile_size, pauses));
            let mut tally = Tally::default();
            for pixel in 0..right[0].pixels().len() {
                let bits = |film: &Film| film.pixels()[pixel].map(f32::to_bits);
                tally.judge([0, 1, 2, 3].map(|k| bits(&films[k]) != bits(&right[k])));
            }
            Row::rates(difficulty, &tally, 0.0)
        });
        rows.collect()
    };
    let differ = "pixels with other bits";
    vec![
        Sweep::new(differ, "threads", rows(&[(2.0, 2, 32, 0), (3.0, 3, 32, 0), (16.0, 16, 32, 0), (64.0, 64, 32, 0)])),
        Sweep::new(
            differ,
            "pixels / tile",
            rows(&[(1e3, 2, 1024, 0), (1e4, 2, 128, 0), (1e5, 2, 24, 0), (1e6, 2, 8, 0)]),
        ),
        Sweep::new(differ, "pauses", rows(&[(1.0, 2, 32, 1), (10.0, 2, 16, 10), (100.0, 3, 8, 100)])),
    ]
}
