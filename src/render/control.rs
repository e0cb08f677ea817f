//! What the owner of a render tells its workers.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};

/// Flags that workers look at before every ray.
#[derive(Debug, Default)]
pub(super) struct Control {
    /// Whether either of the others is set: what tracing looks at.
    stop: AtomicBool,
    cancelled: AtomicBool,
    paused: AtomicBool,
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
        self.stop.store(stop, Ordering::Relaxed);
        self.changed.notify_all();
    }

    /// Set while there is something to heed: then stop tracing, in the middle of a sample too, and call [`Control::wait`].
    pub fn stop(&self) -> &AtomicBool {
        &self.stop
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
