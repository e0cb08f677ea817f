//! What a render was and took, for people and for programs.

use super::meter::span;
use super::{Rendered, memory};
use crate::bvh::BvhStats;
use crate::description::printable;
use crate::render::{Progress, Settings, View};
use crate::scene::{Imported, Scene};
use serde::Serialize;
use std::fmt;
use std::path::Path;
use std::time::{Duration, Instant};

/// Everything worth knowing about a finished render. As JSON (`--json`) its fields are the object's, times in
/// seconds; [`fmt::Display`] is one line for people.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Of glimt.
    pub version: &'static str,
    /// The scene as it was named.
    pub scene: String,
    /// Where the picture went.
    pub output: String,
    /// What the picture shows.
    pub view: &'static str,
    /// Of a view that shows a quantity: what the first and the last colour stand for.
    pub scale: Option<[f32; 2]>,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Samples a pixel; the most that one may get if there is an error to reach.
    pub samples: u32,
    /// Samples that a pixel got, on average.
    pub samples_per_pixel: f64,
    /// What paths that were not followed lack.
    pub cut: CutReport,
    /// How samples make a pixel.
    pub filter: &'static str,
    /// Where rendering was to end: root mean square of the sampling error in 8-bit codes; `null`: at `samples`. 0:
    /// never.
    pub error_target: Option<f64>,
    /// Seconds after which rendering was to end.
    pub time_limit: Option<f64>,
    /// Estimated root mean square of the sampling error, 8-bit codes; `null` where there are too few samples to tell.
    pub error: Option<f64>,
    /// Seconds that it would yet take to `error_target`, at least and at most: 0 if it is reached; `null` if that is
    /// never or can not be told.
    pub seconds_to_target: Option<[f64; 2]>,
    /// Lighting model.
    pub shading: &'static str,
    /// What glass does to shadow rays.
    pub shadows: &'static str,
    /// Arithmetic.
    pub numerics: &'static str,
    /// Reflections and refractions along a path.
    pub max_depth: u32,
    /// Worker threads.
    pub threads: usize,
    /// Instruction set.
    pub isa: &'static str,
    /// Side of a tile, pixels.
    pub tile_size: u32,
    /// Wall time.
    pub seconds: Seconds,
    /// Rays traced.
    pub rays: Rays,
    /// Rays of all kinds over the seconds of tracing.
    pub rays_per_second: f64,
    /// What each worker did.
    pub workers: Vec<Worker>,
    /// Samples left out because they were not finite.
    pub non_finite: u64,
    /// Samples with a ray inside of more transparent bodies at once than are kept track of: some were passed over.
    pub overfull_media: u64,
    /// The command that shows the rays of the first pixel with such a sample; `null` if there is none.
    pub explain: Option<String>,
    /// The most memory that the process ever held; `null` where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
    /// Hash (XXH3, 64 bits, hexadecimal) of size and linear pixels: equal for bit-identical pictures.
    pub pixel_hash: String,
    /// What the scene has.
    pub contents: Contents,
    /// The tree over the objects.
    pub tree: Tree,
    /// What importing each model found.
    pub imports: Vec<Import>,
    /// Things that are probably not meant, and what models name that is missing or ignored.
    pub warnings: Vec<String>,
}

/// Paths that were not followed, for their depth or because they weigh too little, and what they can add at most.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct CutReport {
    /// Their weight together, mean over the pixels.
    pub mean_weight: f64,
    /// Of the pixel that lacks most.
    pub largest_weight: f64,
    /// The largest radiance that the scene can have; `null` if it sets no limit: where a material has k_r + k_t >= 1,
    /// or a light that falls off with distance may touch a surface.
    pub largest_radiance: Option<f64>,
    /// What they add at most, in linear light: mean over the pixels; `null` if nothing bounds it.
    pub mean_bound: Option<f64>,
    /// The same of the pixel that lacks most.
    pub largest_bound: Option<f64>,
}

