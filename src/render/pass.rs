//! The order in which samples are traced.

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
}

/// Most samples a pixel that one refining pass adds: a tile comes back often enough to be watched.
const LARGEST_STEP: u32 = 16;

impl Pass {
    /// All passes of a render in order: the lattices from coarse to fine, which are sample 0, then refinements that
    /// double the samples until they add [`LARGEST_STEP`] each.
    pub fn sequence(samples: u32) -> Vec<Pass> {
        let mut passes: Vec<Pass> = [8, 4, 2, 1].map(|step| Pass::Lattice { step }).into();
        let mut from = 1;
        while from < samples {
            let to = (from + from.min(LARGEST_STEP)).min(samples);
            passes.push(Pass::Refine { from, to });
            from = to;
        }
        passes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_is_in_one_pass_and_in_order() {
        for samples in [1, 2, 3, 7, 16, 17, 100] {
            let passes = Pass::sequence(samples);
            let steps: Vec<_> = passes
                .iter()
                .map_while(|p| match p {
                    Pass::Lattice { step } => Some(*step),
                    Pass::Refine { .. } => None,
                })
                .collect();
            assert_eq!(steps, [8, 4, 2, 1]);
            let end = passes[4..].iter().fold(1, |next, pass| match pass {
                Pass::Refine { from, to } if *from == next && to > from => *to,
                other => panic!("{other:?} after sample {next}"),
            });
            assert_eq!(end, samples);
        }
    }
}
