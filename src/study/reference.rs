//! The picture that others are measured against, kept between studies.

use super::machine::program;
use super::metrics::rmse;
use super::{Console, StudyError, render};
use crate::description::{Numerics, RenderDesc, SceneDesc, ShapeDesc, TextureSource, builtin};
use crate::output::write_whole;
use crate::render::{Film, Pass, RenderEvent, Settings};
use crate::scene::{Scene, compile};
use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use xxhash_rust::xxh3::{xxh3_64, xxh3_64_with_seed};

/// A converged picture.
pub(super) struct Reference {
    /// The picture.
    pub film: Film,
    /// Samples of every pixel.
    pub samples: u32,
    /// Where its ray trees were cut.
    pub max_depth: u32,
    /// Estimate of its own root mean square error, 8-bit codes.
    pub error: f64,
    /// Whether it was made earlier.
    pub cached: bool,
}

/// Part of the smallest error measured against it that a reference's own error may be.
const PART: f64 = 0.1;

/// The scene in `reference` numerics, with ray trees of this depth and so many samples that its own error is a tenth of
/// that of the best of `probes`, the most accurate pictures of the study (of `samples` a pixel), or the power of two up
/// to `most` samples.
pub(super) fn reference(
    desc: &SceneDesc,
    base: &Scene,
    probes: &[Film],
    max_depth: u32,
    (samples, most): (u32, u32),
    cache: &Path,
    console: &Console,
) -> Result<Reference, StudyError> {
    // A quarter of the samples must be the end of a pass: from 16 on powers of two are.
    let most = 1 << most.max(64).ilog2();
    let file = cache.join(format!("reference-{:016x}.bin", key(desc, max_depth)?));
    let apart =
        |found: &Reference| probes.iter().filter_map(|probe| rmse(probe, &found.film)).fold(f64::INFINITY, f64::min);
    let is_enough = |found: &Reference| found.error <= PART * apart(found);
    if let Some(found) = load(&file, max_depth).filter(|found| is_enough(found) || found.samples >= most) {
        return Ok(found);
    }
    let mut samples = (16 * samples).max(64).next_power_of_two().min(most);
    loop {
        let render_desc = RenderDesc { numerics: Numerics::Reference, max_depth, samples, error: None, ..desc.render };
        let scene = Arc::new(compile(&SceneDesc { render: render_desc, ..desc.clone() }, Some(base))?);
        let begun = Instant::now();
        let total = u64::from(samples) * u64::from(scene.width) * u64::from(scene.height);
        // What it was with a quarter and with half of the samples.
        let mut before = [4, 2].map(|part| (samples / part, Film::new(scene.width, scene.height)));
        let (mut told, mut done) = (Ok(()), 0);
        let trial = render(&scene, Settings::default(), console, |event| {
            if let RenderEvent::TileFinished { tile, stats, pass, .. } = event {
                done += stats.samples;
                if told.is_ok() {
                    told = console.step(0, 0, Part { samples, done, total, gone: begun.elapsed() });
                }
                let ends_here = |samples: u32| matches!(pass, Pass::Refine { to, .. } if *to == samples);
                if let Some((_, film)) = before.iter_mut().find(|(samples, _)| ends_here(*samples)) {
                    film.write(tile);
                }
            }
        })?;
        told?;
        let [(_, quarter), (_, half)] = &before;
        let distances =
            [rmse(quarter, half), rmse(half, &trial.film)].map(|distance| distance.unwrap_or(f64::INFINITY));
        let error = own_error(distances);
        let found = Reference { film: trial.film, samples, max_depth, error, cached: false };
        if is_enough(&found) || samples >= most {
            fs::create_dir_all(cache).map_err(|e| {
                io::Error::new(e.kind(), format!("cannot make the directory {} for references: {e}", cache.display()))
            })?;
            write_whole(&file, &store(&found))?;
            return Ok(found);
        }
        samples = (2 * samples).min(most);
    }
}

