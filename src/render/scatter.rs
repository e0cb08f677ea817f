//! How the samples of one pixel differ, and how wrong their mean may be.

use super::pixel::Pixel;
use crate::math::{Rgb, linear_to_srgb_near};
use crate::shading::Sample;

/// How the samples of a pixel differ, which only refinement asks for.
///
/// The variance of the mean is estimated from the samples of the pixel alone. With V(n) the variance of the mean of n
/// samples, V(1) is that of single samples. Samples of a (0,2) sequence are stratified, so that V falls faster than
/// 1/n: about as n^-3/2 where an edge crosses the pixel, faster where it is smooth, as 1/n where detail is finer than
/// the samples. Blocks of 2^k samples are stratified alike; the variance between up to four of them tells how fast V
/// falls in this pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Scatter {
    /// Sum of squared differences from the mean, by channel (Welford).
    squares: [f32; 3],
    /// The same of the brightness.
    spread: f32,
    /// Sums of brightness over blocks of equal size.
    blocks: [f32; 4],
    /// Ray tree of the first sample, and whether others differ.
    tree: u32,
    mixed: bool,
    /// About the rays of all samples.
    cost: u32,
    /// Expected squared error by its own samples (0 with one sample).
    pub own: f32,
    /// The same as the last census took it, with what neighbours show.
    pub judged: f32,
}

/// Samples below which a pixel tells nothing of its own error.
pub const JUDGED: u32 = 4;

/// How V falls where nothing else is known: V(n) = V(1) n^-USUAL, as for edges.
const USUAL: f64 = 1.5;

/// How many comparisons of blocks the usual fall weighs as much as.
const BELIEF: f64 = 3.0;

impl Scatter {
    /// Notes how the next sample differs from those that are in the pixel already.
    pub fn note(&mut self, pixel: &Pixel, sample: &Sample) {
        let (index, count, x) = (pixel.traced(), pixel.count(), sample.radiance);
        if index == 0 {
            self.tree = sample.tree;
        }
        self.mixed |= sample.tree != self.tree;
        self.cost = self.cost.saturating_add(sample.cost);
        if !x.is_finite() {
            return;
        }
        if count > 0 {
            let before = pixel.sum() / f64::from(count);
            let after = (pixel.sum() + x) / f64::from(count + 1);
            let product = |x: f64, before: f64, after: f64| ((x - before) * (x - after)) as f32;
            self.squares[0] += product(x.r, before.r, after.r);
            self.squares[1] += product(x.g, before.g, after.g);
            self.squares[2] += product(x.b, before.b, after.b);
            self.spread += product(brightness(x), brightness(before), brightness(after));
        }
        // Four blocks are full: two and two become one.
        if index >= 4 && index.is_power_of_two() {
            let [a, b, c, d] = self.blocks;
            self.blocks = [a + b, c + d, 0.0, 0.0];
        }
        self.blocks[(index / block_size(index)) as usize] += brightness(x) as f32;
    }

    /// About the rays that a sample takes.
    pub fn cost(&self, pixel: &Pixel) -> f64 {
        f64::from(self.cost.max(1)) / f64::from(pixel.traced().max(1))
    }

    /// Hash of the ray tree; 0 where samples differ.
    pub fn tree(&self) -> u32 {
        if self.mixed { 0 } else { self.tree | 1 }
    }

    /// Expected square of the error of the mean in 8-bit codes, mean over the channels, by the samples alone; 0 where
    /// there are too few to tell.
    pub fn variance(&self, pixel: &Pixel) -> f64 {
        if pixel.count() < JUDGED || self.squares == [0.0; 3] {
            return 0.0;
        }
        let n = f64::from(pixel.count());
        let of_mean = n.powf(-self.fall(pixel)) / (n - 1.0);
        let mean = pixel.mean();
        let square = |mean: f64, squares: f32| {
            let deviation = (f64::from(squares) * of_mean).sqrt();
            (127.5 * (linear_to_srgb_near(mean + deviation) - linear_to_srgb_near(mean - deviation))).powi(2)
        };
        let [r, g, b] = self.squares;
        (square(mean.r, r) + square(mean.g, g) + square(mean.b, b)) / 3.0
    }

    /// Variance of the brightness of single samples.
    pub fn single_variance(&self, pixel: &Pixel) -> f32 {
        self.spread / (pixel.count().max(2) - 1) as f32
    }

    /// p in V(n) = V(1) n^-p.
    fn fall(&self, pixel: &Pixel) -> f64 {
        let last = pixel.count() - 1;
        let size = block_size(last);
        let blocks = (pixel.count() / size).min(4) as usize;
        // A sample that is not finite leaves a hole in its block.
        if size < 2 || self.spread <= 0.0 || pixel.non_finite() > 0 {
            return USUAL;
        }
        let m = f64::from(size);
        let means = || self.blocks[..blocks].iter().map(|&sum| f64::from(sum) / m);
        let mean = means().sum::<f64>() / blocks as f64;
        let comparisons = (blocks - 1) as f64;
        let between = means().map(|b| (b - mean).powi(2)).sum::<f64>() / comparisons;
        let single = f64::from(self.spread) / f64::from(last);
        // V(m) / (V(1) / m), but for a factor of 4/3 (1 - 4^-p) that is close to that of p = 3/2: blocks of one net
        // share strata.
        let ratio = between * m / single / SHARED;
        let ratio = (BELIEF * m.powf(1.0 - USUAL) + comparisons * ratio) / (BELIEF + comparisons);
        (1.0 - ratio.ln() / m.ln()).clamp(1.0, 2.0)
    }
}

/// Four blocks of a net differ by this factor more than independent ones: 4/3 (1 - 4^-3/2).
const SHARED: f64 = 7.0 / 6.0;

/// Samples in a block when the sample `index` is there.
fn block_size(index: u32) -> u32 {
    if index < 4 { 1 } else { 1 << (index.ilog2() - 1) }
}

fn brightness(x: Rgb) -> f64 {
    0.25 * x.r + 0.625 * x.g + 0.125 * x.b
}
