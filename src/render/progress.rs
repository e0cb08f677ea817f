//! How far a render is, as numbers.

use super::convergence::Convergence;
use super::forecast::{Eta, Forecast};
use super::scatter::JUDGED;
use super::stopwatch::Stopwatch;
use super::{Cut, Pass, RayCounts, Rect, RenderEvent};
use crate::scene::Scene;
use std::collections::HashMap;
use std::time::{Duration, Instant};

/// Numbers gathered from the events of one render.
#[derive(Clone, Debug)]
pub struct Progress {
    /// Samples that the whole render takes; `None` if they depend on the picture.
    pub samples_total: Option<u64>,
    /// Samples traced so far.
    pub samples_done: u64,
    /// Rays so far.
    pub rays: RayCounts,
    /// Samples that were not finite and are left out.
    pub non_finite: u64,
    /// Samples with a ray inside of more transparent bodies than are kept track of.
    pub overfull: u64,
    /// The first pixel in reading order that has such samples: column and row.
    pub first_non_finite: Option<(u32, u32)>,
    /// One entry a worker.
    pub workers: Vec<WorkerProgress>,
    /// The furthest pass that was reported, of `passes_total`.
    pub pass: Option<Pass>,
    /// From 1; 0 before the first event.
    pub pass_number: usize,
    /// Passes in all; `None` if they depend on the picture.
    pub passes_total: Option<usize>,
    /// Time to the first whole picture (every pixel of the film covered by the coarsest lattice).
    pub first_picture: Option<Duration>,
    /// Whether every sample is done.
    pub finished: bool,
    /// Whether there will be no more events.
    ended: bool,
    passes: Vec<Pass>,
    samples_per_pixel: u64,
    /// Pixels of the film that the first pass has not covered yet.
    uncovered: u64,
    clock: Stopwatch,
    forecast: Forecast,
    /// Where rendering ends: the error in 8-bit codes, and the time.
    target: Option<f64>,
    time_limit: Option<Duration>,
    convergence: Convergence,
    /// What was not followed in each tile.
    cuts: HashMap<(u32, u32), Cut>,
    largest_radiance: Option<f64>,
    pixels: u64,
    /// Part of the work done, when samples do not tell.
    part: f64,
}

/// What one worker has done.
#[derive(Clone, Copy, Debug, Default)]
pub struct WorkerProgress {
    /// Tile passes finished.
    pub tiles: u64,
    /// Time spent tracing.
    pub busy: Duration,
    /// Rays traced.
    pub rays: u64,
    /// What it is working on.
    pub current: Option<Rect>,
}

impl Progress {
    /// Nothing done yet; the clock runs from `now`.
    pub fn new(scene: &Scene, threads: usize, now: Instant) -> Self {
        let render = scene.render;
        let mut progress = Self::of_film(scene.width, scene.height, render.samples, threads, now);
        progress.largest_radiance = scene.largest_radiance;
        if let Some(target) = render.error.filter(|_| render.samples > JUDGED) {
            progress.target = Some(target);
            (progress.samples_total, progress.passes_total) = (None, None);
            progress.passes = Pass::lattices();
        }
        progress
    }

    /// The same for [`start_probe`](super::start_probe), which takes one sample a pixel.
    pub fn of_probe(scene: &Scene, threads: usize, now: Instant) -> Self {
        Self::of_film(scene.width, scene.height, 1, threads, now)
    }

    /// Tells when the render will be ended, in time rendered.
    pub fn set_time_limit(&mut self, limit: Duration) {
        self.time_limit = Some(limit);
    }

