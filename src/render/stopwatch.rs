//! Time that pauses do not count in.

use std::time::{Duration, Instant};

/// A clock that can be stopped.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stopwatch {
    begun: Instant,
    /// Time that did not count.
    paused: Duration,
    /// Since when it stands still.
    stopped: Option<Instant>,
}

impl Stopwatch {
    /// It runs from `now`.
    pub fn started(now: Instant) -> Self {
        Self { begun: now, paused: Duration::ZERO, stopped: None }
    }

    /// Time that counts.
    pub fn elapsed(&self, now: Instant) -> Duration {
        self.stopped.unwrap_or(now).saturating_duration_since(self.begun).saturating_sub(self.paused)
    }

    /// Lets it stand still.
    pub fn stop(&mut self, now: Instant) {
        self.stopped.get_or_insert(now);
    }

    /// Lets it run again.
    pub fn go_on(&mut self, now: Instant) {
        if let Some(since) = self.stopped.take() {
            self.paused += now.saturating_duration_since(since);
        }
    }
}
