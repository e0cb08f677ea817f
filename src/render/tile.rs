//! Rectangles of pixels and the sums that are gathered in them.

use super::control::Control;
use super::event::{TileImage, TileStats};
use super::pass::{COARSEST, Pass};
use crate::math::{Rgb, sample_in_pixel};
use crate::scene::Scene;
use crate::shading::{RayCounts, Sample, Sampler};
use glam::DVec2;
use std::time::Instant;

/// A rectangle of pixels of the film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// Leftmost column.
    pub x: u32,
    /// Topmost row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Rect {
    /// Pixels in it.
    pub fn area(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Divides a film into tiles of this side (smaller ones at the right and lower edges), the middle first, then outward.
    pub fn spiral(width: u32, height: u32, side: u32) -> Vec<Rect> {
        let mut tiles: Vec<Rect> = (0..height.div_ceil(side))
            .flat_map(|row| (0..width.div_ceil(side)).map(move |column| (column * side, row * side)))
            .map(|(x, y)| Rect { x, y, width: side.min(width - x), height: side.min(height - y) })
            .collect();
        let from_middle = |r: &Rect| {
            let off =
                |start: u32, size: u32, whole: u32| (2 * i64::from(start) + i64::from(size) - i64::from(whole)).pow(2);
            off(r.x, r.width, width) + off(r.y, r.height, height)
        };
        tiles.sort_by_key(from_middle);
        tiles
    }
}

/// Samples that are traced together: enough for packets of rays, few enough to stay in the cache.
const BATCH: usize = 256;

/// Samples that wait to be traced together. One a worker, so that tracing takes no memory.
#[derive(Debug, Default)]
pub(super) struct Batch {
    /// On the film.
    points: Vec<DVec2>,
    /// The pixel of each point, row by row in the tile.
    pixels: Vec<u32>,
    samples: Vec<Sample>,
}

/// Row and column of the pixels of a tile in blocks of 8 by 8, so that rays traced together are close together.
fn blocks(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    const SIDE: u32 = 8;
    let starts = |size: u32| (0..size).step_by(SIDE as usize);
    starts(height).flat_map(move |y| starts(width).map(move |x| (y, x))).flat_map(move |(y, x)| {
        (y..height.min(y + SIDE)).flat_map(move |row| (x..width.min(x + SIDE)).map(move |column| (row, column)))
    })
}

/// One rectangle between passes: the sums of its samples. Moves from worker to worker by value, so that nothing is shared
/// and the samples of a pixel are added in their order, whoever traces them.
#[derive(Debug)]
pub struct Tile {
    rect: Rect,
    sums: Vec<Rgb>,
    counts: Vec<u32>,
}

impl Tile {
    /// A rectangle without samples.
    pub fn new(rect: Rect) -> Self {
        Self { rect, sums: Vec::new(), counts: Vec::new() }
    }

    /// Its pixels.
    pub fn rect(&self) -> Rect {
        self.rect
    }

    /// Traces the samples of one pass; `None` if the render is cancelled meanwhile.
    pub(super) fn trace(
        &mut self,
        scene: &Scene,
        sampler: Sampler,
        pass: Pass,
        batch: &mut Batch,
        control: &Control,
    ) -> Option<TileStats> {
        // Sums get their memory here, so that starting a render takes none.
        self.sums.resize(self.rect.area() as usize, Rgb::BLACK);
        self.counts.resize(self.rect.area() as usize, 0);
        let mut stats = TileStats::default();
        let mut start = Instant::now();
        let Rect { x, y, width, height } = self.rect;
        for (row, column) in blocks(width, height) {
            let (px, py) = (x + column, y + row);
            for index in pass.samples_at(px, py) {
                let (u, v) = sample_in_pixel(px, py, index);
                batch.points.push(DVec2::new(f64::from(px) + u, f64::from(py) + v));
                batch.pixels.push(row * width + column);
                if batch.points.len() == BATCH {
                    self.trace_batch(scene, sampler, batch, control, &mut stats, &mut start)?;
                }
            }
        }
        self.trace_batch(scene, sampler, batch, control, &mut stats, &mut start)?;
        stats.busy += start.elapsed();
        Some(stats)
    }

    /// Traces the samples that wait in `batch`, and adds them in their order.
    fn trace_batch(
        &mut self,
        scene: &Scene,
        sampler: Sampler,
        batch: &mut Batch,
        control: &Control,
        stats: &mut TileStats,
        start: &mut Instant,
    ) -> Option<()> {
        batch.samples.resize(batch.points.len(), Sample::default());
        stats.rays += loop {
            let began = control.changes();
            let mut rays = RayCounts::default();
            sampler(scene, &batch.points, &mut batch.samples, &mut rays, control.stop());
            if control.undisturbed(began) {
                break rays;
            }
            // The samples may not be whole: once awake they are traced again.
            stats.busy += start.elapsed();
            if !control.wait() {
                return None;
            }
            *start = Instant::now();
        };
        stats.samples += batch.points.len() as u64;
        for (&at, sample) in batch.pixels.iter().zip(&batch.samples) {
            if sample.radiance.is_finite() {
                self.sums[at as usize] += sample.radiance;
                self.counts[at as usize] += 1;
            } else {
                stats.non_finite += 1;
            }
        }
        batch.points.clear();
        batch.pixels.clear();
        Some(())
    }

    /// The pixels as they are known after `pass`: the mean of the samples, or that of the nearest lattice point up and left.
    pub(super) fn image(&self, pass: Pass) -> TileImage {
        let Rect { width, height, .. } = self.rect;
        let step = if let Pass::Lattice { step } = pass { step } else { 1 };
        let mean = |column: u32, row: u32| {
            let at = (row * width + column) as usize;
            (self.sums[at] / f64::from(self.counts[at].max(1))).to_f32()
        };
        // Tiles start on the lattice.
        let pixels = (0..height)
            .flat_map(|row| (0..width).map(move |column| (column, row)))
            .map(|(column, row)| mean(column - column % step, row - row % step))
            .collect();
        TileImage { rect: self.rect, pixels }
    }
}

/// Whether tiles of this side start on the coarsest lattice.
pub(super) fn is_valid_side(side: u32) -> bool {
    side > 0 && side.is_multiple_of(COARSEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tiles_of_any_film_cover_every_pixel_once_and_start_in_the_middle() {
        for (width, height) in [(1, 1), (1, 50), (33, 65), (640, 360)] {
            let mut seen = vec![0; (width * height) as usize];
            let tiles = Rect::spiral(width, height, 16);
            for r in &tiles {
                for y in r.y..r.y + r.height {
                    for x in r.x..r.x + r.width {
                        seen[(y * width + x) as usize] += 1;
                    }
                }
            }
            assert!(seen.iter().all(|&n| n == 1), "{width}x{height}");
            let first = tiles[0];
            assert!(first.x <= width / 2 && width / 2 <= first.x + first.width + 8);
        }
    }
}
