//! Rectangles of pixels and the sums that are gathered in them.

use super::census::Census;
use super::control::{Control, Wait};
use super::event::{Cut, ErrorChange, TileImage, TileStats};
use super::map::{Look, Map, Window};
use super::pass::{COARSEST, Pass};
use super::pixel::{JUDGED, Pixel};
use super::round::{Round, share_gained};
use crate::description::Filter;
use crate::math::{sample_in_pixel, tent};
use crate::scene::Scene;
use crate::shading::{RayCounts, Sample, Sampler, Scratch};
use glam::DVec2;
use std::time::{Duration, Instant};

/// A rectangle of pixels of the film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
pub const BATCH: usize = 256;

/// Samples that wait to be traced together, and what else a worker keeps so that tracing takes no memory.
#[derive(Debug, Default)]
pub(super) struct Batch {
    /// On the film.
    points: Vec<DVec2>,
    /// The pixel of each point: which of the tiles that are traced together, and its place row by row there.
    pixels: Vec<(u32, u32)>,
    samples: Vec<Sample>,
    scratch: Scratch,
    /// What the pixels looked like before the pass.
    looks: Vec<Look>,
    /// What is seen in and around a tile that is judged.
    window: Window,
    /// Which pixels of a row are to be judged anew.
    stale: Vec<bool>,
    /// Time for judging that no event has told.
    pub untold: Duration,
    /// Pixels of a pass: which, how many samples they have and how many they are to have.
    wanted: Vec<(u32, u32, u32)>,
}

/// What a tile is traced with.
#[derive(Clone, Copy)]
pub(super) struct Tracer<'a> {
    pub scene: &'a Scene,
    pub sampler: Sampler,
    /// How samples are spread over a pixel; `None`: all in its middle.
    pub filter: Option<Filter>,
    pub control: &'a Control,
    /// Whether it is to be known how the samples of a pixel differ.
    pub differences: bool,
}

/// How tracing ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Traced {
    /// All samples are there.
    Whole,
    /// The time is over: some are there.
    Part,
    /// The render is cancelled.
    Cancelled,
}

/// Row and column of the pixels of a tile in blocks of 8 by 8, so that rays traced together are close together.
pub fn blocks(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
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
    /// The pixels of the finest lattice so far, row by row: what no pass has reached takes no memory and no time. (With all
    /// pixels from the beginning, an edit of the demo took 75 ms to be seen whole instead of 44.)
    pixels: Vec<Pixel>,
    /// Pixels between the points of that lattice; 1 when all are there.
    step: u32,
    /// What was last said of its squared error.
    told: Option<f64>,
}

impl Tile {
    /// A rectangle without samples.
    pub fn new(rect: Rect) -> Self {
        Self { rect, pixels: Vec::new(), step: COARSEST, told: None }
    }

    /// Columns and rows of the lattice.
    fn size(&self) -> (u32, u32) {
        (self.rect.width.div_ceil(self.step), self.rect.height.div_ceil(self.step))
    }

    /// Makes room for the points of a lattice, the first or one finer than before.
    fn refine(&mut self, step: u32) {
        let (coarse, factor) = (std::mem::take(&mut self.pixels), (self.step / step) as usize);
        let (coarse_columns, _) = self.size();
        self.step = step;
        let (columns, rows) = self.size();
        self.pixels = vec![Pixel::default(); columns as usize * rows as usize];
        for (row, line) in coarse.chunks(coarse_columns.max(1) as usize).enumerate() {
            for (column, pixel) in line.iter().enumerate() {
                self.pixels[row * factor * columns as usize + column * factor] = *pixel;
            }
        }
    }

    /// Pixels that are on the finest lattice so far.
    pub(super) fn points(&self) -> u64 {
        self.pixels.len() as u64
    }

    /// Its pixels.
    pub fn rect(&self) -> Rect {
        self.rect
    }

    /// Traces the samples of a pass that is the same for every picture.
    pub(super) fn trace(&mut self, tracer: Tracer, pass: Pass, batch: &mut Batch, stats: &mut TileStats) -> Traced {
        Self::trace_together(std::slice::from_mut(self), tracer, pass, batch, stats)
    }

    /// Traces such a pass of several tiles at once: the points of a coarse lattice are so few in a tile that rays would
    /// not come in packets. (The first picture of the demo took 34 ms tile by tile.)
    pub(super) fn trace_together(
        tiles: &mut [Self],
        tracer: Tracer,
        pass: Pass,
        batch: &mut Batch,
        stats: &mut TileStats,
    ) -> Traced {
        let step = if let Pass::Lattice { step } = pass { step } else { 1 };
        let mut work = Work { tracer, batch, stats, start: Instant::now() };
        let mut traced = Traced::Whole;
        for number in 0..tiles.len() {
            let tile = &mut tiles[number];
            // Sums get their memory here, so that starting a render takes none.
            if tile.pixels.is_empty() || step < tile.step {
                tile.refine(step);
            }
            let (Rect { x, y, .. }, (columns, rows)) = (tile.rect, tile.size());
            work.batch.wanted.clear();
            for (row, column) in blocks(columns, rows) {
                let samples = pass.samples_at(x + column * tile.step, y + row * tile.step);
                if !samples.is_empty() {
                    work.batch.wanted.push((row * columns + column, samples.start, samples.end));
                }
            }
            traced = work.add(tiles, number);
            if traced != Traced::Whole {
                break;
            }
        }
        work.end(tiles, traced)
    }

