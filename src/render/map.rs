//! What the pixels of all tiles tell each other between two rounds.

use super::pixel::Pixel;
use crate::math::{linear_to_srgb, srgb_to_linear};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

/// What is seen in each pixel. Tiles write their pixels while they are traced, and all wait for that before
/// they read those of others, so that what is read does not depend on who is first.
#[derive(Debug)]
pub(super) struct Map {
    width: u32,
    height: u32,
    /// Codes and ray trees.
    words: Vec<AtomicU64>,
    /// Variances, as bits.
    variances: Vec<AtomicU32>,
    /// Whether a pixel or one of its neighbours was written since it was judged. (Judging all pixels after each round took a
    /// fifth of the time of a render of the demo to an error of 1.)
    stale: Vec<AtomicBool>,
    /// Samples that each pixel needs so that thin objects are seen; empty if there are none.
    thin: Vec<u8>,
}

/// What is seen in a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    /// sRGB codes in 256ths.
    codes: [i32; 3],
    /// Part of the hash of the ray tree; 0 where samples differ.
    tree: u16,
    /// Variance of the brightness of single samples.
    variance: f32,
}

impl Look {
    pub fn of(pixel: &Pixel) -> Self {
        let mean = pixel.mean();
        let codes = [mean.r, mean.g, mean.b].map(|c| (linear_to_srgb(c) * 65280.0 + 0.5) as i32);
        let tree = (pixel.tree() >> 16) as u16 | u16::from(pixel.tree() != 0);
        Self { codes, tree, variance: pixel.single_variance() }
    }

    /// All channels of one code.
    #[cfg(test)]
    pub fn grey(code: u8) -> Self {
        Self { codes: [i32::from(code) * 256; 3], tree: 1, variance: 0.0 }
    }

    fn pack(self) -> u64 {
        let [r, g, b] = self.codes.map(|c| c as u64);
        r << 48 | g << 32 | b << 16 | u64::from(self.tree)
    }

    fn unpack(word: u64, variance: f32) -> Self {
        Self { codes: [48, 32, 16].map(|shift| (word >> shift) as u16 as i32), tree: word as u16, variance }
    }

    /// Squared distance in codes, mean over the channels.
    pub fn distance2(self, other: Self) -> f64 {
        let sum: f64 = (0..3).map(|c| f64::from(self.codes[c] - other.codes[c]).powi(2)).sum();
        sum / (3.0 * 65536.0)
    }

    /// The same distance to what is seen if the part `share` of the pixel shows what a neighbour shows that is not seen here.
    ///
    /// The neighbour may itself be a mixture: of two lights a (that of this pixel) and b with the mean m and the variance s^2,
    /// b is a + (m - a) + s^2 / (m - a).
    pub fn distance2_to_mix(self, other: Self, share: f64) -> f64 {
        let linear = |codes: [i32; 3]| codes.map(|code| srgb_to_linear(f64::from(code) / 65280.0));
        let (here, there) = (linear(self.codes), linear(other.codes));
        let apart = brightness(there) - brightness(here);
        let beyond = (1.0 + f64::from(other.variance) / (apart * apart).max(1e-12)).min(MOST_BEYOND);
        let square = |(c, (dark, bright)): (i32, (f64, f64))| {
            (255.0 * (linear_to_srgb(dark + share * beyond * (bright - dark)) - f64::from(c) / 65280.0)).powi(2)
        };
        self.codes.into_iter().zip(here.into_iter().zip(there)).map(square).sum::<f64>() / 3.0
    }

    /// The same, from the line between two.
    fn bend2(self, a: Self, b: Self) -> f64 {
        let sum: f64 = (0..3).map(|c| f64::from(2 * self.codes[c] - a.codes[c] - b.codes[c]).powi(2)).sum();
        sum / (3.0 * 65536.0)
    }
}

/// A neighbour is taken to show at least one part in so many of what lies beyond the edge.
const MOST_BEYOND: f64 = 64.0;

fn brightness([r, g, b]: [f64; 3]) -> f64 {
    0.25 * r + 0.625 * g + 0.125 * b
}

/// How a pixel fits in among its neighbours.
#[derive(Clone, Copy)]
pub(super) struct Fit {
    /// The largest squared step in codes from a straight line through it, in four directions: where the picture is smooth
    /// it is small, at an edge the square of the contrast.
    pub contrast2: f64,
    /// Whether the ray trees are all the same.
    pub same: bool,
    /// The pixel, and the neighbour that differs most.
    pub here: Look,
    pub other: Look,
}

