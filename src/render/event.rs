//! What workers report.

use super::{Pass, Rect};
use crate::shading::RayCounts;
use std::fmt;
use std::time::Duration;

/// One report of a running render. Events of one tile come in order.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "half of all events are of the large one: a box would be taken for each")]
pub enum RenderEvent {
    /// A worker begins with a tile.
    TileStarted {
        /// Index of the worker.
        worker: usize,
        /// Its pixels.
        rect: Rect,
        /// The samples being traced.
        pass: Pass,
    },
    /// A worker is done with one pass over a tile.
    TileFinished {
        /// Index of the worker.
        worker: usize,
        /// Pixels as they are known now.
        tile: TileImage,
        /// What it took.
        stats: TileStats,
        /// The samples that were traced.
        pass: Pass,
    },
    /// A round of refinement is over, and how wrong the picture still is was judged from all of it.
    Estimated {
        /// Root mean square of the sampling error, 8-bit codes.
        error: f64,
    },
    /// Every tile has got all its samples, the error is small enough or the time is over; the last event.
    Finished,
    /// A worker panicked; the render is over.
    Failed(RenderError),
}

/// What is known of the pixels of a tile, to be put into a film.
#[derive(Clone, Debug, PartialEq)]
pub struct TileImage {
    /// Where they belong.
    pub rect: Rect,
    /// Pixels between the points of the lattice that is known, from the upper left corner on; 1 when all are.
    pub step: u32,
    /// The points that are told here, by their numbers row by row; `None`: all of them. Where few have changed, these
    /// are told.
    pub points: Option<Vec<u32>>,
    /// Linear radiance at the points, row by row. Pixels between them show that of the nearest point up and left.
    pub pixels: Vec<[f32; 3]>,
    /// Samples at each of the points so far.
    pub samples: Vec<u32>,
    /// Expected error at each of the points, 8-bit codes: root mean square over the channels. Empty as long as nothing
    /// can be said.
    pub errors: Vec<f32>,
    /// Samples at each of the points that were not finite. Empty if all are.
    pub non_finite: Vec<u32>,
}

impl Default for TileImage {
    /// Without pixels, which are to be all of them.
    fn default() -> Self {
        Self {
            rect: Rect::default(),
            step: 1,
            points: None,
            pixels: Vec::new(),
            samples: Vec::new(),
            errors: Vec::new(),
            non_finite: Vec::new(),
        }
    }
}

impl TileImage {
    /// Points in a row of the lattice.
    pub fn columns(&self) -> u32 {
        self.rect.width.div_ceil(self.step)
    }

    /// The pixel of the film that is the point told at this index: column and row.
    pub fn place(&self, index: usize) -> (u32, u32) {
        let point = self.points.as_ref().map_or(index as u32, |points| points[index]);
        let (row, column) = (point / self.columns(), point % self.columns());
        (self.rect.x + column * self.step, self.rect.y + row * self.step)
    }
}

/// What one pass over one tile took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TileStats {
    /// Samples traced.
    pub samples: u64,
    /// Rays traced, by kind.
    pub rays: RayCounts,
    /// Samples whose radiance was not finite: counted and left out of the picture.
    pub non_finite: u64,
    /// Samples with a ray inside of more transparent bodies than are kept track of.
    pub overfull: u64,
    /// Time spent tracing. Tiles that were traced together share it evenly; the rays and what was not finite are told
    /// with the first of them.
    pub busy: Duration,
    /// When it was done, since the start of the render; of tiles that were traced together, as if one after the other.
    pub done: Duration,
    /// Sum over the pixels of their expected squared error in 8-bit codes, mean over the channels; of those that are
    /// told, if these are not all. `None` as long as nothing can be said.
    pub squared_error: Option<ErrorChange>,
    /// Weight of the paths that were not followed, and of what lights may be wrong by that were not asked for: sum over
    /// the pixels, and that of the worst pixel. Times
    /// [`Scene::largest_radiance`](crate::scene::Scene::largest_radiance) it bounds what they would add.
    pub cut: Cut,
}

/// Sum over pixels of a tile of their expected squared errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorChange {
    /// Before the pass; `None` if nothing could be said.
    pub before: Option<f64>,
    /// After it.
    pub now: f64,
}

/// Weight of paths that were not followed and of lights that were not asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cut {
    /// Summed over pixels.
    pub sum: f64,
    /// Of the pixel that lacks most.
    pub largest: f64,
}

/// Why a render stopped before its end.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderError {
    /// The worker that failed.
    pub worker: usize,
    /// What its panic said.
    pub message: String,
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "render thread {} failed: {} (this is a bug in glimt)", self.worker, self.message)
    }
}

impl std::error::Error for RenderError {}
