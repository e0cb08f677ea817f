//! What the pixels of all tiles tell each other between two rounds.

use super::pixel::Pixel;
use super::scatter::Scatter;
use super::tile::Rect;
use crate::math::{linear_to_srgb_near, srgb_to_linear_near};
use std::ops::Range;
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

/// A colour: sRGB codes in 256ths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Codes([i32; 3]);

impl Codes {
    pub fn of(pixel: &Pixel) -> Self {
        let mean = pixel.mean();
        Self([mean.r, mean.g, mean.b].map(|c| (linear_to_srgb_near(c) * 65280.0 + 0.5) as i32))
    }

    /// Squared distance in codes, mean over the channels.
    pub fn distance2(self, other: Self) -> f64 {
        let sum: f64 = (0..3).map(|c| f64::from(self.0[c] - other.0[c]).powi(2)).sum();
        sum / (3.0 * 65536.0)
    }
}

/// What is seen in a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    codes: Codes,
    /// Part of the hash of the ray tree; 0 where samples differ.
    tree: u16,
    /// Variance of the brightness of single samples.
    variance: f32,
}

impl Look {
    pub fn of(pixel: &Pixel, scatter: &Scatter) -> Self {
        let tree = (scatter.tree() >> 16) as u16 | u16::from(scatter.tree() != 0);
        Self { codes: Codes::of(pixel), tree, variance: scatter.single_variance(pixel) }
    }

    /// All channels of one code.
    #[cfg(test)]
    pub fn grey(code: u8) -> Self {
        Self { codes: Codes([i32::from(code) * 256; 3]), tree: 1, variance: 0.0 }
    }

    fn pack(self) -> u64 {
        let [r, g, b] = self.codes.0.map(|c| c as u64);
        r << 48 | g << 32 | b << 16 | u64::from(self.tree)
    }

    fn unpack(word: u64, variance: f32) -> Self {
        let codes = Codes([48, 32, 16].map(|shift| (word >> shift) as u16 as i32));
        Self { codes, tree: word as u16, variance }
    }

    /// Squared distance in codes, mean over the channels.
    pub fn distance2(self, other: Self) -> f64 {
        self.codes.distance2(other.codes)
    }

    /// The same distance to what is seen if the part `share` of the pixel shows what a neighbour shows that is not seen here.
    ///
    /// The neighbour may itself be a mixture: of two lights a (that of this pixel) and b with the mean m and the variance s^2,
    /// b is a + (m - a) + s^2 / (m - a).
    pub fn distance2_to_mix(self, other: Self, share: f64) -> f64 {
        let linear = |codes: Codes| codes.0.map(|code| srgb_to_linear_near(code as u16));
        let (here, there) = (linear(self.codes), linear(other.codes));
        let apart = brightness(there) - brightness(here);
        let beyond = (1.0 + f64::from(other.variance) / (apart * apart).max(1e-12)).min(MOST_BEYOND);
        let square = |(c, (dark, bright)): (i32, (f64, f64))| {
            (255.0 * (linear_to_srgb_near(dark + share * beyond * (bright - dark)) - f64::from(c) / 65280.0)).powi(2)
        };
        self.codes.0.into_iter().zip(here.into_iter().zip(there)).map(square).sum::<f64>() / 3.0
    }
}

/// A neighbour is taken to show at least one part in so many of what lies beyond the edge.
const MOST_BEYOND: f64 = 64.0;

fn brightness([r, g, b]: [f64; 3]) -> f64 {
    0.25 * r + 0.625 * g + 0.125 * b
}

/// How a pixel fits in among its neighbours.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Fit {
    /// The largest squared step in codes from a straight line through it, in four directions: where the picture is smooth
    /// it is small, at an edge the square of the contrast.
    pub contrast2: f32,
    /// Whether the ray trees are all the same.
    pub same: bool,
    /// The neighbour that differs most: its place in the square of nine, row by row. The pixel itself if none does.
    pub other: u8,
}

