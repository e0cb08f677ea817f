//! Numbering of distinct keys.

/// Numbers distinct keys in the order in which they are first seen: an open-addressing table of indices over a dense
/// list of keys, for it is asked once or more for every corner of a mesh.
pub(super) struct Interner<const N: usize> {
    slots: Vec<u32>,
    keys: Vec<[u32; N]>,
}

const FREE: u32 = u32::MAX;

impl<const N: usize> Interner<N> {
    /// Room for about `expected` keys.
    pub fn with_capacity(expected: usize) -> Self {
        Self { slots: vec![FREE; (expected * 2).next_power_of_two().max(16)], keys: Vec::with_capacity(expected) }
    }

    /// The number of `key`, which is new if it equals the number of keys before the call.
    #[inline]
    pub fn number(&mut self, key: [u32; N]) -> u32 {
        if self.keys.len() * 2 > self.slots.len() {
            self.grow();
        }
        let mask = self.slots.len() - 1;
        let mut slot = hash(&key) & mask;
        loop {
            match self.slots[slot] {
                FREE => {
                    let number = self.keys.len() as u32;
                    self.slots[slot] = number;
                    self.keys.push(key);
                    return number;
                }
                taken if self.keys[taken as usize] == key => return taken,
                _ => slot = (slot + 1) & mask,
            }
        }
    }

    #[cold]
    fn grow(&mut self) {
        let size = self.slots.len() * 2;
        let mut slots = vec![FREE; size];
        for (number, key) in self.keys.iter().enumerate() {
            let mut slot = hash(key) & (size - 1);
            while slots[slot] != FREE {
                slot = (slot + 1) & (size - 1);
            }
            slots[slot] = number as u32;
        }
        self.slots = slots;
    }
}

/// Multiply and fold, a word at a time; the last shift brings the well mixed upper half down.
#[inline]
pub(super) fn hash<const N: usize>(key: &[u32; N]) -> usize {
    let mut h = 0x9e37_79b9_7f4a_7c15_u64;
    for &word in key {
        h = (h ^ u64::from(word)).wrapping_mul(0xd6e8_feb8_6659_fd93);
        h ^= h >> 32;
    }
    h as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SplitMix64;
    use std::collections::HashMap;

    #[test]
    fn numbers_agree_with_a_standard_map() {
        let mut rng = SplitMix64(7);
        let (mut interner, mut map) = (Interner::with_capacity(0), HashMap::new());
        for _ in 0..20_000 {
            let key = std::array::from_fn::<u32, 3, _>(|_| (rng.next_u64() % 20) as u32);
            let next = map.len() as u32;
            assert_eq!(interner.number(key), *map.entry(key).or_insert(next));
        }
        assert_eq!(interner.keys.len(), map.len());
        assert!(interner.keys.iter().enumerate().all(|(i, k)| map[k] as usize == i));
    }
}
