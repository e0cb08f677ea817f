//! Many random trials on all processors, with a result that does not depend on how many there are.

use crate::math::SplitMix64;
use std::num::NonZeroUsize;
use std::ops::AddAssign;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

/// The presets of arithmetic, in the order of every array of four in this module.
pub const PRESETS: [&str; 4] = ["classic", "fast", "robust", "reference"];

/// Evaluates an expression for every preset: `each_preset!(K => f::<K>(x))` is an array of four.
macro_rules! each_preset {
    ($kernels:ident => $value:expr) => {
        [
            {
                type $kernels = $crate::geometry::Classic;
                $value
            },
            {
                type $kernels = $crate::geometry::Fast;
                $value
            },
            {
                type $kernels = $crate::geometry::Robust;
                $value
            },
            {
                type $kernels = $crate::geometry::Reference;
                $value
            },
        ]
    };
}
pub(super) use each_preset;

/// What came of trials.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// How many there were.
    pub trials: u64,
    /// How many of them each preset failed.
    pub failures: [u64; 4],
    /// The largest error of each preset.
    pub worst: [f64; 4],
}

impl Tally {
    /// Counts one trial, failed by some.
    pub fn judge(&mut self, failed: [bool; 4]) {
        self.trials += 1;
        for (count, failed) in self.failures.iter_mut().zip(failed) {
            *count += u64::from(failed);
        }
    }

    /// Keeps the largest errors. NaN is worse than any.
    pub fn measure(&mut self, errors: [f64; 4]) {
        for (worst, error) in self.worst.iter_mut().zip(errors) {
            // The largest number that a file can hold.
            *worst = if error.is_finite() { worst.max(error) } else { f64::MAX };
        }
    }

    /// Part of the trials that each preset failed.
    pub fn rates(&self) -> [f64; 4] {
        self.failures.map(|failures| failures as f64 / self.trials.max(1) as f64)
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, o: Self) {
        self.trials += o.trials;
        for k in 0..4 {
            self.failures[k] += o.failures[k];
            self.worst[k] = self.worst[k].max(o.worst[k]);
        }
    }
}

/// How much is tried, and by how many threads.
#[derive(Clone, Copy)]
pub struct Effort<'a> {
    /// A hundredth of everything.
    pub quick: bool,
    /// Threads for trials.
    pub threads: NonZeroUsize,
    /// Asked now and then, by the thread that calls, whether to go on; told which part of a row's trials is done. If
    /// not, what comes out means nothing.
    pub go_on: &'a dyn Fn(f64) -> bool,
}

/// Trials that one thread takes at a time, with a generator of their own.
const CHUNK: u64 = 1024;

impl Effort<'_> {
    /// `full`, or when in haste `quick`.
    pub fn choose<T>(&self, quick: T, full: T) -> T {
        if self.quick { quick } else { full }
    }

    /// Runs `count` trials, each with random numbers that depend on `seed` and on its place only. `tally` is an array
    /// of as many tallies as the trial tells apart.
    pub fn run<const N: usize>(
        &self,
        seed: u64,
        count: u64,
        trial: impl Fn(&mut SplitMix64, &mut [Tally; N]) + Sync,
    ) -> [Tally; N] {
        let next = AtomicU64::new(0);
        let total = Mutex::new([Tally::default(); N]);
        let work = |go_on: &dyn Fn(f64) -> bool| {
            let mut tallies = [Tally::default(); N];
            loop {
                let chunk = next.fetch_add(1, Ordering::Relaxed);
                let start = chunk.saturating_mul(CHUNK);
                if start >= count {
                    break;
                }
                if !go_on(start as f64 / count as f64) {
                    // So far that nobody finds another one.
                    next.store(u64::MAX / 2, Ordering::Relaxed);
                }
                let mut rng = SplitMix64(SplitMix64(seed ^ chunk.wrapping_mul(0xd134_2543_de82_ef95)).next_u64());
                for _ in start..count.min(start + CHUNK) {
                    trial(&mut rng, &mut tallies);
                }
            }
            // Counts and maxima do not depend on the order in which they are put together.
            let mut total = total.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            for (sum, part) in total.iter_mut().zip(tallies) {
                *sum += part;
            }
        };
        thread::scope(|scope| {
            for _ in 1..self.threads.get() {
                scope.spawn(|| work(&|_| true));
            }
            work(self.go_on);
        });
        total.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tally_of_trials_does_not_depend_on_the_number_of_threads() {
        let run = |threads: usize| {
            let threads = NonZeroUsize::new(threads).unwrap();
            let effort = Effort { quick: true, threads, go_on: &|_| true };
            effort.run(5, 10_000, |rng, [a, b]: &mut [Tally; 2]| {
                let x = rng.unit();
                a.judge([x < 0.5, x < 0.25, x < 0.1, false]);
                b.measure([x, -x, x * x, if x > 0.5 { f64::NAN } else { 0.0 }]);
            })
        };
        let [a, b] = run(1);
        assert_eq!(a.trials, 10_000);
        assert!((a.rates()[0] - 0.5).abs() < 0.05 && a.failures[3] == 0);
        assert!(b.worst[0] > 0.99 && b.worst[1] == 0.0 && b.worst[3] == f64::MAX);
        assert_eq!(run(3), [a, b]);
    }
}
