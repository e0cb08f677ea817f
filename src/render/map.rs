//! What the pixels of all tiles tell each other between two rounds.

use super::pixel::Pixel;
use super::rect::Rect;
use super::scatter::Scatter;
use crate::math::{linear_to_srgb_near, srgb_to_linear_near};
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
    /// Whether a pixel was written since it was judged, or one of its neighbours has changed. (Judging all pixels after
    /// each round took a fifth of the time of a render of the demo to an error of 1.)
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

    /// Whether it says as much as before of the pixels around, within the quarter of a code.
    fn is_like(self, before: Self) -> bool {
        let is_calm = self.variance <= 2.0 * before.variance.max(QUIET);
        self.tree == before.tree && is_calm && self.distance2(before) < UNSEEN
    }

    /// The same distance to what is seen if the part `share` of the pixel shows what a neighbour shows that is not seen
    /// here.
    ///
    /// The neighbour may itself be a mixture: of two lights a (that of this pixel) and b with the mean m and the
    /// variance s^2, b is a + (m - a) + s^2 / (m - a).
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

/// The squared change in codes that does not make a pixel's neighbours be judged anew.
const UNSEEN: f64 = 1.0 / 16.0;

/// Variance of the brightness of single samples that is as good as none: about a code where the picture is dark.
const QUIET: f32 = 1e-7;

/// A neighbour is taken to show at least one part in so many of what lies beyond the edge.
const MOST_BEYOND: f64 = 64.0;

fn brightness([r, g, b]: [f64; 3]) -> f64 {
    0.25 * r + 0.625 * g + 0.125 * b
}

/// How a pixel fits in among its neighbours.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Fit {
    /// The largest squared step in codes from a straight line through it, in four directions: where the picture is
    /// smooth it is small, at an edge the square of the contrast.
    pub contrast2: f32,
    /// Whether the ray trees are all the same.
    pub same: bool,
    /// The neighbour that differs most: its place in the square of nine, row by row. The pixel itself if none does.
    pub other: u8,
}

/// What is seen in the pixels of a tile and around it, by channel, so that fits are found for many at once. (One by
/// one, out of the map, took a seventh of the time of a render of the demo to an error of 1.) What is off the film
/// looks like the pixel at its edge.
#[derive(Debug, Default)]
pub(super) struct Window {
    columns: usize,
    /// Codes by channel, and the ray tree: all are whole numbers that f32 holds.
    layers: [Vec<f32>; 4],
    /// Of a row.
    pub fits: Vec<Fit>,
}

/// Pixels whose fits are found at once.
const LANES: usize = 8;

impl Window {
    /// Finds how those pixels of a row fit in that are stale, and some beside them: they are in `fits` then.
    pub fn fit(&mut self, row: usize, stale: &[bool]) {
        self.fits.resize(stale.len(), Fit::default());
        for (start, stale) in (0..).step_by(LANES).zip(stale.chunks(LANES)) {
            if stale.contains(&true) {
                let fits = self.fit_lanes(row * self.columns + start);
                self.fits[start..start + stale.len()].copy_from_slice(&fits[..stale.len()]);
            }
        }
    }

