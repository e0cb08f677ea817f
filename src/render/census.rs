//! Where the error of the whole picture is, and which pixels to refine for it.
//!
//! Everything that is added up over pixels is whole numbers, so that the sums do not depend on the order of tiles and
//! threads, nor on how the film is cut into tiles.

use super::map::Fit;
use super::pixel::JUDGED;

/// Squared codes as whole numbers: 2^30 pixels of the largest error still fit.
const SCALE: f64 = 65536.0;

/// Pixels with one sample are judged together with all that fit in alike: by contrast in octaves, and by ray tree.
const CLASSES: usize = 18;

/// Bins of what refining is worth, four an octave, from 2^-20.
const BINS: usize = 160;
const BINS_AN_OCTAVE: f32 = 4.0;
const LOWEST: f32 = -80.0;

/// How the expected square of the error falls with the number of samples, where a forecast is needed.
const FALL: f64 = 1.5;

/// A round adds at most so many times the samples that a pixel has.
const GROWTH: u32 = 4;

/// Numbers of a round, by tile and then of the film.
#[derive(Clone, Debug)]
pub(super) struct Census {
    bins: Vec<Tally>,
    classes: [Class; CLASSES],
    /// Error of pixels that may not be refined any further.
    settled: Tally,
}

#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    pixels: u64,
    error: u64,
}

/// Pixels with one sample that fit in alike.
#[derive(Clone, Copy, Debug, Default)]
struct Class {
    /// Those that still have one.
    pixels: u64,
    /// Those that got more: how many, and how far the first sample was from their mean.
    checked: u64,
    error: u64,
}

impl Default for Census {
    fn default() -> Self {
        Self { bins: vec![Tally::default(); BINS], classes: Default::default(), settled: Tally::default() }
    }
}

/// What the pixels of the next round are told.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// Pixels for which another sample takes more than this from the sum of squared errors are refined.
    threshold: f64,
    /// Expected squared error of a pixel with one sample, by class.
    classes: [f64; CLASSES],
}

/// The class of a pixel with one sample.
fn class(fit: Fit) -> usize {
    let octave = ((0.5 * fit.contrast2.max(1e-9).log2()) as i32 + 1).clamp(0, 8);
    let octave = if fit.contrast2 < 1.0 { 0 } else { octave };
    octave as usize + if fit.same { 0 } else { CLASSES / 2 }
}

/// What is taken for the squared error of a class before one of its pixels was looked into.
fn guess(class: usize) -> f64 {
    let contrast = f64::from(1u32 << (class % (CLASSES / 2)));
    contrast * contrast / if class < CLASSES / 2 { 64.0 } else { 16.0 }
}

/// How many checks the guess weighs as much as.
const BELIEF: f64 = 2.0;

impl Census {
    /// A pixel that has got enough samples to be judged. `left`: samples that it may yet get.
    pub fn pixel(&mut self, variance: f64, samples: u32, left: u32) {
        let tally = if left == 0 { &mut self.settled } else { &mut self.bins[bin(variance / f64::from(samples))] };
        tally.pixels += 1;
        tally.error += whole(variance);
    }

    /// A pixel that still has one sample.
    pub fn unchecked(&mut self, fit: Fit) {
        self.classes[class(fit)].pixels += 1;
    }

    /// A pixel that had one sample and got more: the squared distance of the first from the mean.
    pub fn checked(&mut self, fit: Fit, distance2: f64) {
        let class = &mut self.classes[class(fit)];
        class.checked += 1;
        class.error += whole(distance2);
    }

    /// Adds that of another tile.
    pub fn merge(&mut self, other: &Census) {
        let pairs = self.bins.iter_mut().zip(&other.bins).chain([(&mut self.settled, &other.settled)]);
        for (mine, its) in pairs {
            mine.pixels += its.pixels;
            mine.error += its.error;
        }
        for (mine, its) in self.classes.iter_mut().zip(&other.classes) {
            mine.pixels += its.pixels;
            mine.checked += its.checked;
            mine.error += its.error;
        }
    }