/// How far a reference is.
struct Part {
    samples: u32,
    done: u64,
    total: u64,
    gone: Duration,
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = self.done as f64 / self.total.max(1) as f64;
        write!(f, "reference of {} samples, {:.0} %", self.samples, (100.0 * part).floor())?;
        if part > 0.01 {
            write!(f, ", about {:.0} s left", self.gone.as_secs_f64() * (1.0 - part) / part)?;
        }
        Ok(())
    }
}

/// The root mean square error of a picture, from the distance of those with a quarter and half of its samples, and that
/// of the last from itself.
///
/// With V(n) = c n^-p for the mean square of the error, and samples that do not know of the error of those before, the
/// squares of these are V(n/4) - V(n/2) and V(n/2) - V(n), the first 2^p times the second. p is 1 for independent
/// samples and larger for those that complement each other as those of a Sobol' sequence do; no more than 2 is
/// believed.
fn own_error([quarter, half]: [f64; 2]) -> f64 {
    let falls = (quarter / half).powi(2);
    // Not a number where nothing changes.
    half / (if falls > 2.0 { falls.min(4.0) } else { 2.0 } - 1.0).sqrt()
}

/// A hash of everything that the picture depends on: the description, the models and pictures that it names, and this
/// very program.
fn key(desc: &SceneDesc, max_depth: u32) -> io::Result<u64> {
    let mut files = BTreeSet::new();
    for object in &desc.objects {
        if let ShapeDesc::Mesh { file, .. } = &object.shape {
            files.insert(file.clone());
            // What a model may name beside it.
            if let Ok(beside) = fs::read_dir(file.parent().filter(|p| *p != Path::new("")).unwrap_or(Path::new("."))) {
                files.extend(beside.flatten().map(|entry| entry.path()).filter(|path| is_asset(path)));
            }
        }
    }
    for material in &desc.materials {
        if let Some(TextureSource::Image { file, .. }) = material.texture.as_ref().map(|texture| &texture.source) {
            files.insert(file.clone());
        }
    }
    let render = RenderDesc { numerics: Numerics::Reference, max_depth, samples: 0, error: None, ..desc.render };
    let mut hash = xxh3_64(format!("{:?}", SceneDesc { render, ..desc.clone() }).as_bytes());
    for file in files {
        let content = match builtin(&file) {
            Some(content) => content.to_vec(),
            None => fs::read(&file)?,
        };
        hash = xxh3_64_with_seed(&content, hash);
    }
    Ok(xxh3_64_with_seed(&program()?.to_le_bytes(), hash))
}

fn is_asset(path: &Path) -> bool {
    let endings = ["mtl", "png", "jpg", "jpeg", "bmp", "tga"];
    path.is_file() && path.extension().is_some_and(|e| endings.iter().any(|known| e.eq_ignore_ascii_case(known)))
}

/// What a file of a reference begins with; its numbers are little-endian.
const MAGIC: &[u8; 16] = b"glimt reference\n";

/// Magic, hash of the rest, samples, width, height, error, pixels.
fn store(reference: &Reference) -> Vec<u8> {
    let mut rest = Vec::new();
    for number in [reference.samples, reference.film.width(), reference.film.height()] {
        rest.extend(number.to_le_bytes());
    }
    rest.extend(reference.error.to_le_bytes());
    rest.extend(reference.film.pixels().iter().flatten().flat_map(|channel| channel.to_le_bytes()));
    let mut bytes = MAGIC.to_vec();
    bytes.extend(xxh3_64(&rest).to_le_bytes());
    bytes.extend(rest);
    bytes
}

/// `None` if there is no file or it is not whole.
fn load(file: &Path, max_depth: u32) -> Option<Reference> {
    let bytes = fs::read(file).ok()?;
    let (hash, rest) = bytes.strip_prefix(MAGIC)?.split_first_chunk::<8>()?;
    if xxh3_64(rest) != u64::from_le_bytes(*hash) {
        return None;
    }
    let (samples, rest) = rest.split_first_chunk::<4>()?;
    let (width, rest) = rest.split_first_chunk::<4>()?;
    let (height, rest) = rest.split_first_chunk::<4>()?;
    let (error, rest) = rest.split_first_chunk::<8>()?;
    let channels = rest.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
    let pixels = channels.collect::<Vec<_>>().as_chunks::<3>().0.to_vec();
    let (width, height) = (u32::from_le_bytes(*width), u32::from_le_bytes(*height));
    (pixels.len() as u64 == u64::from(width) * u64::from(height)).then(|| Reference {
        film: Film::of_pixels(width, height, pixels),
        samples: u32::from_le_bytes(*samples),
        max_depth,
        error: f64::from_le_bytes(*error),
        cached: true,
    })
}

