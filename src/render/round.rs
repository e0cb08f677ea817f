//! One round of refinement: which pixels get more samples, and how wrong each is after it.

use super::census::{Census, Plan};
use super::map::{Fit, Look, Map};
use super::pixel::{JUDGED, Pixel};
use crate::math::lowbias32;

/// What all workers know in a round. It depends on the rounds before it alone, so that every order of tiles gives the
/// same picture.
#[derive(Debug)]
pub(super) struct Round<'a> {
    /// From 1.
    pub number: u32,
    /// What pixels looked like after the rounds before.
    pub map: &'a Map,
    /// None in round 1, in which pixels are looked into by chance.
    pub plan: Option<&'a Plan>,
    /// The most samples a pixel may get.
    pub limit: u32,
}

/// In round 1 one pixel of a square of this side is looked into.
const LOT: u32 = 8;

/// Whether the lot falls on a pixel in its square.
fn is_drawn(x: u32, y: u32) -> bool {
    let lot = lowbias32(lowbias32(x / LOT) ^ (y / LOT).wrapping_add(0x51ed_270b));
    lot % (LOT * LOT) == y % LOT * LOT + x % LOT
}

/// An edge that passes a pixel at a place of even chance is missed by all of n stratified samples with the chance
/// 1 / (2 n), and covers then a part of the pixel whose root mean square is this over n.
/// What a neighbour shows of what lies beyond the edge is half of it on average, hence twice 0.408.
const MISSED: f64 = 0.816;

/// Pixels whose few samples say too little of their error are the ones that are not refined: the error of n samples is
/// taken to be larger by a factor of 1 + OPTIMISM / n than these say.
const OPTIMISM: f64 = 4.0;

/// The squared contrast, in codes, below which neighbours say nothing, and that which two ray trees are taken to have.
const SMOOTH: f64 = 4.0;
const OTHER_TREE: f64 = 16.0;

impl Round<'_> {
    fn fit(&self, x: u32, y: u32) -> Fit {
        self.map.fit(self.number - 1, x, y)
    }

    /// Samples that a pixel is to have after this round.
    pub fn wanted(&self, pixel: &Pixel, x: u32, y: u32) -> u32 {
        let traced = pixel.traced();
        let wanted = match self.plan {
            None if is_drawn(x, y) => JUDGED,
            None => traced,
            Some(plan) if traced < JUDGED => plan.refine_single(self.fit(x, y)),
            Some(plan) => plan.refine(self.variance(pixel, x, y), traced),
        };
        wanted.min(self.limit)
    }

    /// Expected squared error of a pixel with enough samples: by these, and by what its neighbours say that they missed.
    fn variance(&self, pixel: &Pixel, x: u32, y: u32) -> f64 {
        let (fit, n) = (self.fit(x, y), f64::from(pixel.traced()));
        let missed = match fit {
            Fit { contrast2, here, other, .. } if contrast2 > SMOOTH => here.distance2_to_mix(other, MISSED / n),
            Fit { same: false, .. } => OTHER_TREE * (MISSED / n).powi(2),
            _ => 0.0,
        };
        pixel.variance() * (1.0 + OPTIMISM / n) + missed / (2.0 * n)
    }

    /// Puts a pixel into the census after its part of the round; its expected squared error.
    pub fn judge(&self, pixel: &Pixel, x: u32, y: u32, census: &mut Census) -> f64 {
        let traced = pixel.traced();
        if traced < JUDGED {
            let fit = self.fit(x, y);
            census.unchecked(fit);
            return self.plan.map_or(0.0, |plan| plan.single(fit));
        }
        let error = self.variance(pixel, x, y);
        census.pixel(error, traced, self.limit - traced);
        error
    }

    /// Tells the census how wrong the first sample of a pixel was, which was alone before this round.
    pub fn check(&self, pixel: &Pixel, x: u32, y: u32, census: &mut Census) {
        let before = self.map.look(self.number - 1, x, y);
        census.checked(self.fit(x, y), before.distance2(Look::of(pixel)));
    }
}
