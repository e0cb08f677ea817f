//! Arrays that threads fill in place. Not vector code; it is here because unsafe code is nowhere else.

use crate::workers;
use std::mem::MaybeUninit;
use std::num::NonZeroUsize;

/// Elements that one thread makes at a time.
const PIECE: usize = 1 << 12;

/// `element(0), element(1), ..` up to `len`, made by many threads. Memory is touched first by the thread that fills it:
/// at a million triangles, clearing it beforehand in one thread would take a tenth of the build.
pub fn filled<T: Send>(len: usize, threads: NonZeroUsize, element: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut buffer: Box<[MaybeUninit<T>]> = Box::new_uninit_slice(len);
    let pieces = buffer.chunks_mut(PIECE).enumerate().collect();
    workers::map(threads, pieces, |(number, piece): (usize, &mut [MaybeUninit<T>])| {
        for (index, place) in (number * PIECE..).zip(piece) {
            place.write(element(index));
        }
    });
    // SAFETY: the pieces are the whole buffer, `map` has gone through all of them (or panicked, which does not come
    // here), and each has been written from its first to its last place.
    unsafe { buffer.assume_init() }.into_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_is_filled_with_its_own_element() {
        for threads in [1, 2, 5] {
            let threads = NonZeroUsize::new(threads).expect("not zero");
            for len in [0, 1, PIECE - 1, PIECE, PIECE + 1, 5 * PIECE + 7] {
                let expected: Vec<_> = (0..len).map(|i| i.to_string()).collect();
                assert_eq!(filled(len, threads, |i| i.to_string()), expected);
            }
        }
    }
}
