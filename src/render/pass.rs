//! The order in which samples are traced.

use super::scatter::JUDGED;

/// Which samples of every pixel are traced next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Sample 0 of the pixels on a lattice of this step (8, 4, 2, 1) that no coarser lattice had.
    Lattice {
        /// Pixels between lattice points.
        step: u32,
    },
    /// Samples `from..to` of every pixel.
    Refine {
        /// First sample.
        from: u32,
        /// One past the last sample.
        to: u32,
    },
    /// More samples where the error is: the number of the round, from 1.
    Adapt {
        /// In round 1 some pixels everywhere are looked into, to learn what single samples miss.
        round: u32,
    },
}

/// Pixels between the points of the coarsest lattice; tiles start on it.
pub(super) const COARSEST: u32 = 8;

/// Samples that one pass adds at most, so that a pass is never long.
const MAX_PER_PASS: u32 = 16;

impl Pass {
    /// The passes of a render with this many samples a pixel: the lattices from coarse to fine, then up to 4, 8 and 16
    /// samples, then by 16: after each pass the picture is told and judged, which costs as much as some samples. (By
    /// four and up to 32 it is told less often, 1 % less in all at 16 samples, but forecasts then learn too late that
    /// the machine has become slower, or, where they learn that within a pass, take what one part of a picture costs
    /// for that.)
    pub fn sequence(samples: u32) -> Vec<Pass> {
        let mut passes = Self::lattices();
        let mut from = 1;
        while from < samples {
            let to = if from < JUDGED { JUDGED } else { from + from.min(MAX_PER_PASS) }.min(samples);
            passes.push(Pass::Refine { from, to });
            from = to;
        }
        passes
    }

    /// The passes that give every pixel its first sample.
    pub fn lattices() -> Vec<Pass> {
        [COARSEST, 4, 2, 1].map(|step| Pass::Lattice { step }).to_vec()
    }

    /// The samples that this pass traces in the pixel (x, y) of the film; none where that depends on the picture.
    pub fn samples_at(self, x: u32, y: u32) -> std::ops::Range<u32> {
        match self {
            Pass::Lattice { step } => {
                let on = |step: u32| x.is_multiple_of(step) && y.is_multiple_of(step);
                let due = on(step) && (step == COARSEST || !on(2 * step));
                0..u32::from(due)
            }
            Pass::Refine { from, to } => from..to,
            Pass::Adapt { .. } => 0..0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_of_every_pixel_is_traced_exactly_once_and_in_order() {
        for samples in [1, 2, 3, 16, 37, 100] {
            for (x, y) in [(0, 0), (1, 0), (4, 6), (7, 7), (12, 8)] {
                let traced: Vec<u32> = Pass::sequence(samples).into_iter().flat_map(|p| p.samples_at(x, y)).collect();
                assert_eq!(traced, (0..samples).collect::<Vec<_>>(), "{samples} at ({x}, {y})");
            }
        }
    }

    #[test]
    fn powers_of_two_from_16_on_are_ends_of_passes_and_none_is_long() {
        let passes = Pass::sequence(4096).into_iter();
        let refined =
            passes.filter_map(|pass| if let Pass::Refine { from, to } = pass { Some((from, to)) } else { None });
        let (mut ends, mut longest) = (Vec::new(), 0);
        for (from, to) in refined {
            ends.push(to);
            longest = longest.max(to - from);
        }
        assert!((4..=12).all(|power| ends.contains(&(1 << power))), "{ends:?}");
        assert_eq!(longest, MAX_PER_PASS);
    }
}
