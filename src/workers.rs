//! Work shared out among threads; nothing that comes out depends on how many there are.

use std::num::NonZeroUsize;
use std::ops::Range;
use std::panic::resume_unwind;
use std::sync::{Mutex, PoisonError};
use std::thread;

/// What `work` makes of each item, in the order of the items. Threads take the next item as they get free.
pub fn map<T: Send, R: Send>(threads: NonZeroUsize, items: Vec<T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let helpers = threads.get().min(items.len()).saturating_sub(1);
    if helpers == 0 {
        return items.into_iter().map(work).collect();
    }
    let queue = Mutex::new(items.into_iter().enumerate());
    let run = || {
        let mut done = Vec::new();
        loop {
            let next = queue.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some((number, item)) = next else { return done };
            done.push((number, work(item)));
        }
    };
    let mut done = thread::scope(|scope| {
        // Where the system gives no more threads, those that there are do it all.
        let helpers: Vec<_> =
            (0..helpers).filter_map(|_| thread::Builder::new().spawn_scoped(scope, run).ok()).collect();
        let mut done = run();
        for helper in helpers {
            done.extend(helper.join().unwrap_or_else(|panic| resume_unwind(panic)));
        }
        done
    });
    done.sort_unstable_by_key(|&(number, _)| number);
    done.into_iter().map(|(_, result)| result).collect()
}

/// `0..len` in pieces of `size`, the last one shorter.
pub fn pieces(len: usize, size: usize) -> Vec<Range<usize>> {
    (0..len).step_by(size.max(1)).map(|start| start..len.min(start + size)).collect()
}

/// `whole` in neighbouring slices of these lengths.
pub fn slices<T>(mut whole: &mut [T], lengths: impl Iterator<Item = usize>) -> Vec<&mut [T]> {
    lengths
        .map(|length| {
            let (slice, rest) = std::mem::take(&mut whole).split_at_mut(length);
            whole = rest;
            slice
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_stand_in_the_order_of_the_items() {
        for threads in [1, 2, 7, 100] {
            let threads = NonZeroUsize::new(threads).expect("not 0");
            assert_eq!(map(threads, (0..50).collect(), |i: u32| i * i), (0..50).map(|i| i * i).collect::<Vec<_>>());
            assert!(map(threads, Vec::<u32>::new(), |i| i).is_empty());
        }
        assert_eq!(pieces(7, 3), [0..3, 3..6, 6..7]);
        assert_eq!(slices(&mut [1, 2, 3, 4], [1, 0, 3].into_iter()), [&[1][..], &[], &[2, 3, 4]]);
    }
}