impl CutReport {
    fn new(scene: &Scene, progress: &Progress) -> Self {
        let (cut, bound) = (progress.cut(), progress.cut_bound());
        Self {
            mean_weight: cut.sum,
            largest_weight: cut.largest,
            largest_radiance: scene.largest_radiance,
            mean_bound: bound.map(|bound| bound.sum),
            largest_bound: bound.map(|bound| bound.largest),
        }
    }
}

/// Wall time in seconds.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Seconds {
    /// Reading the scene file, models and pictures.
    pub load: f64,
    /// Building trees.
    pub build: f64,
    /// To the first whole picture, from the start of tracing.
    pub first_picture: f64,
    /// Tracing.
    pub trace: f64,
    /// Encoding and writing the picture.
    pub save: f64,
    /// From the start of the program to the end of saving.
    pub total: f64,
}

/// Rays by kind.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Rays {
    /// From the eye.
    pub camera: u64,
    /// To lights.
    pub shadow: u64,
    /// Mirrored.
    pub reflection: u64,
    /// Through glass.
    pub refraction: u64,
    /// All of them.
    pub total: u64,
}

/// What one thread did.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Worker {
    /// Seconds spent tracing.
    pub busy_seconds: f64,
    /// Tile passes finished.
    pub tiles: u64,
    /// Rays traced.
    pub rays: u64,
}

/// What the scene has.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Contents {
    /// `[[object]]` entries.
    pub objects: usize,
    /// Analytic shapes.
    pub primitives: usize,
    /// Triangles, each mesh once.
    pub triangles: usize,
    /// Triangles, every instance counted.
    pub instanced_triangles: usize,
    /// Lights.
    pub lights: usize,
    /// Materials.
    pub materials: usize,
    /// Pictures used as textures.
    pub textures: usize,
}

/// What importing one model found.
#[derive(Clone, Debug, Serialize)]
pub struct Import {
    /// Path of the model.
    pub file: String,
    /// Triangles kept.
    pub triangles: usize,
    /// Triangles dropped because they have no area.
    pub dropped_degenerate: usize,
    /// What was computed, ignored or not found.
    pub notes: Vec<String>,
    /// The tree over its triangles.
    pub tree: Tree,
}

/// A tree of boxes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Tree {
    /// Objects or triangles.
    pub primitives: usize,
    /// Inner nodes, of up to eight children.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Longest way from the root to a leaf, in nodes.
    pub depth: usize,
    /// How full the blocks of the leaves are, from 0 to 1.
    pub fill: f64,
    /// Expected tests of nodes and blocks that a random ray through the tree's box costs.
    pub sah_cost: f32,
    /// Nodes, and the blocks of triangles.
    pub bytes: usize,
    /// The same over the primitives.
    pub bytes_per_primitive: f64,
}

impl Tree {
    fn new(stats: &BvhStats) -> Self {
        Self {
            primitives: stats.primitives,
            nodes: stats.nodes,
            leaves: stats.leaves,
            depth: stats.depth,
            fill: stats.fill,
            sah_cost: stats.sah_cost,
            bytes: stats.bytes,
            bytes_per_primitive: stats.bytes_per_primitive(),
        }
    }
}

