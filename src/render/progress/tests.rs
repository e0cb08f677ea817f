//! Numbers of made-up renders.

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
                let stats = TileStats { samples, rays, busy: Duration::from_secs_f64(busy), ..TileStats::default() };
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
    assert_eq!(fake.progress.workers.iter().map(|w| w.tiles).sum::<u64>(), 12 * Pass::sequence(5).len() as u64);
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
