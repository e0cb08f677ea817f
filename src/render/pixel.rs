//! The sums of one pixel.

use crate::math::Rgb;
use crate::shading::Sample;

/// What is known of a pixel: sums over its samples, added in their order.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pixel {
    sum: Rgb,
    /// Finite samples.
    count: u32,
    /// Samples traced: the index of the next.
    traced: u32,
    /// Sum of the weights of paths that were not followed.
    cut: f32,
}

impl Pixel {
    /// Adds the next sample; whether it is finite. Others are counted and left out.
    pub fn add(&mut self, sample: &Sample) -> bool {
        self.traced += 1;
        self.cut += sample.cut as f32;
        let is_finite = sample.radiance.is_finite();
        if is_finite {
            self.sum += sample.radiance;
            self.count += 1;
        }
        is_finite
    }

    /// Samples traced.
    pub fn traced(&self) -> u32 {
        self.traced
    }

    /// Finite samples.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Samples that were left out since they are not finite.
    pub fn non_finite(&self) -> u32 {
        self.traced - self.count
    }

    /// Sum of the finite samples.
    pub fn sum(&self) -> Rgb {
        self.sum
    }

    /// Mean of the samples: linear radiance.
    pub fn mean(&self) -> Rgb {
        self.sum / f64::from(self.count.max(1))
    }

    /// Mean weight of the paths that were not followed.
    pub fn cut(&self) -> f64 {
        f64::from(self.cut) / f64::from(self.traced.max(1))
    }
}
