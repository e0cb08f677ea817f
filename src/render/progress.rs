//! How far a render is, as numbers.

use super::convergence::Convergence;
use super::forecast::{Eta, Forecast};
use super::pixel::JUDGED;
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
                if let Some(at) = tile.non_finite.iter().position(|samples| *samples > 0) {
                    let pixel = tile.place(at);
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

    /// Weight of what was not followed, for its weight or its depth, and of lights that were not asked for: mean over the pixels, and that of the
    /// worst pixel.
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
mod tests {
    use super::*;
    use crate::math::SplitMix64;
    use crate::render::{RenderError, TileImage, TileStats};

    const SIDE: u32 = 32;

    /// A render that is made up: workers whose tiles take the time that `cost` says, on a clock of our own.
    struct Fake {
        progress: Progress,
        begun: Instant,
        /// When each worker is free, seconds.
        free: Vec<f64>,
        size: (u32, u32),
        samples: u32,
    }

    impl Fake {
        fn new(size: (u32, u32), samples: u32, threads: usize) -> Self {
            let begun = Instant::now();
            let progress = Progress::of_film(size.0, size.1, samples, threads, begun);
            Self { progress, begun, free: vec![0.0; threads], size, samples }
        }

        /// Runs to the end; calls `seen` after every tile with the progress and the time. `cost`: seconds a sample
        /// takes in a tile, with the time given.
        fn run(
            &mut self,
            mut cost: impl FnMut(Rect, f64) -> f64,
            mut seen: impl FnMut(&mut Progress, &mut f64),
        ) -> Instant {
            for pass in Pass::sequence(self.samples) {
                for rect in tiles(self.size) {
                    let worker = (0..self.free.len()).min_by(|a, b| self.free[*a].total_cmp(&self.free[*b])).unwrap();
                    let samples = samples_of(pass, rect);
                    let busy = cost(rect, self.free[worker]) * samples as f64;
                    self.progress.update(
                        &RenderEvent::TileStarted { worker, rect, pass },
                        self.begun + Duration::from_secs_f64(self.free[worker]),
                    );
                    self.free[worker] += busy;
                    let rays = RayCounts { camera: samples, ..RayCounts::default() };
                    let stats =
                        TileStats { samples, rays, busy: Duration::from_secs_f64(busy), ..TileStats::default() };
                    let tile = TileImage { rect, ..TileImage::default() };
                    let now = self.begun + Duration::from_secs_f64(self.free[worker]);
                    self.progress.update(&RenderEvent::TileFinished { worker, tile, stats, pass }, now);
                    seen(&mut self.progress, &mut self.free[worker]);
                }
            }
            let end = self.begun + Duration::from_secs_f64(self.free.iter().copied().fold(0.0, f64::max));
            self.progress.update(&RenderEvent::Finished, end);
            end
        }
    }

    fn tiles((width, height): (u32, u32)) -> impl Iterator<Item = Rect> {
        let rows = (0..height).step_by(SIDE as usize);
        rows.flat_map(move |y| {
            (0..width).step_by(SIDE as usize).map(move |x| Rect {
                x,
                y,
                width: SIDE.min(width - x),
                height: SIDE.min(height - y),
            })
        })
    }

    fn samples_of(pass: Pass, rect: Rect) -> u64 {
        let on_lattice = |step: u32| u64::from(rect.width.div_ceil(step)) * u64::from(rect.height.div_ceil(step));
        match pass {
            Pass::Lattice { step: 8 } => on_lattice(8),
            Pass::Lattice { step } => on_lattice(step) - on_lattice(2 * step),
            Pass::Refine { from, to } => rect.area() * u64::from(to - from),
            Pass::Adapt { .. } => 0,
        }
    }

    #[test]
    fn the_percentage_never_falls_and_is_100_only_at_the_end() {
        let mut fake = Fake::new((100, 70), 5, 3);
        let mut last = 0;
        fake.run(
            |_, _| 1e-5,
            |progress, _| {
                assert!(progress.percent() >= last && progress.percent() < 100);
                last = progress.percent();
            },
        );
        assert_eq!(Some(fake.progress.samples_done), fake.progress.samples_total);
        assert_eq!((last, fake.progress.percent()), (99, 100));
        assert_eq!(fake.progress.rays.camera, 100 * 70 * 5);
        assert_eq!(Some(fake.progress.pass_number), fake.progress.passes_total);
        assert_eq!(fake.progress.workers.iter().map(|w| w.tiles).sum::<u64>(), 12 * 7);
        assert!(fake.progress.workers.iter().all(|w| w.current.is_none()));
    }

    #[test]
    fn every_pass_is_reached_in_its_turn_and_a_late_one_does_not_go_back() {
        let rect = Rect { x: 0, y: 0, width: 8, height: 8 };
        for samples in [1, 2, 37, 5000] {
            let mut progress = Progress::of_film(8, 8, samples, 1, Instant::now());
            let passes = Pass::sequence(samples);
            for (index, pass) in passes.iter().enumerate() {
                for late in [0, 1, 3] {
                    let pass = passes[index.saturating_sub(late)];
                    progress.update(&RenderEvent::TileStarted { worker: 0, rect, pass }, Instant::now());
                    assert_eq!((progress.pass_number, progress.pass), (index + 1, Some(passes[index])));
                }
                assert_eq!(progress.pass, Some(*pass));
            }
        }
    }

    #[test]
    fn percentages_are_rounded_down() {
        let mut progress = Progress::of_film(10, 10, 10, 1, Instant::now());
        for (done, percent) in [(0, 0), (9, 0), (10, 1), (998, 99), (1000, 99)] {
            progress.samples_done = done;
            progress.advance(Duration::ZERO);
            assert_eq!(progress.percent(), percent);
        }
    }

    #[test]
    fn the_first_picture_is_there_when_the_coarsest_lattice_covers_the_film() {
        let mut fake = Fake::new((96, 64), 2, 1);
        let mut tiles = 0;
        fake.run(
            |_, _| 1e-3,
            |progress, _| {
                tiles += 1;
                assert_eq!(progress.first_picture.is_some(), tiles >= 6, "after {tiles} tiles");
            },
        );
        // Six tiles of 16 lattice points each.
        assert_eq!(fake.progress.first_picture.unwrap().as_millis(), 96);
    }

    #[test]
    fn pauses_do_not_count_and_the_end_stops_the_clock() {
        let begun = Instant::now();
        let at = |seconds| begun + Duration::from_secs(seconds);
        let mut progress = Progress::of_film(8, 8, 1, 1, begun);
        progress.set_paused(true, at(10));
        progress.set_paused(true, at(12));
        assert_eq!(progress.elapsed(at(15)), Duration::from_secs(10));
        progress.set_paused(false, at(20));
        progress.set_paused(false, at(21));
        assert_eq!(progress.elapsed(at(25)), Duration::from_secs(15));
        progress.update(&RenderEvent::Finished, at(30));
        progress.set_paused(false, at(31));
        assert_eq!(progress.elapsed(at(99)), Duration::from_secs(20));
        assert!(progress.eta(at(99)).is_none());

        let mut failed = Progress::of_film(8, 8, 1, 1, begun);
        failed.update(&RenderEvent::Failed(RenderError { worker: 0, message: String::new() }), at(3));
        failed.set_paused(true, at(4));
        failed.set_paused(false, at(6));
        assert_eq!((failed.elapsed(at(9)), failed.finished, failed.percent()), (Duration::from_secs(3), false, 0));
    }

    /// Runs a made-up render and returns, for each forecast made, the time gone, the forecast and the truth.
    fn forecasts(
        size: (u32, u32),
        samples: u32,
        threads: usize,
        cost: impl Fn(Rect, f64) -> f64,
    ) -> (f64, Vec<(f64, Eta)>) {
        let mut fake = Fake::new(size, samples, threads);
        let begun = fake.begun;
        let mut made = Vec::new();
        let end = fake.run(&cost, |progress, free| {
            let now = begun + Duration::from_secs_f64(*free);
            made.extend(progress.eta(now).map(|eta| (*free, eta)));
        });
        (end.duration_since(begun).as_secs_f64(), made)
    }

    /// Seconds by which the truth lies outside a range.
    fn miss(eta: Eta, truth: f64) -> f64 {
        (eta.low.as_secs_f64() - truth).max(truth - eta.high.as_secs_f64()).max(0.0)
    }

    #[test]
    fn at_constant_speed_the_range_holds_the_truth() {
        let (end, made) = forecasts((640, 352), 16, 1, |_, _| 1e-5);
        assert!(made.first().unwrap().0 < 1.5, "the first forecast comes at {}", made[0].0);
        for (time, eta) in made {
            assert!(miss(eta, end - time) < 1e-6, "{eta:?} at {time} of {end}");
            assert!((eta.high - eta.low).as_secs_f64() < 0.11 * (end - time) + 1e-6, "{eta:?} at {time} of {end}");
        }
    }

    #[test]
    fn tiles_of_very_different_cost_do_not_mislead() {
        // The lower rows cost 20 times the upper ones: a mean over samples would be wrong in every pass.
        let cost = |rect: Rect, _| if rect.y > 160 { 2e-5 } else { 1e-6 };
        for threads in [1, 4] {
            let (end, made) = forecasts((640, 352), 32, threads, cost);
            for (time, eta) in made {
                assert!(miss(eta, end - time) <= 0.03 * end, "{eta:?} at {time} of {end}, {threads} threads");
            }
        }
    }

    #[test]
    fn noisy_costs_and_a_slow_start_end_in_ranges_that_nearly_always_hold_the_truth() {
        let noise = std::cell::RefCell::new(SplitMix64(3));
        let cost = |_: Rect, time: f64| {
            let warm_up = if time < 0.3 { 3.0 } else { 1.0 };
            1e-5 * warm_up * noise.borrow_mut().range(0.7, 1.3)
        };
        let (end, made) = forecasts((640, 352), 64, 2, cost);
        let missed = made.iter().filter(|(time, eta)| miss(*eta, end - time) > 0.02 * end).count();
        assert!(missed * 20 < made.len(), "{missed} of {} ranges miss", made.len());
    }

    #[test]
    fn when_the_machine_slows_down_the_range_follows() {
        let (end, made) = forecasts((640, 352), 64, 2, |_, time| if time < 10.0 { 1e-5 } else { 2e-5 });
        let late: Vec<_> = made.iter().filter(|(time, _)| *time > 30.0 && *time < 0.95 * end).collect();
        assert!(!late.is_empty());
        for (time, eta) in late {
            assert!(miss(*eta, end - time) < 0.05 * end, "{eta:?} at {time} of {end}");
        }
    }
}