    /// Takes over the checks of earlier rounds, which hold for good.
    pub fn keep_checks(&mut self, earlier: &Census) {
        for (mine, its) in self.classes.iter_mut().zip(&earlier.classes) {
            mine.checked += its.checked;
            mine.error += its.error;
        }
    }

    fn class_errors(&self) -> [f64; CLASSES] {
        std::array::from_fn(|i| {
            let class = self.classes[i];
            (class.error as f64 / SCALE + BELIEF * guess(i)) / (class.checked as f64 + BELIEF)
        })
    }

    /// All groups of pixels: how many, their squared error together, what refining one is worth.
    fn groups(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        let classes = self.class_errors();
        let bins = self
            .bins
            .iter()
            .enumerate()
            .map(|(i, tally)| (tally.pixels as f64, tally.error as f64 / SCALE, value_of(i)));
        let single = self.classes.into_iter().zip(classes);
        bins.chain(single.map(|(class, error)| (class.pixels as f64, class.pixels as f64 * error, error)))
    }

    fn pixels(&self) -> f64 {
        self.groups().map(|(pixels, ..)| pixels).sum::<f64>() + self.settled.pixels as f64
    }

    /// Estimated root mean square of the error of the picture, 8-bit codes.
    pub fn error(&self) -> f64 {
        let sum = self.groups().map(|(_, error, _)| error).sum::<f64>() + self.settled.error as f64 / SCALE;
        (sum / self.pixels().max(1.0)).sqrt()
    }

    /// What to do to reach an error of `target`; `None` if it is reached or nothing can be refined.
    ///
    /// A pixel with n samples and the squared error V gains about V/n by another sample. Refining wherever that is above
    /// one threshold costs the fewest samples for an error; the threshold is the largest one with which the picture
    /// is expected to come down to the target, or to half its error, before pixels are judged anew.
    pub fn plan(&self, target: f64) -> Option<Plan> {
        let error = self.error();
        let open: f64 = self.groups().map(|(pixels, ..)| pixels).sum();
        if error <= target || open == 0.0 {
            return None;
        }
        let goal = target.max(error / 2.0).powi(2) * self.pixels() - self.settled.error as f64 / SCALE;
        let after = |threshold: f64| -> f64 {
            let left = |value: f64| f64::from(factor(value, threshold)).powf(-FALL);
            self.groups().map(|(_, error, value)| error * left(value)).sum()
        };
        // Halving the octaves between which it lies; they are those of the bins.
        let (mut low, mut high) = (-21.0, 21.0);
        for _ in 0..12 {
            let middle = (low + high) / 2.0;
            if after(f64::exp2(middle)) <= goal { low = middle } else { high = middle }
        }
        Some(Plan { threshold: low.exp2(), classes: self.class_errors() })
    }
}

/// How many times its samples a pixel gets.
fn factor(value: f64, threshold: f64) -> u32 {
    // V/n falls with the power 5/2 of the samples.
    match value / threshold {
        r if r <= 1.0 => 1,
        r if r <= 5.6 => 2,
        _ => GROWTH,
    }
}

fn bin(value: f64) -> usize {
    ((value.max(1e-12) as f32).log2() * BINS_AN_OCTAVE - LOWEST).clamp(0.0, BINS as f32 - 1.0) as usize
}

/// The middle of a bin: what all its pixels are taken for, so that those are refined that a plan counts on.
fn value_of(bin: usize) -> f64 {
    f64::from(((bin as f32 + 0.5 + LOWEST) / BINS_AN_OCTAVE).exp2())
}

fn whole(squared_codes: f64) -> u64 {
    (squared_codes * SCALE + 0.5) as u64
}

impl Plan {
    /// Samples that a pixel of this squared error is to have, which has `samples`.
    pub fn refine(&self, variance: f64, samples: u32) -> u32 {
        samples.saturating_mul(factor(value_of(bin(variance / f64::from(samples))), self.threshold))
    }

    /// The same for a pixel with one sample.
    pub fn refine_single(&self, fit: Fit) -> u32 {
        if self.classes[class(fit)] > self.threshold { JUDGED } else { 1 }
    }

    /// Expected squared error of a pixel with one sample.
    pub fn single(&self, fit: Fit) -> f64 {
        self.classes[class(fit)]
    }
}
