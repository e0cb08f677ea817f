//! Hashing of pixel coordinates and a small generator for seeded choices.

/// A well mixed 32-bit value for pixel (x, y): the seed of the pixel's sample sequence. The mixer is the finaliser of
/// Wellons' hash prospector (lowbias32), applied once a coordinate.
#[inline(always)]
pub fn hash_pixel(x: u32, y: u32) -> u32 {
    lowbias32(lowbias32(x.wrapping_add(0x9e37_79b9)) ^ y)
}

/// Wellons' `lowbias32`: a bijection of u32 with a bias of 0.17.
#[inline(always)]
pub fn lowbias32(mut v: u32) -> u32 {
    v ^= v >> 16;
    v = v.wrapping_mul(0x21f0_aaad);
    v ^= v >> 15;
    v = v.wrapping_mul(0xd35a_2d97);
    v ^ (v >> 15)
}

/// SplitMix64 (Steele, Lea, Flood 2014): a seeded stream for tests and generated scenes.
#[derive(Clone, Debug)]
pub struct SplitMix64(pub u64);

impl SplitMix64 {
    /// The next 64 bits.
    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in 0..1.
    pub fn unit(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * 2f64.powi(-53)
    }

    /// Uniform in `lower..upper`.
    pub fn range(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * self.unit()
    }
}
