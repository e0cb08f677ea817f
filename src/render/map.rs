//! What the pixels of all tiles tell each other between two rounds.

use super::pixel::Pixel;
use crate::math::{linear_to_srgb, srgb_to_linear};
use std::sync::atomic::{AtomicU64, Ordering};

/// A word a pixel: its codes and its ray tree. Tiles write their pixels while they are traced, and all wait for that before
/// they read those of others, so that what is read does not depend on who is first.
#[derive(Debug)]
pub(super) struct Map {
    width: u32,
    height: u32,
    words: Vec<AtomicU64>,
}

/// What is seen in a pixel.
#[derive(Clone, Copy)]
pub(super) struct Look {
    /// sRGB codes in 256ths.
    codes: [i32; 3],
    /// Part of the hash of the ray tree; 0 where samples differ.
    tree: u16,
}

impl Look {
    pub fn of(pixel: &Pixel) -> Self {
        let mean = pixel.mean();
        let codes = [mean.r, mean.g, mean.b].map(|c| (linear_to_srgb(c) * 65280.0 + 0.5) as i32);
        Self { codes, tree: (pixel.tree() >> 16) as u16 | u16::from(pixel.tree() != 0) }
    }

    fn pack(self) -> u64 {
        let [r, g, b] = self.codes.map(|c| c as u64);
        r << 48 | g << 32 | b << 16 | u64::from(self.tree)
    }

    fn unpack(word: u64) -> Self {
        Self { codes: [48, 32, 16].map(|shift| (word >> shift) as u16 as i32), tree: word as u16 }
    }

    /// Squared distance in codes, mean over the channels.
    pub fn distance2(self, other: Self) -> f64 {
        let sum: f64 = (0..3).map(|c| f64::from(self.codes[c] - other.codes[c]).powi(2)).sum();
        sum / (3.0 * 65536.0)
    }

    /// The same distance to what is seen if the part `share` of the light comes from another look instead.
    pub fn distance2_to_mix(self, other: Self, share: f64) -> f64 {
        let square = |here: i32, there: i32| {
            let [here, there] = [here, there].map(|code| f64::from(code) / 65280.0);
            let [dark, bright] = [here, there].map(srgb_to_linear);
            (255.0 * (linear_to_srgb(dark + share * (bright - dark)) - here)).powi(2)
        };
        (0..3).map(|c| square(self.codes[c], other.codes[c])).sum::<f64>() / 3.0
    }

    /// The same, from the line between two.
    fn bend2(self, a: Self, b: Self) -> f64 {
        let sum: f64 = (0..3).map(|c| f64::from(2 * self.codes[c] - a.codes[c] - b.codes[c]).powi(2)).sum();
        sum / (3.0 * 65536.0)
    }
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
    pub fn new(width: u32, height: u32) -> Self {
        let words = (0..u64::from(width) * u64::from(height)).map(|_| AtomicU64::new(0)).collect();
        Self { width, height, words }
    }

    /// Puts down a pixel.
    pub fn write(&self, x: u32, y: u32, look: Look) {
        self.words[self.at(x, y)].store(look.pack(), Ordering::Relaxed);
    }

    /// What was put down last.
    pub fn look(&self, x: u32, y: u32) -> Look {
        Look::unpack(self.words[self.at(x, y)].load(Ordering::Relaxed))
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
