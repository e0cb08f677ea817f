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
