//! Rectangles of pixels and the sums that are gathered in them.

use super::census::{Census, Group};
use super::control::{Control, Wait};
use super::event::{Cut, ErrorChange, TileImage, TileStats};
use super::map::{Codes, Look, Map, Window};
use super::pass::{COARSEST, Pass};
use super::pixel::Pixel;
use super::round::{Round, Seen, share_gained};
use super::scatter::{JUDGED, Scatter};
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
    /// How the samples of each of them differ, if that is to be known.
    scatters: Vec<Scatter>,
    /// What the last census made of each of them; empty before the first. Rounds look at nothing else of most pixels. (With all
    /// numbers of a pixel in one place, walking over them took about 5 % of the time of a render of the demo to an error of 1.)
    groups: Vec<Group>,
    /// What the pixels looked like after the last pass that is judged by what it changes.
    codes: Vec<Codes>,
    /// Pixels between the points of that lattice; 1 when all are there.
    step: u32,
    /// What was last said of its squared error.
    told: Option<f64>,
    /// Whether the error of each pixel has been told.
    has_told_errors: bool,
    /// What was not followed in its pixels.
    cut: Cut,
}

impl Tile {
    /// A rectangle without samples.
    pub fn new(rect: Rect) -> Self {
        Self {
            rect,
            pixels: Vec::new(),
            scatters: Vec::new(),
            groups: Vec::new(),
            codes: Vec::new(),
            step: COARSEST,
            told: None,
            has_told_errors: false,
            cut: Cut::default(),
        }
    }

    /// Columns and rows of the lattice.
    fn size(&self) -> (u32, u32) {
        (self.rect.width.div_ceil(self.step), self.rect.height.div_ceil(self.step))
    }

    /// Makes room for the points of a lattice, the first or one finer than before.
    fn refine(&mut self, step: u32, differences: bool) {
        let factor = (self.step / step) as usize;
        let (coarse_columns, _) = self.size();
        self.step = step;
        let (columns, rows) = self.size();
        self.pixels = spread(&self.pixels, coarse_columns, (columns, rows), factor);
        if differences {
            self.scatters = spread(&self.scatters, coarse_columns, (columns, rows), factor);
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
                tile.refine(step, tracer.differences);
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
        blocks(width, height).for_each(|(row, column)| {
            let (at, x, y) = (row * width + column, x + column, y + row);
            let group = self.groups[at as usize];
            if round.looks_into(group, x, y) {
                let traced = self.pixels[at as usize].traced();
                let wanted = round.wanted(group, traced, x, y);
                if wanted > traced {
                    batch.wanted.push((at, traced, wanted));
                }
            }
        });
        !batch.wanted.is_empty()
    }

    /// Traces the samples that are wanted.
    pub(super) fn trace_wanted(&mut self, tracer: Tracer, batch: &mut Batch, stats: &mut TileStats) -> Traced {
        let cut = |tile: &Self, batch: &Batch| {
            batch
                .wanted
                .iter()
                .map(|&(at, ..)| tile.pixels[at as usize].cut())
                .fold((0.0, 0.0f64), |(sum, largest), cut| (sum + cut, largest.max(cut)))
        };
        let before = cut(self, batch);
        let mut work = Work { tracer, batch, stats, start: Instant::now() };
        let tiles = std::slice::from_mut(self);
        let traced = work.add(tiles, 0);
        let traced = work.end(tiles, traced);
        let (sum, largest) = cut(self, batch);
        if before.1 > 0.0 && before.1 >= self.cut.largest {
            self.count_cut();
        } else {
            self.cut = Cut { sum: (self.cut.sum + sum - before.0).max(0.0), largest: self.cut.largest.max(largest) };
        }
        traced
    }

    /// Puts down what all pixels look like.
    pub(super) fn write(&self, map: &Map) {
        let Rect { x, y, width, .. } = self.rect;
        for (at, (pixel, scatter)) in (0..).zip(self.pixels.iter().zip(&self.scatters)) {
            map.begin(x + at % width, y + at / width, Look::of(pixel, scatter));
        }
    }

    /// Puts down what the pixels look like that were traced in a round.
    pub(super) fn note(&mut self, round: &Round, batch: &Batch, census: &mut Census) {
        let Rect { x, y, width, .. } = self.rect;
        for &(at, before, _) in &batch.wanted {
            round.note(&mut self.seen(at), before, (x + at % width, y + at / width), census);
        }
    }

    /// One of its pixels.
    fn seen(&mut self, at: u32) -> Seen<'_> {
        let at = at as usize;
        Seen { pixel: &self.pixels[at], scatter: &mut self.scatters[at], group: &mut self.groups[at] }
    }

    /// Judges the pixels that may be other than before, when all tiles have been traced.
    pub(super) fn judge(&mut self, round: &Round, batch: &mut Batch, census: &mut Census) {
        let Rect { x, y, width, height } = self.rect;
        let Batch { window, stale, .. } = batch;
        let is_first = self.groups.is_empty();
        self.groups.resize(self.pixels.len(), Group::default());
        let (mut change, mut is_there) = (0.0, false);
        for row in 0..height {
            let Some(range) = round.map.take_stale(x, y + row, width, stale) else { continue };
            if !std::mem::replace(&mut is_there, true) {
                round.map.look_around(self.rect, window);
            }
            window.fit(row as usize, range.start, range.end);
            for column in range.filter(|column| stale[*column]) {
                let mut seen = self.seen(row * width + column as u32);
                let before = f64::from(seen.scatter.judged);
                if !is_first {
                    census.remove(*seen.group, before);
                }
                round.judge(&mut seen, window.fits[column], (x + column as u32, y + row), census);
                change += f64::from(seen.scatter.judged) - before;
            }
        }
        self.told = Some(self.told() + change);
    }