    fn of_film(width: u32, height: u32, samples: u32, threads: usize, now: Instant) -> Self {
        let pixels = u64::from(width) * u64::from(height);
        let passes = Pass::sequence(samples);
        Self {
            samples_total: Some(pixels * u64::from(samples)),
            samples_done: 0,
            rays: RayCounts::default(),
            non_finite: 0,
            overfull: 0,
            first_non_finite: None,
            workers: vec![WorkerProgress::default(); threads],
            pass: None,
            pass_number: 0,
            passes_total: Some(passes.len()),
            first_picture: None,
            finished: false,
            ended: false,
            passes,
            samples_per_pixel: u64::from(samples),
            uncovered: pixels,
            clock: Stopwatch::started(now),
            forecast: Forecast::default(),
            target: None,
            time_limit: None,
            convergence: Convergence::of_pixels(pixels),
            cuts: HashMap::new(),
            largest_radiance: None,
            pixels,
            part: 0.0,
        }
    }

    /// Takes one event in.
    pub fn update(&mut self, event: &RenderEvent, now: Instant) {
        match event {
            RenderEvent::TileStarted { worker, rect, pass } => {
                self.reach(*pass);
                if let Some(worker) = self.workers.get_mut(*worker) {
                    worker.current = Some(*rect);
                }
            }
            RenderEvent::TileFinished { worker, tile, stats, pass } => {
                self.reach(*pass);
                self.samples_done += stats.samples;
                self.rays += stats.rays;
                self.non_finite += stats.non_finite;
                self.overfull += stats.overfull;
                let of_tile = (0..tile.non_finite.len()).filter(|at| tile.non_finite[*at] > 0).map(|at| tile.place(at));
                if let Some(pixel) = of_tile.min_by_key(|(x, y)| (*y, *x)) {
                    let earlier = self.first_non_finite.filter(|first| (first.1, first.0) < (pixel.1, pixel.0));
                    self.first_non_finite = earlier.or(Some(pixel));
                }
                if let Some(worker) = self.workers.get_mut(*worker) {
                    worker.tiles += 1;
                    worker.busy += stats.busy;
                    worker.rays += stats.rays.total();
                    worker.current = None;
                }
                let elapsed = self.elapsed(now);
                self.forecast.learn(tile.rect, stats, self.samples_per_pixel);
                if self.passes.first() == Some(pass) {
                    self.uncovered = self.uncovered.saturating_sub(tile.rect.area());
                    if self.uncovered == 0 && self.first_picture.is_none() {
                        self.first_picture = Some(elapsed);
                    }
                }
                self.cuts.insert((tile.rect.x, tile.rect.y), stats.cut);
                if let Some(change) = stats.squared_error {
                    self.convergence.learn(tile.rect, change, elapsed);
                }
                if self.first_picture.is_some() {
                    self.forecast.note(elapsed);
                }
                self.advance(elapsed);
            }
            RenderEvent::Estimated { error } => {
                let elapsed = self.elapsed(now);
                self.convergence.judge(*error, elapsed);
                self.advance(elapsed);
            }
            RenderEvent::Finished | RenderEvent::Failed(_) => {
                self.finished = matches!(event, RenderEvent::Finished);
                self.ended = true;
                self.clock.stop(now);
                for worker in &mut self.workers {
                    worker.current = None;
                }
            }
        }
    }

    /// Time rendered so far: pauses do not count, and it stands still when the render is over.
    pub fn elapsed(&self, now: Instant) -> Duration {
        self.clock.elapsed(now)
    }

    /// Tells the clock about a pause beginning (`true`) or ending.
    pub fn set_paused(&mut self, paused: bool, now: Instant) {
        match paused {
            _ if self.ended => {}
            true => self.clock.stop(now),
            false => self.clock.go_on(now),
        }
    }

    /// Time that is left; `None` before it means something (no whole picture yet, or hardly any time gone) and after
    /// the end.
    pub fn eta(&self, now: Instant) -> Option<Eta> {
        if self.finished || self.first_picture.is_none() {
            return None;
        }
        let elapsed = self.elapsed(now);
        let eta = match self.target {
            Some(target) if target > 0.0 => self.convergence.until(target, elapsed),
            Some(_) => None,
            None => self.forecast.eta(elapsed),
        };
        let Some(limit) = self.time_limit.map(|limit| limit.saturating_sub(elapsed)) else { return eta };
        let eta = eta.unwrap_or(Eta { low: limit, high: limit });
        Some(Eta { low: eta.low.min(limit), high: eta.high.min(limit) })
    }