    /// Chooses the pixels of a round of refinement. Whether there are any.
    pub(super) fn choose(&self, round: &Round, batch: &mut Batch) -> bool {
        let Rect { x, y, width, height } = self.rect;
        batch.wanted.clear();
        for (row, column) in blocks(width, height) {
            let at = row * width + column;
            let traced = self.pixels[at as usize].traced();
            let wanted = round.wanted(&self.pixels[at as usize], x + column, y + row);
            if wanted > traced {
                batch.wanted.push((at, traced, wanted));
            }
        }
        !batch.wanted.is_empty()
    }

    /// Traces the samples that are wanted.
    pub(super) fn trace_wanted(&mut self, tracer: Tracer, batch: &mut Batch, stats: &mut TileStats) -> Traced {
        let mut work = Work { tracer, batch, stats, start: Instant::now() };
        let tiles = std::slice::from_mut(self);
        let traced = work.add(tiles, 0);
        work.end(tiles, traced)
    }

    /// Puts down what all pixels look like.
    pub(super) fn write(&self, map: &Map) {
        let Rect { x, y, width, .. } = self.rect;
        for (at, pixel) in (0..).zip(&self.pixels) {
            map.begin(x + at % width, y + at / width, Look::of(pixel));
        }
    }

    /// Puts down what the pixels look like that were traced in a round.
    pub(super) fn note(&mut self, round: &Round, batch: &Batch, census: &mut Census) {
        let Rect { x, y, width, .. } = self.rect;
        for &(at, before, _) in &batch.wanted {
            round.note(&mut self.pixels[at as usize], before, x + at % width, y + at / width, census);
        }
    }

    /// Judges all pixels when all tiles have been traced.
    pub(super) fn judge(&mut self, round: &Round, batch: &mut Batch, census: &mut Census) {
        let Rect { x, y, width, .. } = self.rect;
        let Batch { window, stale, .. } = batch;
        let (mut sum, mut is_there) = (0.0, false);
        for (row, line) in (0..).zip(self.pixels.chunks_mut(width as usize)) {
            stale.clear();
            stale.extend((x..x + width).map(|x| round.map.take_stale(x, y + row)));
            if let Some(first) = stale.iter().position(|stale| *stale) {
                let end = stale.iter().rposition(|stale| *stale).map_or(0, |last| last + 1);
                if !std::mem::replace(&mut is_there, true) {
                    round.map.look_around(self.rect, window);
                }
                window.fit(row as usize, first, end);
            }
            for ((column, pixel), stale) in (0..).zip(line).zip(&*stale) {
                let fit = stale.then(|| window.fits[column as usize]);
                round.judge(pixel, fit, x + column, y + row, census);
                sum += f64::from(pixel.judged);
            }
        }
        self.told = Some(sum);
    }

    /// What was last said of its squared error: about the work that it will be.
    pub(super) fn told(&self) -> f64 {
        self.told.unwrap_or_default()
    }

    /// The errors of all pixels and how their sum of squares has changed in a round that has a plan: what the last census
    /// said, and of pixels that were traced what they say of themselves.
    pub(super) fn errors(&self, round: &Round, batch: &Batch) -> (ErrorChange, Vec<f32>) {
        let mut squares: Vec<f64> = self.pixels.iter().map(|pixel| round.error_before(pixel)).collect();
        let before = squares.iter().sum();
        for &(at, ..) in &batch.wanted {
            squares[at as usize] = round.corrected(self.pixels[at as usize].own);
        }
        let change = ErrorChange { before: Some(before), now: squares.iter().sum() };
        (change, squares.into_iter().map(|square| square.sqrt() as f32).collect())
    }

    /// What was not followed in its pixels.
    pub(super) fn cut(&self) -> Cut {
        self.pixels
            .iter()
            .map(Pixel::cut)
            .fold(Cut::default(), |cut, weight| Cut { sum: cut.sum + weight, largest: cut.largest.max(weight) })
    }

    /// Keeps what the pixels look like before a pass of all pixels.
    pub(super) fn remember(&self, batch: &mut Batch, pass: Pass) {
        batch.looks.clear();
        if matches!(pass, Pass::Refine { to, .. } if to >= JUDGED) {
            batch.looks.extend(self.pixels.iter().map(Look::of));
        }
    }

