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
const GROWTH: u8 = 4;

/// Pixels that are refined or not together: the bins, the classes, and those that may not be refined any further.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Group(u8);

const GROUPS: usize = BINS + CLASSES + 1;
const SETTLED: usize = GROUPS - 1;

impl Group {
    fn of_class(class: usize) -> Self {
        Self((BINS + class) as u8)
    }

    /// The class of pixels with one sample.
    fn class(self) -> Option<usize> {
        usize::from(self.0).checked_sub(BINS).filter(|class| *class < CLASSES)
    }
}

/// Numbers of a round, by tile and then of the film.
#[derive(Clone, Debug)]
pub(super) struct Census {
    /// Pixels of each group, and the squared error of all but those with one sample.
    groups: Vec<Tally>,
    /// Pixels of each class that had one sample and got more: how far the first was from their mean.
    checks: [Tally; CLASSES],
}

#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    pixels: u64,
    error: u64,
}

impl Tally {
    fn add(&mut self, squared_error: f64) {
        self.pixels += 1;
        self.error += whole(squared_error);
    }

    fn merge(&mut self, other: Tally) {
        self.pixels += other.pixels;
        self.error += other.error;
    }
}

impl Default for Census {
    fn default() -> Self {
        Self { groups: vec![Tally::default(); GROUPS], checks: Default::default() }
    }
}

/// What the pixels of the next round are told.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// How many times its samples a pixel gets.
    growth: [u8; GROUPS],
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
    pub fn pixel(&mut self, variance: f64, samples: u32, left: u32) -> Group {
        let group = if left == 0 { SETTLED } else { bin(variance / f64::from(samples)) };
        self.groups[group].add(variance);
        Group(group as u8)
    }

    /// A pixel that still has one sample.
    pub fn unchecked(&mut self, fit: Fit) -> Group {
        let group = Group::of_class(class(fit));
        self.groups[usize::from(group.0)].pixels += 1;
        group
    }

    /// A pixel that is as it was.
    pub fn again(&mut self, group: Group, error: f64) {
        self.groups[usize::from(group.0)].add(error);
    }

    /// A pixel that had one sample and got more: the squared distance of the first from the mean.
    pub fn checked(&mut self, group: Group, distance2: f64) {
        if let Some(class) = group.class() {
            self.checks[class].add(distance2);
        }
    }

    /// Adds that of another tile.
    pub fn merge(&mut self, other: &Census) {
        for (mine, its) in self.groups.iter_mut().zip(&other.groups) {
            mine.merge(*its);
        }
        self.keep_checks(other);
    }

    /// Takes over checks, which hold for good.
    pub fn keep_checks(&mut self, earlier: &Census) {
        for (mine, its) in self.checks.iter_mut().zip(&earlier.checks) {
            mine.merge(*its);
        }
    }

    fn class_errors(&self) -> [f64; CLASSES] {
        std::array::from_fn(|i| {
            let checks = self.checks[i];
            (checks.error as f64 / SCALE + BELIEF * guess(i)) / (checks.pixels as f64 + BELIEF)
        })
    }

    /// All groups that can be refined: how many pixels, their squared error together, what refining one is worth.
    fn open(&self, classes: &[f64; CLASSES]) -> impl Iterator<Item = (f64, f64, f64)> {
        self.groups[..SETTLED].iter().enumerate().map(|(i, tally)| {
            let pixels = tally.pixels as f64;
            match Group(i as u8).class() {
                Some(class) => (pixels, pixels * classes[class], classes[class]),
                None => (pixels, tally.error as f64 / SCALE, value_of(i)),
            }
        })
    }

    fn settled(&self) -> f64 {
        self.groups[SETTLED].error as f64 / SCALE
    }

    fn pixels(&self) -> f64 {
        self.groups.iter().map(|tally| tally.pixels).sum::<u64>() as f64
    }

    /// Estimated root mean square of the error of the picture, 8-bit codes.
    pub fn error(&self) -> f64 {
        let sum = self.open(&self.class_errors()).map(|(_, error, _)| error).sum::<f64>() + self.settled();
        (sum / self.pixels().max(1.0)).sqrt()
    }

    /// What to do to reach an error of `target`; `None` if it is reached or nothing can be refined. A plan refines at least
    /// one pixel: since the samples of a pixel are limited, there is a last plan.
    ///
    /// A pixel with n samples and the squared error V gains about V/n by another sample. Refining wherever that is above
    /// one threshold costs the fewest samples for an error; the threshold is the largest one with which the picture
    /// is expected to come down to the target, or to half its error, before pixels are judged anew.
    pub fn plan(&self, target: f64) -> Option<Plan> {
        let (error, classes) = (self.error(), self.class_errors());
        if error <= target {
            return None;
        }
        let goal = target.max(error / 2.0).powi(2) * self.pixels() - self.settled();
        let after = |threshold: f64| -> f64 {
            let left = |value: f64| f64::from(factor(value, threshold)).powf(-FALL);
            self.open(&classes).map(|(_, error, value)| error * left(value)).sum()
        };
        // Halving the octaves between which it lies; they are those of the bins.
        let (mut low, mut high) = (-21.0, 21.0);
        for _ in 0..12 {
            let middle = (low + high) / 2.0;
            if after(f64::exp2(middle)) <= goal { low = middle } else { high = middle }
        }
        let (mut growth, mut refined) = ([1; GROUPS], false);
        for (growth, (pixels, _, value)) in growth.iter_mut().zip(self.open(&classes)) {
            *growth = factor(value, low.exp2());
            refined |= *growth > 1 && pixels > 0.0;
        }
        refined.then_some(Plan { growth, classes })
    }
}

/// How many times its samples a pixel gets.
fn factor(value: f64, threshold: f64) -> u8 {
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
    /// Samples that a pixel of this group is to have, which has `samples`.
    pub fn refine(&self, group: Group, samples: u32) -> u32 {
        match self.growth[usize::from(group.0)] {
            growth if growth > 1 && samples < JUDGED => JUDGED,
            growth => samples.saturating_mul(growth.into()),
        }
    }

    /// Expected squared error of a pixel with one sample, if this is a group of such.
    pub fn single(&self, group: Group) -> Option<f64> {
        group.class().map(|class| self.classes[class])
    }
}