    /// What was last said of its squared error: about the work that it will be.
    pub(super) fn told(&self) -> f64 {
        self.told.unwrap_or_default()
    }

    /// What a round has made of the tile: if these are few, the pixels that were traced. In rounds that have a plan errors are
    /// told too, for the first time of all pixels, and how those of the traced ones have changed: from what the last census said to
    /// what they say of themselves.
    pub(super) fn refined(&mut self, round: &Round, batch: &Batch) -> (TileImage, Option<ErrorChange>) {
        let traced = || batch.wanted.iter().map(|&(at, ..)| at as usize);
        let is_part = self.has_told_errors == round.plan.is_some() && batch.wanted.len() < self.pixels.len() / 2;
        let mut image = self.image(is_part.then(|| batch.wanted.iter().map(|&(at, ..)| at).collect()));
        if round.plan.is_none() {
            return (image, None);
        }
        self.has_told_errors = true;
        let before = |at: usize| round.error_before(&self.scatters[at], self.groups[at]);
        let now = |at: usize| round.corrected(self.scatters[at].own);
        let root = |square: f64| square.sqrt() as f32;
        image.errors = match is_part {
            true => traced().map(|at| root(now(at))).collect(),
            false => (0..self.pixels.len()).map(|at| root(before(at))).collect(),
        };
        if !is_part {
            traced().for_each(|at| image.errors[at] = root(now(at)));
        }
        (image, Some(ErrorChange { before: Some(traced().map(before).sum()), now: traced().map(now).sum() }))
    }

    /// What was not followed in its pixels, counted anew.
    pub(super) fn count_cut(&mut self) -> Cut {
        self.cut = self
            .pixels
            .iter()
            .map(Pixel::cut)
            .fold(Cut::default(), |cut, weight| Cut { sum: cut.sum + weight, largest: cut.largest.max(weight) });
        self.cut
    }

    /// What was not followed in its pixels.
    pub(super) fn cut(&self) -> Cut {
        self.cut
    }

    /// Sees to it that what the pixels look like is known before a pass of all pixels.
    pub(super) fn remember(&mut self, pass: Pass) {
        if self.codes.is_empty() && matches!(pass, Pass::Refine { to, .. } if to >= JUDGED) {
            self.codes = self.pixels.iter().map(Codes::of).collect();
        }
    }

    /// The errors of all pixels by what they have changed in a pass of all pixels, which is what missed edges do too; and how
    /// the sum of their squares has changed.
    pub(super) fn own_errors(&mut self, pass: Pass) -> Option<(ErrorChange, Vec<f32>)> {
        let Pass::Refine { from, to } = pass else { return None };
        if self.codes.is_empty() {
            return None;
        }
        let gained = share_gained(from, to);
        let (mut now, mut errors) = (0.0, Vec::with_capacity(self.pixels.len()));
        for (pixel, codes) in self.pixels.iter().zip(&mut self.codes) {
            let before = std::mem::replace(codes, Codes::of(pixel));
            let error2 = before.distance2(*codes) / gained * (1.0 - gained);
            now += error2;
            errors.push(error2.sqrt() as f32);
        }
        Some((ErrorChange { before: self.told.replace(now), now }, errors))
    }

    /// The pixels as they are known, each the mean of its samples: these, or all of the finest lattice so far.
    pub(super) fn image(&self, points: Option<Vec<u32>>) -> TileImage {
        let mut image = TileImage { rect: self.rect, step: self.step, ..TileImage::default() };
        match &points {
            None => image.take(self.pixels.iter()),
            Some(points) => image.take(points.iter().map(|at| &self.pixels[*at as usize])),
        }
        TileImage { points, ..image }
    }
}

impl TileImage {
    fn take<'a>(&mut self, pixels: impl Iterator<Item = &'a Pixel> + Clone) {
        self.pixels = pixels.clone().map(|pixel| pixel.mean().to_f32()).collect();
        self.samples = pixels.clone().map(Pixel::traced).collect();
        if pixels.clone().any(|pixel| pixel.non_finite() > 0) {
            self.non_finite = pixels.map(Pixel::non_finite).collect();
        }
    }
}

/// The points of a lattice of this size, of which those of a coarser one are known.
fn spread<T: Copy + Default>(coarse: &[T], coarse_columns: u32, (columns, rows): (u32, u32), factor: usize) -> Vec<T> {
    let mut fine = vec![T::default(); columns as usize * rows as usize];
    for (row, line) in coarse.chunks(coarse_columns.max(1) as usize).enumerate() {
        for (column, point) in line.iter().enumerate() {
            fine[row * factor * columns as usize + column * factor] = *point;
        }
    }
    fine
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
            let Tile { pixels, scatters, .. } = &mut tiles[tile as usize];
            let pixel = &mut pixels[at as usize];
            if *differences {
                scatters[at as usize].note(pixel, sample);
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