/// Where references are kept unless told otherwise: the user's cache, as the XDG base directory specification has it.
pub fn default_cache() -> PathBuf {
    let directory = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    directory("XDG_CACHE_HOME")
        .or_else(|| directory("HOME").map(|home| home.join(".cache")))
        .unwrap_or_else(std::env::temp_dir)
        .join("glimt")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_stored_is_loaded_and_what_is_damaged_is_not() {
        let pixels = (0..12).map(|i| [i as f32, 0.5, -1.0]).collect();
        let film = Film::of_pixels(4, 3, pixels);
        let bytes = store(&Reference { film: film.clone(), samples: 64, max_depth: 16, error: 0.25, cached: false });
        let file = std::env::temp_dir().join(format!("glimt-reference-{}", std::process::id()));
        let load_from = |bytes: &[u8]| {
            fs::write(&file, bytes).unwrap();
            let found = load(&file, 16);
            fs::remove_file(&file).unwrap();
            found
        };
        let found = load_from(&bytes).unwrap();
        assert_eq!((found.film, found.samples, found.error, found.cached), (film, 64, 0.25, true));
        for end in [0, 10, 24, 60, bytes.len() - 1] {
            assert!(load_from(&bytes[..end]).is_none(), "{end}");
        }
        let mut flipped = bytes.clone();
        flipped[70] ^= 1;
        assert!(load_from(&flipped).is_none());
        assert!(load(&file, 16).is_none());
    }

    #[test]
    fn the_error_of_a_picture_follows_from_what_its_samples_have_changed() {
        for p in [1.0, 1.5, 2.0] {
            let v = |n: f64| 9.0 * n.powf(-p);
            let distance = |from: f64, to: f64| (v(from) - v(to)).sqrt();
            let error = own_error([distance(256.0, 512.0), distance(512.0, 1024.0)]);
            assert!((error / v(1024.0).sqrt() - 1.0).abs() < 1e-9, "{p}: {error}");
        }
        // What falls faster or slower than believed is taken for worse than it says; nothing that changes is no error.
        assert_eq!(own_error([10.0, 1.0]), 3f64.sqrt().recip());
        assert_eq!(own_error([1.0, 1.0]), 1.0);
        assert_eq!(own_error([0.0, 0.0]), 0.0);
        assert_eq!(own_error([f64::INFINITY; 2]), f64::INFINITY);
    }

    #[test]
    fn how_far_a_reference_is_is_told_with_what_is_left() {
        let part = |done| Part { samples: 1024, done, total: 1000, gone: Duration::from_secs(30) }.to_string();
        assert_eq!(part(3), "reference of 1024 samples, 0 %");
        assert_eq!(part(250), "reference of 1024 samples, 25 %, about 90 s left");
    }

    #[test]
    fn the_key_depends_on_the_scene_but_not_on_what_the_reference_overrides() {
        let desc = SceneDesc::default();
        let key_of = |change: fn(&mut SceneDesc)| {
            let mut changed = desc.clone();
            change(&mut changed);
            key(&changed, 16).unwrap()
        };
        let own = key_of(|_| {});
        assert_eq!(own, key_of(|desc| desc.render.samples = 99));
        assert_eq!(own, key_of(|desc| desc.render.numerics = Numerics::Fast));
        assert_ne!(own, key_of(|desc| desc.film.width += 1));
        assert_ne!(own, key_of(|desc| desc.camera.position.x += 1e-9));
        assert_ne!(own, key(&desc, 17).unwrap());
    }
}