impl Map {
    /// `thin`: see [`thin`](super::thin::thin).
    pub fn new(width: u32, height: u32, thin: Vec<u8>) -> Self {
        let pixels = || 0..u64::from(width) * u64::from(height);
        Self {
            width,
            height,
            words: pixels().map(|_| AtomicU64::new(0)).collect(),
            variances: pixels().map(|_| AtomicU32::new(0)).collect(),
            stale: pixels().map(|_| AtomicBool::new(true)).collect(),
            thin,
        }
    }

    /// Puts down a pixel.
    pub fn write(&self, x: u32, y: u32, look: Look) {
        let at = self.at(x, y);
        self.words[at].store(look.pack(), Ordering::Relaxed);
        self.variances[at].store(look.variance.to_bits(), Ordering::Relaxed);
        for row in y.saturating_sub(1)..self.height.min(y + 2) {
            let (from, to) = (self.at(x.saturating_sub(1), row), self.at(self.width.min(x + 2), row));
            self.stale[from..to].iter().for_each(|stale| stale.store(true, Ordering::Relaxed));
        }
    }

    /// Samples that a pixel needs so that thin objects are seen.
    pub fn first_look(&self, x: u32, y: u32) -> u32 {
        self.thin.get(self.at(x, y)).copied().unwrap_or_default().into()
    }

    /// What was put down last.
    pub fn look(&self, x: u32, y: u32) -> Look {
        let at = self.at(x, y);
        let variance = f32::from_bits(self.variances[at].load(Ordering::Relaxed));
        Look::unpack(self.words[at].load(Ordering::Relaxed), variance)
    }

    /// Whether a pixel or one of its neighbours was put down since this was asked last.
    pub fn take_stale(&self, x: u32, y: u32) -> bool {
        let stale = &self.stale[self.at(x, y)];
        stale.load(Ordering::Relaxed) && {
            stale.store(false, Ordering::Relaxed);
            true
        }
    }

    /// How a pixel fits in.
    pub fn fit(&self, x: u32, y: u32) -> Fit {
        let here = self.look(x, y);
        let near = |dx: i32, dy: i32| {
            let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
            (x < self.width && y < self.height).then(|| self.look(x, y))
        };
        let mut fit = Fit { contrast2: 0.0, same: here.tree != 0, here, other: here };
        let mut farthest = 0.0;
        for (dx, dy) in [(1, 0), (0, 1), (1, 1), (1, -1)] {
            let (a, b) = (near(dx, dy), near(-dx, -dy));
            let step = match (a, b) {
                (Some(a), Some(b)) => here.bend2(a, b),
                (Some(a), None) | (None, Some(a)) => here.distance2(a),
                (None, None) => 0.0,
            };
            fit.contrast2 = fit.contrast2.max(step);
            for neighbour in [a, b].into_iter().flatten() {
                fit.same &= neighbour.tree == here.tree;
                let distance2 = here.distance2(neighbour);
                if distance2 > farthest {
                    (farthest, fit.other) = (distance2, neighbour);
                }
            }
        }
        fit
    }

    fn at(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_was_put_down_and_its_neighbours_are_stale() {
        let map = Map::new(7, 5, Vec::new());
        let take = || (0..35).filter(|i| map.take_stale(i % 7, i / 7)).collect::<Vec<u32>>();
        assert_eq!(take().len(), 35);
        assert!(take().is_empty());
        map.write(0, 4, Look::grey(1));
        map.write(5, 1, Look::grey(2));
        assert_eq!(take(), [4, 5, 6, 11, 12, 13, 18, 19, 20, 21, 22, 28, 29]);
        assert!(take().is_empty());
    }

    #[test]
    fn a_neighbour_that_is_a_mixture_shows_what_it_is_mixed_with() {
        // A quarter of it is white on black: mean 1/4, variance 3/16.
        let grey = (linear_to_srgb(0.25) * 65280.0).round() as i32;
        let neighbour = Look { codes: [grey; 3], tree: 0, variance: 3.0 / 16.0 };
        for share in [0.01, 0.1, 0.5] {
            let found = Look::grey(0).distance2_to_mix(neighbour, share).sqrt();
            let white = 255.0 * linear_to_srgb(share);
            assert!((found - white).abs() < 0.02 * white, "{share}: {found}, {white}");
        }
    }
}
