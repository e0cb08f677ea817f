//! How far a render is, as numbers.

use super::{Pass, RayCounts, Rect, RenderEvent};
use crate::scene::Scene;
use std::time::{Duration, Instant};

/// Numbers gathered from the events of one render.
#[derive(Clone, Debug)]
pub struct Progress {
    /// Samples that the whole render takes.
    pub samples_total: u64,
    /// Samples traced so far.
    pub samples_done: u64,
    /// Rays so far.
    pub rays: RayCounts,
    /// Samples that were not finite and are left out.
    pub non_finite: u64,
    /// One entry a worker.
    pub workers: Vec<WorkerProgress>,
    /// The pass that was last reported, of `passes_total`.
    pub pass: Option<Pass>,
    /// From 1; 0 before the first event.
    pub pass_number: usize,
    /// Passes in all.
    pub passes_total: usize,
    /// Time to the first whole picture (every pixel of the film covered by the coarsest lattice).
    pub first_picture: Option<Duration>,
    /// Whether every sample is done.
    pub finished: bool,
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

/// Time that is left, as a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eta {
    /// If all goes as fast as the fastest stretch.
    pub low: Duration,
    /// If all goes as slow as the slowest stretch.
    pub high: Duration,
}

impl Progress {
    /// Nothing done yet; the clock runs from `now`.
    pub fn new(_scene: &Scene, _threads: usize, _now: Instant) -> Self {
        todo!()
    }

    /// Takes one event in.
    pub fn update(&mut self, _event: &RenderEvent, _now: Instant) {
        todo!()
    }

    /// Time rendered so far: pauses do not count, and it stands still when the render is finished.
    pub fn elapsed(&self, _now: Instant) -> Duration {
        todo!()
    }

    /// Tells the clock about a pause beginning (`true`) or ending.
    pub fn set_paused(&mut self, _paused: bool, _now: Instant) {
        todo!()
    }

    /// Time that is left; `None` before it means something (no whole picture yet) and after the end.
    pub fn eta(&self, _now: Instant) -> Option<Eta> {
        todo!()
    }

    /// Whole percent done, rounded down: 100 only when finished.
    pub fn percent(&self) -> u32 {
        todo!()
    }
}
