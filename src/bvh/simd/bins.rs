//! The inner loop of building: boxes into bins, one vector a box.

#[cfg(target_arch = "x86_64")]
use super::x86::Avx2;
use super::{Isa, Lanes, Portable};
use crate::bvh::bins::{Bins, Grid, PrimRef};

/// Puts primitives into bins, beside what is in them.
#[inline]
pub fn add(bins: &mut Bins, refs: &[PrimRef], grid: &Grid, isa: Isa) {
    match isa {
        Isa::Portable => fill(Portable, bins, refs, grid),
        // SAFETY: `Bvh::build` has checked that the processor has it.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 | Isa::Avx512 => unsafe { fill_avx2(bins, refs, grid) },
        #[cfg(not(target_arch = "x86_64"))]
        _ => fill(Portable, bins, refs, grid),
    }
}

/// # Safety
/// The processor has what [`Isa::Avx2`] names.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn fill_avx2(bins: &mut Bins, refs: &[PrimRef], grid: &Grid) {
    // SAFETY: this function's own condition.
    fill(unsafe { Avx2::new() }, bins, refs, grid);
}

#[inline(always)]
fn fill<L: Lanes>(lanes: L, bins: &mut Bins, refs: &[PrimRef], grid: &Grid) {
    for p in refs {
        let v = lanes.load(&p.0);
        for axis in 0..3 {
            let k = grid.bin(p, axis);
            let place = &mut bins.boxes[axis][k];
            *place = lanes.store(lanes.min(v, lanes.load(place)));
            bins.counts[axis][k] += 1;
        }
    }
}