/// What is seen in the pixels of a tile and around it, by channel, so that fits are found for many at once. (One by one, out of
/// the map, took a seventh of the time of a render of the demo to an error of 1.) What is off the film looks like the pixel
/// at its edge.
#[derive(Debug, Default)]
pub(super) struct Window {
    columns: usize,
    codes: [Vec<f32>; 3],
    trees: Vec<u16>,
    /// Of a row.
    pub fits: Vec<Fit>,
}

impl Window {
    /// Finds how the pixels `from..to` of a row fit in: they are in `fits` then.
    pub fn fit(&mut self, row: usize, from: usize, to: usize) {
        let Self { columns, codes, trees, fits } = self;
        fits.clear();
        fits.resize(to, Fit::default());
        // Of the nine pixels around the first.
        let starts: [usize; 9] = std::array::from_fn(|k| (row + k / 3) * *columns + from + k % 3);
        let around = starts.map(|start| {
            let part = start..start + (to - from);
            ([&codes[0][part.clone()], &codes[1][part.clone()], &codes[2][part.clone()]], &trees[part])
        });
        for (i, fit) in fits[from..].iter_mut().enumerate() {
            let at = |k: usize| around[k].0.map(|channel| channel[i]);
            let square = |[r, g, b]: [f32; 3]| (r * r + g * g + b * b) / (3.0 * 65536.0);
            let here = at(4);
            let apart = |k: usize| {
                let there = at(k);
                [here[0] - there[0], here[1] - there[1], here[2] - there[2]]
            };
            let (mut contrast2, mut farthest, mut other) = (0.0f32, 0.0, 4);
            for k in 0..4 {
                let (a, b) = (apart(k), apart(8 - k));
                let bend = square([a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
                contrast2 = if bend > contrast2 { bend } else { contrast2 };
                for (distance, k) in [(square(a), k), (square(b), 8 - k)] {
                    (farthest, other) = if distance > farthest { (distance, k as u8) } else { (farthest, other) };
                }
            }
            let tree = around[4].1[i];
            let same = (0..9).fold(tree != 0, |same, k| same & (around[k].1[i] == tree));
            *fit = Fit { contrast2, same, other };
        }
    }
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

    /// Puts down a pixel for the first time: all are stale from the beginning.
    pub fn begin(&self, x: u32, y: u32, look: Look) {
        let at = self.at(x, y);
        self.words[at].store(look.pack(), Ordering::Relaxed);
        self.variances[at].store(look.variance.to_bits(), Ordering::Relaxed);
    }

    /// Puts down a pixel that has changed.
    pub fn write(&self, x: u32, y: u32, look: Look) {
        self.begin(x, y, look);
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

    /// Which pixels of a row, from (x, y) on, were put down since this was asked last, they or one of their neighbours; the first of
    /// them and the end, if there are any.
    pub fn take_stale(&self, x: u32, y: u32, width: u32, stale: &mut Vec<bool>) -> Option<Range<usize>> {
        let row = &self.stale[self.at(x, y)..][..width as usize];
        let first = row.iter().position(|stale| stale.load(Ordering::Relaxed))?;
        stale.clear();
        stale.extend(row.iter().map(|stale| stale.load(Ordering::Relaxed)));
        row[first..].iter().for_each(|stale| stale.store(false, Ordering::Relaxed));
        let last = stale.iter().rposition(|stale| *stale)?;
        Some(first..last + 1)
    }

    /// Looks at the pixels of a tile and around it.
    pub fn look_around(&self, rect: Rect, window: &mut Window) {
        let around = |start: u32, size: u32, end: u32| {
            (0..size + 2).map(move |i| (start + i).saturating_sub(1).min(end - 1) as usize)
        };
        window.columns = rect.width as usize + 2;
        window.codes.iter_mut().for_each(Vec::clear);
        window.trees.clear();
        for y in around(rect.y, rect.height, self.height) {
            let row = &self.words[y * self.width as usize..][..self.width as usize];
            for x in around(rect.x, rect.width, self.width) {
                let look = Look::unpack(row[x].load(Ordering::Relaxed), 0.0);
                for (channel, code) in window.codes.iter_mut().zip(look.codes.0) {
                    channel.push(code as f32);
                }
                window.trees.push(look.tree);
            }
        }
    }

    /// The neighbour that differs most, which is the pixel itself if none does.
    pub fn other(&self, x: u32, y: u32, fit: Fit) -> Look {
        let off = |at: u32, k: u8, size: u32| (at + u32::from(k)).saturating_sub(1).min(size - 1);
        self.look(off(x, fit.other % 3, self.width), off(y, fit.other / 3, self.height))
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
        let take = || {
            let (mut stale, mut all) = (Vec::new(), Vec::new());
            for (x, y, width) in (0..5).flat_map(|y| [(0, y, 3), (3, y, 4)]) {
                if let Some(range) = map.take_stale(x, y, width, &mut stale) {
                    assert!(stale[range.start] && stale[range.end - 1]);
                    all.extend((0..width).filter(|i| stale[*i as usize]).map(|i| y * 7 + x + i));
                }
            }
            all
        };
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
        let grey = (crate::math::linear_to_srgb(0.25) * 65280.0).round() as i32;
        let neighbour = Look { codes: Codes([grey; 3]), tree: 0, variance: 3.0 / 16.0 };
        for share in [0.01, 0.1, 0.5] {
            let found = Look::grey(0).distance2_to_mix(neighbour, share).sqrt();
            let white = 255.0 * crate::math::linear_to_srgb(share);
            assert!((found - white).abs() < 0.02 * white, "{share}: {found}, {white}");
        }
    }

    #[test]
    fn fits_are_those_of_each_pixel_alone_in_any_tile() {
        let (width, height) = (13, 9);
        let map = Map::new(width, height, Vec::new());
        let mut random = crate::math::SplitMix64(8);
        for at in 0..width * height {
            let codes = Codes([0; 3].map(|_: i32| (random.unit() * 65280.0) as i32));
            let look = Look { codes, tree: u16::from(random.unit() < 0.95), variance: 0.0 };
            map.write(at % width, at / width, look);
        }
        let mut window = Window::default();
        for (left, top, w, h) in [(0, 0, 13, 9), (8, 0, 5, 8), (8, 8, 5, 1), (0, 4, 1, 1)] {
            map.look_around(Rect { x: left, y: top, width: w, height: h }, &mut window);
            for (row, from) in (0..h).map(|row| (row, row % w)) {
                window.fit(row as usize, from as usize, w as usize);
                for column in from..w {
                    let (x, y) = (left + column, top + row);
                    let near = |dx: i32, dy: i32| {
                        let off = |at: u32, by: i32, size: u32| at.saturating_add_signed(by).min(size - 1);
                        map.look(off(x, dx, width), off(y, dy, height))
                    };
                    let here = map.look(x, y);
                    let (mut contrast2, mut farthest, mut same) = (0.0f64, 0.0f64, here.tree != 0);
                    for (dx, dy) in [(1, 0), (0, 1), (1, 1), (1, -1)] {
                        let (a, b) = (near(dx, dy), near(-dx, -dy));
                        let line = Codes([0, 1, 2].map(|c| a.codes.0[c] + b.codes.0[c] - here.codes.0[c]));
                        contrast2 = contrast2.max(here.distance2(Look { codes: line, ..here }));
                        farthest = farthest.max(here.distance2(a)).max(here.distance2(b));
                        same &= a.tree == here.tree && b.tree == here.tree;
                    }
                    let fit = window.fits[column as usize];
                    assert!((f64::from(fit.contrast2) - contrast2).abs() < 1e-5 * contrast2, "{x}, {y}: {fit:?}");
                    assert!((here.distance2(map.other(x, y, fit)) - farthest).abs() < 1e-5 * farthest, "{x}, {y}");
                    assert_eq!(fit.same, same, "{x}, {y}");
                }
            }
        }
    }
}