    /// Of the pixels right and below of the one at this place.
    fn fit_lanes(&self, place: usize) -> [Fit; LANES] {
        let at = |layer: usize, k: usize| -> &[f32; LANES] {
            let start = place + k / 3 * self.columns + k % 3;
            self.layers[layer][start..start + LANES].try_into().expect("as many as asked for")
        };
        let (mut contrast2, mut farthest, mut other) = ([0.0f32; LANES], [0.0f32; LANES], [4.0f32; LANES]);
        for k in 0..4 {
            let (mut bend, mut first, mut second) = ([0.0f32; LANES], [0.0f32; LANES], [0.0f32; LANES]);
            for channel in 0..3 {
                let (here, a, b) = (at(channel, 4), at(channel, k), at(channel, 8 - k));
                for i in 0..LANES {
                    let (a, b) = (here[i] - a[i], here[i] - b[i]);
                    bend[i] += (a + b) * (a + b);
                    first[i] += a * a;
                    second[i] += b * b;
                }
            }
            for i in 0..LANES {
                contrast2[i] = if bend[i] > contrast2[i] { bend[i] } else { contrast2[i] };
                other[i] = if first[i] > farthest[i] { k as f32 } else { other[i] };
                farthest[i] = if first[i] > farthest[i] { first[i] } else { farthest[i] };
                other[i] = if second[i] > farthest[i] { (8 - k) as f32 } else { other[i] };
                farthest[i] = if second[i] > farthest[i] { second[i] } else { farthest[i] };
            }
        }
        let (tree, mut others) = (at(3, 4), [0.0f32; LANES]);
        for k in 0..9 {
            let there = at(3, k);
            for i in 0..LANES {
                others[i] += (tree[i] - there[i]).abs();
            }
        }
        std::array::from_fn(|i| Fit {
            contrast2: contrast2[i] / (3.0 * 65536.0),
            same: tree[i] != 0.0 && others[i] == 0.0,
            other: other[i] as u8,
        })
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

    /// Puts down a pixel that has got samples. If it shows what it did, its neighbours need not be judged anew.
    pub fn write(&self, x: u32, y: u32, look: Look) {
        let before = self.look(x, y);
        self.begin(x, y, look);
        if look.is_like(before) {
            self.stale[self.at(x, y)].store(true, Ordering::Relaxed);
            return;
        }
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

    /// Which pixels of a row, from (x, y) on, were put down since this was asked last, they or a neighbour that has
    /// changed; whether there are any.
    pub fn take_stale(&self, x: u32, y: u32, width: u32, stale: &mut Vec<bool>) -> bool {
        let row = &self.stale[self.at(x, y)..][..width as usize];
        stale.clear();
        stale.extend(row.iter().map(|stale| stale.load(Ordering::Relaxed)));
        let are_there = stale.contains(&true);
        if are_there {
            row.iter().for_each(|stale| stale.store(false, Ordering::Relaxed));
        }
        are_there
    }

    /// Looks at the pixels of a tile and around it.
    pub fn look_around(&self, rect: Rect, window: &mut Window) {
        let (left, right) = (rect.x as usize, (rect.x + rect.width) as usize);
        let inside = left.saturating_sub(1)..(right + 1).min(self.width as usize);
        window.columns = rect.width as usize + 2;
        window.layers.iter_mut().for_each(Vec::clear);
        for y in (0..rect.height + 2).map(|i| (rect.y + i).saturating_sub(1).min(self.height - 1)) {
            let row = &self.words[y as usize * self.width as usize..][..self.width as usize];
            for (layer, shift) in window.layers.iter_mut().zip([48, 32, 16, 0]) {
                let part = |word: &AtomicU64| f32::from((word.load(Ordering::Relaxed) >> shift) as u16);
                if left == 0 {
                    layer.push(part(&row[0]));
                }
                layer.extend(row[inside.clone()].iter().map(part));
                if right == row.len() {
                    layer.push(part(&row[right - 1]));
                }
            }
        }
        // So many may be found at once beyond the last pixel.
        for layer in &mut window.layers {
            layer.resize(layer.len() + LANES, 0.0);
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
                if map.take_stale(x, y, width, &mut stale) {
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
        // What has not changed is judged by its own samples, and says nothing new of those around it.
        map.write(5, 1, Look::grey(2));
        map.write(3, 3, Look { tree: 1, ..map.look(3, 3) });
        assert_eq!(take(), [12, 16, 17, 18, 23, 24, 25, 30, 31, 32]);
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
                let stale: Vec<bool> = (0..w).map(|column| column >= from).collect();
                window.fit(row as usize, &stale);
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
