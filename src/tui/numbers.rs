//! The numbers on the screen: those of a render at one time.

use crate::render::{Eta, Pass, Progress, RayCounts, WorkerProgress};
use std::time::{Duration, Instant};

/// How often numbers on the screen change, so that they can be read.
const PERIOD: Duration = Duration::from_millis(125);

/// What a render's [`Progress`] said at a time.
#[derive(Clone, Debug)]
pub struct Numbers {
    at: Instant,
    /// Time rendered.
    pub elapsed: Duration,
    /// Time left, if that can be told.
    pub eta: Option<Eta>,
    /// Part of the work that is done.
    pub part: f64,
    /// Whole percent done.
    pub percent: u32,
    /// Samples traced, and those of the whole render.
    pub samples: (u64, Option<u64>),
    /// The furthest pass.
    pub pass: Option<Pass>,
    /// Its number from 1, and how many there are.
    pub pass_number: (usize, Option<usize>),
    /// Time to the first whole picture.
    pub first_picture: Option<Duration>,
    /// Rays so far.
    pub rays: RayCounts,
    /// Estimated error, 8-bit codes.
    pub error: Option<f64>,
    /// The error that ends the render.
    pub target: Option<f64>,
    /// What rays that were not followed can change at most, mean over the pixels, as a part of white; `None` if nothing
    /// bounds it.
    pub cut: Option<f64>,
    /// Time in seconds and estimated error.
    pub error_history: Vec<(f64, f64)>,
    /// Samples left out.
    pub non_finite: u64,
    /// The first pixel that has such samples.
    pub first_non_finite: Option<(u32, u32)>,
    /// Samples with a ray inside of more transparent bodies than are kept track of.
    pub overfull: u64,
    /// One entry a worker.
    pub workers: Vec<WorkerProgress>,
}

impl Numbers {
    /// The numbers at `now`.
    pub fn new(progress: &Progress, now: Instant) -> Self {
        Self {
            at: now,
            elapsed: progress.elapsed(now),
            eta: progress.eta(now),
            part: progress.part(),
            percent: progress.percent(),
            samples: (progress.samples_done, progress.samples_total),
            pass: progress.pass,
            pass_number: (progress.pass_number, progress.passes_total),
            first_picture: progress.first_picture,
            rays: progress.rays,
            error: progress.error(),
            target: progress.target().filter(|target| *target > 0.0),
            cut: progress.cut_bound().map(|bound| bound.sum),
            error_history: progress.error_history().iter().map(|(time, error)| (time.as_secs_f64(), *error)).collect(),
            non_finite: progress.non_finite,
            first_non_finite: progress.first_non_finite,
            overfull: progress.overfull,
            workers: progress.workers.clone(),
        }
    }

    /// Whether they have been on the screen for long enough.
    pub fn are_old(&self, now: Instant) -> bool {
        now.saturating_duration_since(self.at) >= PERIOD
    }

    /// Shows a worker that is between two tiles, which is a matter of microseconds, at the one that it had before.
    pub fn keep_tiles(&mut self, before: &Self) {
        for (worker, before) in self.workers.iter_mut().zip(&before.workers) {
            worker.current = worker.current.or(before.current);
        }
    }

    /// Of so many things, how many came a second.
    pub fn rate(&self, count: u64) -> f64 {
        if self.elapsed.is_zero() { 0.0 } else { count as f64 / self.elapsed.as_secs_f64() }
    }

    /// Share of the time that a worker was busy, 0 to 1.
    pub fn busy(&self, worker: &WorkerProgress) -> f64 {
        if self.elapsed.is_zero() { 0.0 } else { (worker.busy.as_secs_f64() / self.elapsed.as_secs_f64()).min(1.0) }
    }

    /// Share of the time that all workers together were busy, 0 to 1.
    pub fn all_busy(&self) -> f64 {
        self.workers.iter().map(|worker| self.busy(worker)).sum::<f64>() / self.workers.len().max(1) as f64
    }
}
