//! Plain Rust that the compiler makes vector code of, once for each instruction set.

use super::Isa;
use crate::bvh::Bvh;

/// A loop over numbers in arrays. Everything that it calls must be `#[inline(always)]`, or it loses the instruction
/// set.
///
/// What it reads and what it writes are arguments of their own and what it is told is in `self`, not references in a
/// structure: only of arguments does the compiler know that they do not overlap. Without that knowledge it left all
/// loops with a square root or more than a few arrays scalar.
pub trait Task {
    /// What is read.
    type Input: ?Sized;
    /// What is written.
    type Output;

    /// Does it.
    fn run(self, input: &Self::Input, output: &mut Self::Output);
}

impl Bvh {
    /// Does a task with the instruction set that this tree is traversed with.
    #[inline]
    pub fn run<T: Task>(&self, task: T, input: &T::Input, output: &mut T::Output) {
        match self.isa {
            Isa::Portable => task.run(input, output),
            // SAFETY: a tree gets its instruction set from `Isa::best` or after `Isa::is_available` (`Bvh::build`
            // checks).
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => unsafe { run_avx2(task, input, output) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => unsafe { run_avx512(task, input, output) },
            #[cfg(not(target_arch = "x86_64"))]
            _ => task.run(input, output),
        }
    }
}

/// # Safety
/// The processor has what [`Isa::Avx2`] names.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn run_avx2<T: Task>(task: T, input: &T::Input, output: &mut T::Output) {
    task.run(input, output);
}

/// # Safety
/// The processor has what [`Isa::Avx512`] names.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq,avx512bw")]
unsafe fn run_avx512<T: Task>(task: T, input: &T::Input, output: &mut T::Output) {
    task.run(input, output);
}
