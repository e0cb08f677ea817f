//! Which rays of a packet.

use super::packet::PACKET;
use super::wide::Wide;

/// Some rays of a packet, by their numbers in it, a bit each. Most of the work is done group by group: as many rays as
/// there are lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(align(32))]
pub struct RaySet([u8; PACKET / 8]);

impl RaySet {
    /// No ray.
    pub const NONE: Self = Self([0; PACKET / 8]);

    /// The first `count` rays.
    #[inline(always)]
    pub fn first(count: usize) -> Self {
        let mut set = Self::NONE;
        for (k, byte) in set.0.iter_mut().enumerate() {
            let of_byte = count.saturating_sub(8 * k).min(8);
            *byte = ((1u32 << of_byte) - 1) as u8;
        }
        set
    }

    /// Whether there is none.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.0 == [0; PACKET / 8]
    }

    /// How many there are.
    #[inline(always)]
    pub fn len(&self) -> u32 {
        self.0.as_chunks().0.iter().map(|word| u64::from_le_bytes(*word).count_ones()).sum()
    }

    /// Whether this ray is one of them.
    #[inline(always)]
    pub fn contains(&self, ray: usize) -> bool {
        self.0[ray / 8 % (PACKET / 8)] >> (ray % 8) & 1 != 0
    }

    /// Adds a ray.
    #[inline(always)]
    pub fn insert(&mut self, ray: usize) {
        self.0[ray / 8 % (PACKET / 8)] |= 1 << (ray % 8);
    }

    /// Takes a ray away.
    #[inline(always)]
    pub fn remove(&mut self, ray: usize) {
        self.0[ray / 8 % (PACKET / 8)] &= !(1 << (ray % 8));
    }

    /// Those of a group, a bit a lane.
    #[inline(always)]
    pub fn group<W: Wide>(&self, group: usize) -> u32 {
        let at = group * (W::LANES / 8) % (PACKET / 8);
        if W::LANES == 16 { u16::from_le_bytes([self.0[at], self.0[at + 1]]).into() } else { self.0[at].into() }
    }

    /// Says which of a group are in it.
    #[inline(always)]
    pub fn set_group<W: Wide>(&mut self, group: usize, lanes: u32) {
        let at = group * (W::LANES / 8) % (PACKET / 8);
        self.0[at] = lanes as u8;
        if W::LANES == 16 {
            self.0[at + 1] = (lanes >> 8) as u8;
        }
    }

    /// The groups of which some are in it, a bit each.
    #[inline(always)]
    pub fn groups<W: Wide>(&self) -> u32 {
        (0..PACKET / W::LANES).fold(0, |groups, g| groups | u32::from(self.group::<W>(g) != 0) << g)
    }

    /// Those that are not in the other.
    #[inline(always)]
    pub fn without(mut self, other: &Self) -> Self {
        for (byte, other) in self.0.iter_mut().zip(other.0) {
            *byte &= !other;
        }
        self
    }

    /// Those that are in either.
    #[inline(always)]
    pub fn with(mut self, other: &Self) -> Self {
        for (byte, other) in self.0.iter_mut().zip(other.0) {
            *byte |= other;
        }
        self
    }

    /// How many words of 64 bits there are.
    pub const WORDS: usize = PACKET / 64;

    /// The rays from 64 times the number of this word on, a bit each. For loops that are too large for a closure, which
    /// then stays out of line.
    #[inline(always)]
    pub fn word(&self, word: usize) -> u64 {
        u64::from_le_bytes(self.0.as_chunks().0[word % Self::WORDS])
    }

    /// Calls `visit` with each, in order.
    #[inline(always)]
    pub fn each(&self, mut visit: impl FnMut(usize)) {
        for (k, word) in self.0.as_chunks().0.iter().enumerate() {
            each_bit(u64::from_le_bytes(*word), |bit| visit(64 * k + bit));
        }
    }

    /// Writes them down, in order. (No closure, which may stay out of line where it is large.)
    #[inline(always)]
    pub fn list(&self, to: &mut [u8; PACKET]) {
        let mut at = 0;
        for (k, word) in self.0.as_chunks().0.iter().enumerate() {
            let mut bits = u64::from_le_bytes(*word);
            while bits != 0 {
                to[at] = (64 * k) as u8 + bits.trailing_zeros() as u8;
                at += 1;
                bits &= bits - 1;
            }
        }
    }
}

/// Calls `visit` with the number of each bit, the lowest first.
#[inline(always)]
pub fn each_bit(mut bits: u64, mut visit: impl FnMut(usize)) {
    while bits != 0 {
        visit(bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::simd::Portable;
    use crate::math::SplitMix64;
    use std::collections::BTreeSet;

    #[test]
    fn sets_of_rays_are_sets() {
        let mut random = SplitMix64(64);
        for _ in 0..200 {
            let mut set = || -> BTreeSet<usize> {
                let count = random.next_u64() as usize % (2 * PACKET);
                (0..count).map(|_| random.next_u64() as usize % PACKET).collect()
            };
            let (a, b) = (set(), set());
            let of = |set: &BTreeSet<usize>| {
                let mut rays = RaySet::NONE;
                set.iter().for_each(|&ray| rays.insert(ray));
                rays
            };
            let back = |rays: RaySet| {
                let mut set = Vec::new();
                rays.each(|ray| set.push(ray));
                assert!(set.is_sorted() && set.len() == rays.len() as usize && rays.is_empty() == set.is_empty());
                set.into_iter().collect::<BTreeSet<_>>()
            };
            assert_eq!(back(of(&a)), a);
            let mut list = [0; PACKET];
            of(&a).list(&mut list);
            assert!(list.iter().map(|&ray| usize::from(ray)).take(a.len()).eq(a.iter().copied()));
            assert_eq!(back(of(&a).with(&of(&b))), &a | &b);
            assert_eq!(back(of(&a).without(&of(&b))), &a - &b);
            let mut grouped = RaySet::NONE;
            for group in 0..PACKET / 8 {
                let lanes = of(&a).group::<Portable>(group);
                assert_eq!(lanes != 0, of(&a).groups::<Portable>() >> group & 1 != 0);
                grouped.set_group::<Portable>(group, lanes);
            }
            assert_eq!(back(grouped), a);
            for ray in 0..PACKET {
                assert_eq!(of(&a).contains(ray), a.contains(&ray));
                let mut one_less = of(&a);
                one_less.remove(ray);
                assert_eq!(back(one_less), &a - &BTreeSet::from([ray]));
                assert_eq!(back(RaySet::first(ray)), (0..ray).collect());
            }
        }
    }
}