    /// The errors of all pixels by what they have changed in a pass of all pixels, which is what missed edges do too; and how
    /// the sum of their squares has changed.
    pub(super) fn own_errors(&mut self, batch: &Batch, pass: Pass) -> Option<(ErrorChange, Vec<f32>)> {
        let Pass::Refine { from, to } = pass else { return None };
        if batch.looks.is_empty() {
            return None;
        }
        let gained = share_gained(from, to);
        let (mut now, mut errors) = (0.0, Vec::with_capacity(self.pixels.len()));
        for (pixel, before) in self.pixels.iter().zip(&batch.looks) {
            let error2 = before.distance2(Look::of(pixel)) / gained * (1.0 - gained);
            now += error2;
            errors.push(error2.sqrt() as f32);
        }
        Some((ErrorChange { before: self.told.replace(now), now }, errors))
    }

    /// The pixels as they are known: those of the finest lattice so far, each the mean of its samples.
    pub(super) fn image(&self) -> TileImage {
        let all_finite = self.pixels.iter().all(|pixel| pixel.non_finite() == 0);
        let of_all = |what: fn(&Pixel) -> u32| self.pixels.iter().map(what).collect();
        TileImage {
            rect: self.rect,
            step: self.step,
            pixels: self.pixels.iter().map(|pixel| pixel.mean().to_f32()).collect(),
            samples: of_all(Pixel::traced),
            errors: Vec::new(),
            non_finite: if all_finite { Vec::new() } else { of_all(Pixel::non_finite) },
        }
    }
}

/// Samples on their way into tiles.
struct Work<'a> {
    tracer: Tracer<'a>,
    batch: &'a mut Batch,
    stats: &'a mut TileStats,
    /// When the time began that is not counted yet.
    start: Instant,
}

impl Work<'_> {
    /// Takes in the samples that are wanted of a tile; traces when there are enough.
    fn add(&mut self, tiles: &mut [Tile], number: usize) -> Traced {
        let tile = &tiles[number];
        let (Rect { x, y, .. }, (columns, _), step) = (tile.rect, tile.size(), tile.step);
        let wanted = std::mem::take(&mut self.batch.wanted);
        let mut traced = Traced::Whole;
        'all: for &(at, from, to) in &wanted {
            let (px, py) = (x + at % columns * step, y + at / columns * step);
            for index in from..to {
                self.batch.points.push(film_point(self.tracer.filter, px, py, index));
                self.batch.pixels.push((number as u32, at));
                if self.batch.points.len() == BATCH {
                    traced = self.trace(tiles);
                    if traced != Traced::Whole {
                        break 'all;
                    }
                }
            }
        }
        self.batch.wanted = wanted;
        traced
    }

    /// Traces what is left, if all went well so far.
    fn end(mut self, tiles: &mut [Tile], mut traced: Traced) -> Traced {
        if traced == Traced::Whole {
            traced = self.trace(tiles);
        }
        self.batch.points.clear();
        self.batch.pixels.clear();
        self.stats.busy += self.start.elapsed();
        traced
    }

    /// Traces the samples that wait, and adds them in their order.
    fn trace(&mut self, tiles: &mut [Tile]) -> Traced {
        let Self { tracer: Tracer { scene, sampler, control, differences, .. }, batch, stats, start } = self;
        batch.samples.resize(batch.points.len(), Sample::default());
        stats.rays += loop {
            control.look_at_the_clock();
            let began = control.changes();
            let mut rays = RayCounts::default();
            sampler(scene, &batch.points, &mut batch.samples, &mut rays, &mut batch.scratch, control.stop());
            if control.undisturbed(began) {
                break rays;
            }
            // The samples may not be whole: once awake they are traced again.
            stats.busy += start.elapsed();
            match control.wait() {
                Wait::GoOn => {}
                Wait::Expired => return Traced::Part,
                Wait::Cancelled => return Traced::Cancelled,
            }
            *start = Instant::now();
        };
        stats.samples += batch.points.len() as u64;
        for (&(tile, at), sample) in batch.pixels.iter().zip(&batch.samples) {
            let pixel = &mut tiles[tile as usize].pixels[at as usize];
            if *differences {
                pixel.note(sample);
            }
            if !pixel.add(sample) {
                stats.non_finite += 1;
            }
            stats.overfull += u64::from(sample.overfull);
        }
        batch.points.clear();
        batch.pixels.clear();
        Traced::Whole
    }
}

/// Where on the film sample `index` of a pixel is, in pixels from its upper left corner; without a filter in the pixel's middle.
pub fn film_point(filter: Option<Filter>, x: u32, y: u32, index: u32) -> DVec2 {
    let (u, v) = sample_in_pixel(x, y, index);
    let (u, v) = match filter {
        None => (0.5, 0.5),
        Some(Filter::Box) => (u, v),
        Some(Filter::Tent) => (tent(u), tent(v)),
    };
    DVec2::new(f64::from(x) + u, f64::from(y) + v)
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