    /// Estimated root mean square of the sampling error, 8-bit codes; `None` before it can be told.
    pub fn error(&self) -> Option<f64> {
        self.convergence.error()
    }

    /// Weight of what was not followed, for its weight or its depth, and of lights that were not asked for: mean over
    /// the pixels, and that of the worst pixel.
    pub fn cut(&self) -> Cut {
        let all = self
            .cuts
            .values()
            .fold(Cut::default(), |all, cut| Cut { sum: all.sum + cut.sum, largest: all.largest.max(cut.largest) });
        Cut { sum: all.sum / self.pixels.max(1) as f64, ..all }
    }

    /// What that can change at most, in linear light: mean over the pixels, and the worst pixel;
    /// `None` if nothing bounds it.
    pub fn cut_bound(&self) -> Option<Cut> {
        let cut = self.cut();
        // Nothing lacks nothing, however bright the scene.
        let bound = |weight: f64| if weight == 0.0 { Some(0.0) } else { self.largest_radiance.map(|l| l * weight) };
        Some(Cut { sum: bound(cut.sum)?, largest: bound(cut.largest)? })
    }

    /// The error that ends the render, if it is one that does.
    pub fn target(&self) -> Option<f64> {
        self.target
    }

    /// Time and estimated error, in the order of time.
    pub fn error_history(&self) -> &[(Duration, f64)] {
        self.convergence.history()
    }

    /// Time until the error is down to `target`.
    pub fn until(&self, target: f64, now: Instant) -> Option<Eta> {
        self.convergence.until(target, self.elapsed(now))
    }

    /// Part of the work that is done, 0 to 1: of the samples; or of those that an error or the time will have taken.
    pub fn part(&self) -> f64 {
        if self.finished { 1.0 } else { self.part }
    }

    /// Brings `part` up to date. It never falls.
    fn advance(&mut self, elapsed: Duration) {
        let by_samples = self.samples_total.map(|total| self.samples_done as f64 / total.max(1) as f64);
        // The error falls about as the power 3/4 of the samples.
        let by_error = self.target.zip(self.error()).map(|(target, error)| (target / error.max(1e-9)).powf(4.0 / 3.0));
        let by_time = self.time_limit.map(|limit| elapsed.as_secs_f64() / limit.as_secs_f64().max(1e-9));
        let part = [by_samples, by_error, by_time].into_iter().flatten().fold(self.part, f64::max);
        self.part = part.min(1.0);
    }

    /// Whole percent done, rounded down: 100 only when finished.
    pub fn percent(&self) -> u32 {
        if self.finished {
            return 100;
        }
        // Rounding must not make less of a whole percent.
        ((self.part * 100.0 + 1e-9) as u32).min(99)
    }

    fn reach(&mut self, pass: Pass) {
        // There are many passes where there are many samples, and many tiles in each.
        if let Pass::Adapt { round } = pass {
            let number = self.passes.len() + round as usize;
            if number > self.pass_number {
                (self.pass_number, self.pass) = (number, Some(pass));
            }
            return;
        }
        let order = |pass: &Pass| match *pass {
            Pass::Adapt { round } => (2, round),
            Pass::Lattice { step } => (0, u32::MAX - step),
            Pass::Refine { from, .. } => (1, from),
        };
        let number = self.passes.binary_search_by_key(&order(&pass), order).map_or(0, |index| index + 1);
        if number > self.pass_number {
            self.pass_number = number;
            self.pass = Some(pass);
        }
    }
}

#[cfg(test)]
mod tests;
