//! Which corners meet at a place.

use std::ops::Range;

/// For each place of a range the numbers that were filed under it, in rising order.
pub(super) struct Fans {
    places: Range<u32>,
    /// Those of place number p of the range are `members[first[p]..first[p + 1]]`.
    first: Vec<u32>,
    members: Vec<u32>,
}

impl Fans {
    /// Files each number under its key, where that is among `places`: a counting sort. All keys are looked at, so it
    /// pays to have as many ranges as threads and no more.
    pub fn of(keys: impl Iterator<Item = u32> + Clone, places: Range<u32>) -> Self {
        let mut first = vec![0_u32; places.len() + 2];
        for key in keys.clone() {
            // Keys below the range wrap around and are far above it.
            let place = key.wrapping_sub(places.start) as usize;
            if place < places.len() {
                first[place + 2] += 1;
            }
        }
        for place in 2..first.len() {
            first[place] += first[place - 1];
        }
        let mut members = vec![0; first.last().map_or(0, |&n| n as usize)];
        for (number, key) in (0..).zip(keys) {
            let place = key.wrapping_sub(places.start) as usize;
            if place < places.len() {
                let slot = &mut first[place + 1];
                members[*slot as usize] = number;
                *slot += 1;
            }
        }
        Self { places, first, members }
    }

    /// Each place and what was filed under it.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &[u32])> {
        let members = |of: &[u32]| &self.members[of[0] as usize..of[1] as usize];
        self.places.clone().zip(self.first.windows(2).map(members))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_filed_once_and_in_order() {
        let keys = [3, 1, 9, 3, 4, 1, 1];
        let all =
            |range| Fans::of(keys.iter().copied(), range).iter().map(|(p, m)| (p, m.to_vec())).collect::<Vec<_>>();
        assert_eq!(all(1..4), [(1, vec![1, 5, 6]), (2, vec![]), (3, vec![0, 3])]);
        assert_eq!(all(4..5), [(4, vec![4])]);
        assert_eq!(all(5..5), []);
    }
}
