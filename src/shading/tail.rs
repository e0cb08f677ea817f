//! What paths are taken to bring that are cut since they weigh little.
//!
//! Every surface of a ray tree shows light of its own l and sends on the part g = k_r + k_t of what comes from the next
//! one. If the surfaces behind the cut are like those before it, on average, then l + g l + g^2 l + .. = l / (1 - g)
//! comes back. So Hall and Greenberg's adaptive depth loses the difference from the average only, not all of the light.
//! The estimate is a function of the sample's own ray tree, made when that is complete; and since it is never above the
//! largest radiance of the scene, the weight of all that was cut times that bounds its error as well.

use crate::math::Rgb;

/// What one sample's rays have met so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tail {
    /// Light that the surfaces and the background send out themselves.
    own: Rgb,
    /// Parts that they send on.
    gain: f64,
    met: u32,
    /// Weight of the paths that were cut.
    cut: f64,
}

/// No scene is taken to send on more: tails are long enough.
const MOST_GAIN: f64 = 0.95;

impl Tail {
    /// A ray has ended where this light comes from.
    pub fn meet(&mut self, own: Rgb) {
        self.own += own;
        self.met += 1;
    }

    /// It has ended on a surface that sends on this part.
    pub fn send_on(&mut self, gain: f64) {
        self.gain += gain;
    }

    /// A path of this weight is cut.
    pub fn cut(&mut self, weight: f64) {
        self.cut += weight;
    }

    /// What all that was cut brings. `largest`: no radiance of the scene is above it.
    pub fn estimate(&self, largest: Option<f64>) -> Rgb {
        if self.cut == 0.0 || self.met == 0 {
            return Rgb::BLACK;
        }
        let met = f64::from(self.met);
        let radiance = self.own / (met * (1.0 - (self.gain / met).min(MOST_GAIN)));
        let least = |c: f64| largest.map_or(c, |largest| c.min(largest));
        Rgb::new(least(radiance.r), least(radiance.g), least(radiance.b)) * self.cut
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn among_equal_surfaces_the_tail_is_the_whole_series() {
        let (own, gain) = (Rgb::new(0.2, 0.1, 0.0), 0.75);
        let mut tail = Tail::default();
        assert_eq!(tail.estimate(None), Rgb::BLACK);
        for _ in 0..5 {
            tail.meet(own);
            tail.send_on(gain);
        }
        assert_eq!(tail.estimate(None), Rgb::BLACK);
        tail.cut(0.25);
        tail.cut(0.25);
        let series: f64 = (0..200).map(|i| gain.powi(i)).sum();
        let (got, want) = (tail.estimate(None), own * (0.5 * series));
        let apart = (got.r - want.r).abs() + (got.g - want.g).abs() + (got.b - want.b).abs();
        assert!(apart < 1e-12, "{got:?}, {want:?}");
        assert_eq!(tail.estimate(Some(0.5)).r, 0.25);
    }
}
