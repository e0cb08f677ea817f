//! What the owner of a render tells its workers.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};

/// Flags that workers look at before every ray.
#[derive(Debug, Default)]
pub(super) struct Control {
    /// Whether either of the others is set: what tracing looks at.
    stop: AtomicBool,
    cancelled: AtomicBool,
    paused: AtomicBool,
    /// How often a flag was set or cleared.
    changes: AtomicU32,
    /// For changing flags and for sleeping; `stop` is read without it.
    gate: Mutex<()>,
    changed: Condvar,
}

impl Control {
    /// Ends the render: workers stop before their next ray, asleep or not.
    pub fn cancel(&self) {
        self.set(&self.cancelled, true);
    }

    /// Puts the workers to sleep before their next ray, or wakes them.
    pub fn pause(&self, paused: bool) {
        self.set(&self.paused, paused);
    }

    fn set(&self, flag: &AtomicBool, value: bool) {
        let _gate = self.gate.lock().unwrap_or_else(PoisonError::into_inner);
        flag.store(value, Ordering::Relaxed);
        let stop = self.cancelled.load(Ordering::Relaxed) || self.paused.load(Ordering::Relaxed);
        // Before `stop` is, so that whoever sees the one sees the other.
        self.changes.fetch_add(1, Ordering::Relaxed);
        self.stop.store(stop, Ordering::Release);
        self.changed.notify_all();
    }

    /// Set while there is something to heed: then stop tracing, in the middle of a sample too, and call [`Control::wait`].
    pub fn stop(&self) -> &AtomicBool {
        &self.stop
    }

    /// How often a flag has changed: to be asked before tracing, for [`Control::undisturbed`].
    pub fn changes(&self) -> u32 {
        self.changes.load(Ordering::Relaxed)
    }

    /// Whether tracing that began after so many changes never saw `stop` set, so that its samples are whole. That it is not
    /// set now does not tell: a pause may have come and gone in the middle of a sample.
    pub fn undisturbed(&self, changes: u32) -> bool {
        // If it was seen set and is not now, then this reads what cleared it, and with it the change counted before.
        !self.stop.load(Ordering::Acquire) && self.changes() == changes
    }

    /// Sleeps while paused. Whether to go on: false once cancelled.
    pub fn wait(&self) -> bool {
        let mut gate = self.gate.lock().unwrap_or_else(PoisonError::into_inner);
        while self.paused.load(Ordering::Relaxed) && !self.cancelled.load(Ordering::Relaxed) {
            gate = self.changed.wait(gate).unwrap_or_else(PoisonError::into_inner);
        }
        !self.cancelled.load(Ordering::Relaxed)
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