impl Report {
    /// `file`: where the scene came from; `output`: where the picture went.
    pub fn new(
        scene: &Scene,
        rendered: &Rendered,
        settings: Settings,
        (view, time_limit): (View, Option<Duration>),
        file: &Path,
        output: &Path,
        seconds: Seconds,
    ) -> Self {
        let (summary, progress, rays) = (&scene.summary, &rendered.progress, rendered.progress.rays);
        let imports = summary.imports.iter().map(|Imported { file, report, tree }| Import {
            file: file.to_string_lossy().into_owned(),
            triangles: report.triangles,
            dropped_degenerate: report.dropped_degenerate,
            notes: report.normals.iter().chain(&report.notes).cloned().collect(),
            tree: Tree::new(tree),
        });
        let workers = progress.workers.iter().map(|worker| Worker {
            busy_seconds: worker.busy.as_secs_f64(),
            tiles: worker.tiles,
            rays: worker.rays,
        });
        Self {
            version: env!("CARGO_PKG_VERSION"),
            scene: file.to_string_lossy().into_owned(),
            output: output.to_string_lossy().into_owned(),
            view: view.name(),
            scale: rendered.scale.map(|scale| [scale.low, scale.high]),
            size: [scene.width, scene.height],
            samples: scene.render.samples,
            samples_per_pixel: rays.camera as f64 / (f64::from(scene.width) * f64::from(scene.height)),
            cut: CutReport::new(scene, progress),
            filter: scene.render.filter.name(),
            error_target: scene.render.error,
            time_limit: time_limit.map(|limit| limit.as_secs_f64()),
            error: progress.error(),
            seconds_to_target: (scene.render.error.filter(|target| *target > 0.0))
                .and_then(|target| progress.until(target, Instant::now()))
                .map(|eta| [eta.low.as_secs_f64(), eta.high.as_secs_f64()]),
            shading: scene.render.shading.name(),
            shadows: scene.render.shadows.name(),
            numerics: scene.render.numerics.name(),
            max_depth: scene.render.max_depth,
            threads: settings.threads.get(),
            isa: scene.isa().name(),
            tile_size: settings.tile_size,
            seconds,
            rays: Rays {
                camera: rays.camera,
                shadow: rays.shadow,
                reflection: rays.reflection,
                refraction: rays.refraction,
                total: rays.total(),
            },
            rays_per_second: rays.total() as f64 / seconds.trace.max(1e-9),
            workers: workers.collect(),
            non_finite: progress.non_finite,
            overfull_media: progress.overfull,
            explain: None,
            peak_memory_bytes: memory::peak(),
            pixel_hash: format!("{:016x}", rendered.film.hash()),
            contents: Contents {
                objects: summary.objects,
                primitives: summary.primitives,
                triangles: summary.triangles,
                instanced_triangles: summary.instanced_triangles,
                lights: summary.lights,
                materials: summary.materials,
                textures: summary.textures,
            },
            tree: Tree::new(&summary.tree),
            imports: imports.collect(),
            warnings: summary.warnings.clone(),
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        let samples = match self.samples_per_pixel {
            mean if self.error_target.is_some() || self.time_limit.is_some() => format!("{mean:.1} samples"),
            _ if self.samples == 1 => "1 sample".to_owned(),
            _ => format!("{} samples", self.samples),
        };
        let error = self.error.map_or(String::new(), |error| format!(", error {error:.2} of 255"));
        write!(
            f,
            "saved {}: {width}x{height}, {samples} a pixel{error}, in {}; {} rays, {} a second",
            printable(&self.output),
            span(Duration::try_from_secs_f64(self.seconds.total).unwrap_or_default()),
            many(self.rays.total as f64),
            many(self.rays_per_second),
        )
    }
}

/// A large number in three figures: "950", "12.3 k", "4.56 M", "7.89 G".
fn many(number: f64) -> String {
    let (scaled, unit) = match number {
        n if n < 999.5 => return format!("{n:.0}"),
        n if n < 999.5e3 => (n / 1e3, "k"),
        n if n < 999.5e6 => (n / 1e6, "M"),
        n => (n / 1e9, "G"),
    };
    let digits = if scaled < 9.995 { 2 } else { usize::from(scaled < 99.95) };
    format!("{scaled:.digits$} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_numbers_have_three_figures() {
        let shown = [0.0, 7.0, 999.4, 999.6, 1234.0, 99_949.0, 99_951.0, 999_499.0, 999_501.0, 2.5e9].map(many);
        let expected =
            ["0", "7", "999", "1.00 k", "1.23 k", "99.9 k", "100 k", "999 k", "1.00 M", "2.50 G"].map(String::from);
        assert_eq!(shown, expected);
    }
}
