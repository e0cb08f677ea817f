//! One round of refinement: which pixels get more samples, and how wrong each is after it.
//!
//! How much there is to gain was computed from 256 samples of a part of the pixels. Were the true error of each pixel
//! known for any number of samples, an error of 1 would take 10.4 rays a pixel of the demo at 1280x720 (uniform
//! samples: 49.5; rounds: 12.6 of all of its pixels) and 72.6 of the sphereflake at 720x720 (uniform: 178; rounds: 78).
//! Two sums a pixel, the second of paths that weigh less than 1/8, from fewer samples (multi-level Monte Carlo), would
//! make it 10.0 and 67.5: too little for what it takes.
//!
//! So it would be with pixels without samples. Bilinear between every second pixel, by classes of ray tree, contrast
//! and cost whose errors are known exactly, half of the demo's pixels need none, which spares 2.0 rays a pixel net
//! (every fourth: 1.3; the sphereflake: 0.5): 10.6 for 12.6 at best, and those are the rays that run most alike. With
//! camera rays alone for what surface a sample sees and few whole ones for its light, the demo would need 13.5 for 13.7
//! (from 32 samples of a quarter of the pixels, n^-3/2), since the variance is within surfaces: textures, shadows,
//! mirrors.

use super::census::{Census, FALL, Group, Plan};
use super::map::{Fit, Look, Map};
use super::pixel::Pixel;
use super::scatter::{JUDGED, Scatter};
use super::thin::HITS;
use crate::math::lowbias32;

/// What all workers know in a round. It depends on the rounds before it alone, so that every order of tiles gives the
/// same picture.
#[derive(Debug)]
pub(super) struct Round<'a> {
    /// What pixels look like.
    pub map: &'a Map,
    /// None in round 1, in which pixels are looked into by chance.
    pub plan: Option<&'a Plan>,
    /// The most samples a pixel may get.
    pub limit: u32,
}

/// A pixel of a tile.
pub(super) struct Seen<'a> {
    pub pixel: &'a Pixel,
    pub scatter: &'a mut Scatter,
    /// What the last census made of it.
    pub group: &'a mut Group,
}

/// In round 1 one pixel of a square of this side is looked into. (With 16 at 1280x720 classes were known worse, and the
/// demo took 3 % more rays for an error.)
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

/// Where all samples of a pixel agree within a code or so, an edge next to it may still cut a corner off. A corner of
/// the part 1/n of the pixel is about n^-1/2 wide, so that the chance falls no faster. 0.4 gained nothing on a fine
/// fence.
const CORNER: f64 = 0.25;

/// Pixels whose few samples say too little of their error are the ones that are not refined: the error of n samples is
/// taken to be larger by a factor of 1 + OPTIMISM / n than these say.
const OPTIMISM: f64 = 4.0;

/// The squared contrast, in codes, below which neighbours say nothing, and that which two ray trees are taken to have.
const SMOOTH: f32 = 4.0;
const OTHER_TREE: f64 = 16.0;

impl Round<'_> {
    /// Whether a pixel may get samples in this round.
    pub fn looks_into(&self, group: Group, x: u32, y: u32) -> bool {
        match self.plan {
            None => is_drawn(x, y) || self.map.first_look(x, y) > 0,
            Some(plan) => plan.refines(group),
        }
    }

    /// Samples that such a pixel is to have after it, which has `traced`.
    pub fn wanted(&self, group: Group, traced: u32, x: u32, y: u32) -> u32 {
        let wanted = match self.plan {
            None if is_drawn(x, y) => JUDGED.max(self.map.first_look(x, y)),
            None => traced.max(self.map.first_look(x, y)),
            Some(plan) => plan.refine(group, traced),
        };
        wanted.min(self.limit)
    }

    /// Puts down what a pixel looks like now, which had `before` samples. If that was one, the census is told how wrong
    /// it was.
    pub fn note(&self, seen: &mut Seen, before: u32, (x, y): (u32, u32), census: &mut Census) {
        let Seen { pixel, scatter, group } = seen;
        let look = Look::of(pixel, scatter);
        let distance2 = self.map.look(x, y).distance2(look);
        let is_thin = self.map.first_look(x, y) > 0;
        // What thin objects hide until they are hit is no measure for other pixels.
        if !is_thin && scatter.judged > 0.0 {
            census.compare(f64::from(scatter.judged) * share_gained(before, pixel.traced()), distance2);
        }
        if before == 1 && (self.plan.is_some() || is_drawn(x, y)) {
            census.checked(**group, distance2);
        }
        self.map.write(x, y, look);
        // Pixels whose few samples say too little of their error are the ones that are not refined.
        let n = f64::from(pixel.traced());
        let doubt =
            (1.0 + OPTIMISM / n) * if is_thin { thin_doubt(n, f64::from(self.map.first_look(x, y))) } else { 1.0 };
        scatter.own = (scatter.variance(pixel) * doubt) as f32;
    }

    /// Expected squared error of a pixel before this round.
    pub fn error_before(&self, scatter: &Scatter, group: Group) -> f64 {
        let single = self.plan.and_then(|plan| plan.single(group));
        single.unwrap_or_else(|| self.corrected(scatter.judged))
    }

    /// A squared error that pixels tell, as the last census takes it.
    pub fn corrected(&self, error: f32) -> f64 {
        f64::from(error) * self.plan.map_or(1.0, |plan| plan.correction)
    }

    /// Puts a pixel into the census, when all tiles have been traced.
    pub fn judge(&self, seen: &mut Seen, fit: Fit, (x, y): (u32, u32), census: &mut Census) {
        let Seen { pixel, scatter, group } = seen;
        let traced = pixel.traced();
        if traced < JUDGED {
            **group = census.unchecked(fit, scatter.cost(pixel));
            return;
        }
        scatter.judged = (f64::from(scatter.own) + self.missed(pixel, scatter.own, fit, x, y)) as f32;
        let work = scatter.cost(pixel) * f64::from(traced);
        **group = census.pixel(f64::from(scatter.judged), work, self.limit > traced);
    }

    /// Expected square of the error for what all samples of a pixel may have missed, as its neighbours show.
    fn missed(&self, pixel: &Pixel, own: f32, fit: Fit, x: u32, y: u32) -> f64 {
        let n = f64::from(pixel.traced());
        let error = if fit.contrast2 > SMOOTH {
            self.map.look(x, y).distance2_to_mix(self.map.other(x, y, fit), MISSED / n)
        } else if !fit.same {
            OTHER_TREE * (MISSED / n).powi(2)
        } else {
            return 0.0;
        };
        let is_plain = f64::from(own) * n * n.sqrt() < 1.0;
        error * if is_plain { CORNER / n.sqrt() } else { 0.5 / n }
    }
}

/// Something of the width w < 1 is not stratified by fewer than w^-2 samples, so that the variance falls as n^-1 only
/// until then. The samples themselves tell a part of it, hence the power (a fence of 0.3 needs 1/2, a wire of 0.03
/// needs 1).
fn thin_doubt(n: f64, first_look: f64) -> f64 {
    n.sqrt().min(first_look / HITS).max(1.0).powf(0.75)
}

/// The part of the expected squared error E(n) that more samples take away. Since samples are added to those that are
/// there, it is also the mean square of the change: E(n) - E(m).
pub(super) fn share_gained(before: u32, after: u32) -> f64 {
    1.0 - (f64::from(before) / f64::from(after)).powf(FALL)
}
