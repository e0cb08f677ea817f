//! Samples of pixels of one tile or several that are traced together.

use super::control::{Control, Wait};
use super::event::TileStats;
use super::map::Window;
use super::points::FilmPoints;
use super::tile::Tile;
use crate::description::Filter;
use crate::scene::Scene;
use crate::shading::{RayCounts, Sample, Sampler, Scratch};
use std::time::{Duration, Instant};

/// Samples that are traced together: enough for packets of rays, few enough to stay in the cache. (Refined to 1.2
/// codes, 128 took 0.6 % more instructions on the demo and 0.4 % fewer on the sphereflake; 1024, with packets as large,
/// 0.6 and 4 % more.)
pub const BATCH: usize = 256;

/// Samples that wait to be traced together, and what else a worker keeps so that tracing takes no memory.
#[derive(Debug)]
pub(super) struct Batch {
    points: FilmPoints,
    /// The pixels that they belong to, one after the other.
    runs: Vec<Run>,
    samples: Vec<Sample>,
    scratch: Scratch,
    /// What is seen in and around a tile that is judged.
    pub window: Window,
    /// Which pixels of a row are to be judged anew.
    pub stale: Vec<bool>,
    /// Time for judging that no event has told.
    pub untold: Duration,
    /// The pixels that get samples, tile by tile.
    pub wanted: Vec<Wanted>,
}

/// Samples of one pixel that follow each other.
#[derive(Clone, Copy, Debug)]
struct Run {
    /// Which of the tiles that are traced together, and the place row by row there.
    tile: u32,
    at: u32,
    count: u32,
}

/// A pixel that gets samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// Which of the tiles that are traced together, and the place row by row there.
    pub tile: u32,
    pub at: u32,
    /// How many samples it has and is to have.
    pub before: u32,
    pub after: u32,
}

impl Batch {
    /// An empty one that traces in this room.
    pub fn new(scratch: Scratch) -> Self {
        Self {
            points: FilmPoints::default(),
            runs: Vec::new(),
            samples: Vec::new(),
            scratch,
            window: Window::default(),
            stale: Vec::new(),
            untold: Duration::ZERO,
            wanted: Vec::new(),
        }
    }

    /// The room that it has traced in.
    pub fn into_room(self) -> Scratch {
        self.scratch
    }

    /// Forgets the pixels that have got samples.
    pub fn clear(&mut self) {
        self.wanted.clear();
    }

    /// The pixels of one of the tiles.
    pub fn of(&self, tile: u32) -> &[Wanted] {
        let start = self.wanted.partition_point(|wanted| wanted.tile < tile);
        let end = self.wanted.partition_point(|wanted| wanted.tile <= tile);
        &self.wanted[start..end]
    }

    /// Whether one of the tiles has such pixels.
    pub fn wants(&self, tile: u32) -> bool {
        !self.of(tile).is_empty()
    }
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

/// Traces the samples that are wanted of some tiles. Together, since the points of a coarse lattice and of the first
/// round are so few in a tile that rays would not come in packets. (The first picture of the demo took 34 ms tile by
/// tile.)
pub(super) fn trace(tiles: &mut [Tile], tracer: Tracer, batch: &mut Batch, stats: &mut TileStats) -> Traced {
    let mut work = Work { tracer, batch, stats, start: Instant::now() };
    let mut traced = work.add(tiles);
    if traced == Traced::Whole {
        traced = work.trace(tiles);
    }
    work.batch.points.clear();
    work.batch.runs.clear();
    work.stats.busy += work.start.elapsed();
    traced
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
    /// Takes in the samples that are wanted; traces when there are enough.
    fn add(&mut self, tiles: &mut [Tile]) -> Traced {
        let wanted = std::mem::take(&mut self.batch.wanted);
        let mut traced = Traced::Whole;
        'all: for of_tile in wanted.chunk_by(|a, b| a.tile == b.tile) {
            let number = of_tile[0].tile;
            for &Wanted { at, before, after, .. } in of_tile {
                let (x, y) = tiles[number as usize].place(at);
                let mut next = before;
                while next < after {
                    let count = (after - next).min((BATCH - self.batch.points.count()) as u32);
                    (next..next + count).for_each(|index| self.batch.points.push(x, y, index));
                    self.batch.runs.push(Run { tile: number, at, count });
                    next += count;
                    if self.batch.points.count() == BATCH {
                        traced = self.trace(tiles);
                        if traced != Traced::Whole {
                            break 'all;
                        }
                    }
                }
            }
        }
        self.batch.wanted = wanted;
        traced
    }

    /// Traces the samples that wait, and adds them in their order.
    fn trace(&mut self, tiles: &mut [Tile]) -> Traced {
        let Self { tracer: Tracer { scene, sampler, filter, control, differences }, batch, stats, start } = self;
        let points = batch.points.find(scene, *filter);
        batch.samples.resize(points.len(), Sample::default());
        stats.rays += loop {
            control.look_at_the_clock();
            let began = control.changes();
            let mut rays = RayCounts::default();
            sampler(scene, points, &mut batch.samples, &mut rays, &mut batch.scratch, control.stop());
            if control.undisturbed(began) {
                break rays;
            }
            // The samples may not be whole: once awake they are traced again.
            stats.busy += start.elapsed();
            let wait = control.wait();
            *start = Instant::now();
            match wait {
                Wait::GoOn => {}
                Wait::Expired => return Traced::Part,
                Wait::Cancelled => return Traced::Cancelled,
            }
        };
        stats.samples += batch.points.count() as u64;
        stats.overfull += batch.samples.iter().filter(|sample| sample.overfull).count() as u64;
        let mut samples = &batch.samples[..];
        for run in &batch.runs {
            let (of_pixel, others) = samples.split_at(run.count as usize);
            stats.non_finite += tiles[run.tile as usize].add(run.at, of_pixel, *differences);
            samples = others;
        }
        batch.points.clear();
        batch.runs.clear();
        Traced::Whole
    }
}
