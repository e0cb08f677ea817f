//! What the owner of a render tells its workers.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};

/// Flags that workers look at before every sample.
#[derive(Debug, Default)]
pub(super) struct Control {
    cancelled: AtomicBool,
    paused: AtomicBool,
    /// For sleeping; the flags are read without it.
    gate: Mutex<()>,
    changed: Condvar,
}

impl Control {
    /// Ends the render: workers stop before their next sample, asleep or not.
    pub fn cancel(&self) {
        self.set(&self.cancelled, true);
    }

    /// Puts the workers to sleep before their next sample, or wakes them.
    pub fn pause(&self, paused: bool) {
        self.set(&self.paused, paused);
    }

    fn set(&self, flag: &AtomicBool, value: bool) {
        let _gate = self.gate.lock().unwrap_or_else(PoisonError::into_inner);
        flag.store(value, Ordering::Relaxed);
        self.changed.notify_all();
    }

    /// Whether there is anything to heed: then call [`Control::wait`].
    pub fn calls(&self) -> bool {
        self.paused.load(Ordering::Relaxed) || self.cancelled.load(Ordering::Relaxed)
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
