//! What the owner of a render tells its workers.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Flags that workers look at before every ray.
#[derive(Debug, Default)]
pub(super) struct Control {
    /// Whether any of the others is set: what tracing looks at.
    stop: AtomicBool,
    cancelled: AtomicBool,
    paused: AtomicBool,
    expired: AtomicBool,
    /// Tiles of which nothing is known yet.
    uncovered: AtomicUsize,
    /// How often a flag was set or cleared.
    changes: AtomicU32,
    /// For changing flags and for sleeping; `stop` is read without it.
    gate: Mutex<Clock>,
    changed: Condvar,
}

/// The time that a render has.
#[derive(Debug, Default)]
struct Clock {
    deadline: Option<Instant>,
    /// Since when it stands still.
    paused: Option<Instant>,
}

/// What a worker is to do that has slept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wait {
    GoOn,
    Expired,
    Cancelled,
}

impl Control {
    /// Of a render of so many tiles.
    pub fn new(tiles: usize) -> Self {
        Self { uncovered: AtomicUsize::new(tiles), ..Self::default() }
    }

    /// Another tile has got its first samples.
    pub fn cover(&self) {
        self.uncovered.fetch_sub(1, Ordering::Relaxed);
    }

    /// Ends the render: workers stop before their next ray, asleep or not.
    pub fn cancel(&self) {
        self.set(&self.cancelled, true);
    }

    /// Puts the workers to sleep before their next ray, or wakes them. The time stands still meanwhile.
    pub fn pause(&self, paused: bool) {
        let mut clock = self.lock();
        if paused {
            clock.paused.get_or_insert_with(Instant::now);
        } else if let (Some(since), deadline) = (clock.paused.take(), &mut clock.deadline) {
            *deadline = deadline.and_then(|deadline| deadline.checked_add(since.elapsed()));
        }
        drop(clock);
        self.set(&self.paused, paused);
    }

    /// When the render is to end.
    pub fn set_deadline(&self, deadline: Instant) {
        self.lock().deadline = Some(deadline);
    }

    /// Ends the render if its time is over; not before there is a whole picture, however coarse.
    pub fn look_at_the_clock(&self) {
        if self.uncovered.load(Ordering::Relaxed) > 0 {
            return;
        }
        let clock = self.lock();
        let over = clock.paused.is_none() && clock.deadline.is_some_and(|deadline| Instant::now() >= deadline);
        drop(clock);
        if over {
            self.set(&self.expired, true);
        }
    }

    fn lock(&self) -> MutexGuard<'_, Clock> {
        self.gate.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn set(&self, flag: &AtomicBool, value: bool) {
        let _gate = self.lock();
        flag.store(value, Ordering::Relaxed);
        let stop = [&self.cancelled, &self.paused, &self.expired].iter().any(|flag| flag.load(Ordering::Relaxed));
        // Before `stop` is, so that whoever sees the one sees the other.
        self.changes.fetch_add(1, Ordering::Relaxed);
        self.stop.store(stop, Ordering::Release);
        self.changed.notify_all();
    }

    /// Set while there is something to heed: then stop tracing, in the middle of a sample too, and call
    /// [`Control::wait`].
    pub fn stop(&self) -> &AtomicBool {
        &self.stop
    }

    /// How often a flag has changed: to be asked before tracing, for [`Control::undisturbed`].
    pub fn changes(&self) -> u32 {
        self.changes.load(Ordering::Relaxed)
    }

    /// Whether tracing that began after so many changes never saw `stop` set, so that its samples are whole. That it is
    /// not set now does not tell: a pause may have come and gone in the middle of a sample.
    pub fn undisturbed(&self, changes: u32) -> bool {
        // If it was seen set and is not now, then this reads what cleared it, and with it the change counted before.
        !self.stop.load(Ordering::Acquire) && self.changes() == changes
    }

    /// Whether the time is over.
    pub fn is_expired(&self) -> bool {
        self.expired.load(Ordering::Relaxed)
    }

    /// Whether the render was cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Sleeps while paused.
    pub fn wait(&self) -> Wait {
        let mut gate = self.lock();
        while self.paused.load(Ordering::Relaxed) && !self.is_cancelled() {
            gate = self.changed.wait(gate).unwrap_or_else(PoisonError::into_inner);
        }
        match () {
            () if self.is_cancelled() => Wait::Cancelled,
            () if self.is_expired() => Wait::Expired,
            () => Wait::GoOn,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_that_came_and_went_while_tracing_is_noticed() {
        let control = Control::default();
        let began = control.changes();
        assert!(control.undisturbed(began));
        control.pause(true);
        assert!(!control.undisturbed(began));
        let in_the_pause = control.changes();
        assert!(!control.undisturbed(in_the_pause));
        control.pause(false);
        assert!(!control.undisturbed(began) && !control.undisturbed(in_the_pause));
        assert!(control.undisturbed(control.changes()));
        control.cancel();
        assert!(!control.undisturbed(control.changes()));
    }
}
