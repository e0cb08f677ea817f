//! The only place with unsafe code: vectors of eight and sixteen f32 and the traversal that is compiled for each
//! instruction set.
//!
//! [`Lanes`] is what an instruction set must offer; `portable` does it with arrays (and is the scalar twin that all
//! others are tested against), `x86` with intrinsics. The kernels are generic over it and inline completely into one
//! entry point an instruction set, which carries the `target_feature`. A helper that stayed out of line would lose the
//! feature and run five times slower (kernels.md, lesson 14): everything on the way is `#[inline(always)]`.

mod beam;
mod bins;
mod buffer;
mod packet;
mod portable;
mod prefetch;
mod rays;
mod set;
mod slab;
mod task;
mod traverse;
mod wide;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use beam::Beam;
pub use bins::add;
pub use buffer::filled;
pub use packet::{PACKET, PacketVisitor};
pub use portable::Portable;
pub use prefetch::prefetch;
#[cfg(test)]
pub use rays::Take;
pub use rays::{Doubles, Ends, ExactRays, RayRows, Rays, Room, Slabs, Together, largest};
pub use set::{RaySet, each_bit};
pub use slab::SlabLanes;
pub use task::Task;
pub use traverse::{Counted, LeafVisitor};
pub use wide::{Row, Wide, of_group, ones};

use crate::math::Four;
use std::fmt;
use std::str::FromStr;

/// Instruction sets that the kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Isa {
    /// Any processor; on x86-64 SSE2.
    Portable,
    /// x86-64 with AVX2, FMA, BMI 1 and 2, LZCNT and POPCNT.
    Avx2,
    /// The same with AVX-512 F, VL, DQ and BW.
    Avx512,
}

impl Isa {
    /// All of them, the plainest first.
    pub const ALL: [Isa; 3] = [Isa::Portable, Isa::Avx2, Isa::Avx512];

    /// The one that traces fastest on this processor. Packets and loops over rays are written for sixteen lanes; single
    /// rays take the code of AVX2 also where there is AVX-512 (see [`Bvh::traverse`](crate::bvh::Bvh::traverse)).
    pub fn best() -> Self {
        Isa::ALL.into_iter().rev().find(|isa| isa.is_available()).unwrap_or(Isa::Portable)
    }

    /// Whether this processor has it.
    pub fn is_available(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        match self {
            Isa::Portable => true,
            Isa::Avx2 => {
                is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("fma")
                    && is_x86_feature_detected!("bmi1")
                    && is_x86_feature_detected!("bmi2")
                    && is_x86_feature_detected!("lzcnt")
                    && is_x86_feature_detected!("popcnt")
            }
            Isa::Avx512 => {
                Isa::Avx2.is_available()
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512bw")
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            self == Isa::Portable
        }
    }

    /// `portable`, `avx2` or `avx512`.
    pub fn name(self) -> &'static str {
        match self {
            Isa::Portable => "portable",
            Isa::Avx2 => "avx2",
            Isa::Avx512 => "avx512",
        }
    }
}

/// Names are those of [`Isa::name`], and `sse2` for what `portable` is on x86-64. Only what this processor has is
/// accepted.
impl FromStr for Isa {
    type Err = IsaError;

    fn from_str(name: &str) -> Result<Self, IsaError> {
        let wanted = if cfg!(target_arch = "x86_64") && name == "sse2" { "portable" } else { name };
        match Isa::ALL.into_iter().find(|isa| isa.name() == wanted) {
            Some(isa) if isa.is_available() => Ok(isa),
            Some(isa) => Err(IsaError::Unavailable(isa)),
            None => Err(IsaError::Unknown),
        }
    }
}

/// Why a name stands for no instruction set that can be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IsaError {
    /// There is no such name.
    Unknown,
    /// This processor does not have it.
    Unavailable(Isa),
}

impl fmt::Display for IsaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown => f.write_str("there is no such instruction set")?,
            Self::Unavailable(isa) => write!(f, "this processor has no {}", isa.name())?,
        }
        let here: Vec<_> = Isa::ALL.into_iter().filter(|isa| isa.is_available()).map(Isa::name).collect();
        write!(f, "; here there is {}", here.join(", "))
    }
}

impl std::error::Error for IsaError {}

/// Eight f32 lanes. A value of the implementing type is the proof that the processor has the instructions. Comparisons
/// are false for NaN.
pub trait Lanes: Copy {
    /// Eight f32.
    type V: Copy;
    /// Eight yes or no.
    type M: Copy;
    /// Four f64.
    type F: Four;

    /// The same value in every lane.
    fn splat(self, v: f32) -> Self::V;
    /// Four f64.
    fn four(self, v: [f64; 4]) -> Self::F;
    /// The same of f32.
    fn widened(self, v: [f32; 4]) -> Self::F;
    /// The first three values, each in every lane. Takes four, since the compiler computes four at a time.
    fn splat3(self, v: [f32; 4]) -> [Self::V; 3];
    /// Eight values in memory.
    fn load(self, v: &[f32; 8]) -> Self::V;
    /// To memory.
    fn store(self, v: Self::V) -> [f32; 8];
    /// a + b
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    /// a - b
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    /// a b
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    /// a / b
    fn div(self, a: Self::V, b: Self::V) -> Self::V;
    /// a b + c, rounded once or twice
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// a b - c, rounded once or twice
    fn mul_sub(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// c - a b, rounded once or twice
    fn neg_mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// The smaller; `b` if either is NaN
    fn min(self, a: Self::V, b: Self::V) -> Self::V;
    /// The larger; `b` if either is NaN
    fn max(self, a: Self::V, b: Self::V) -> Self::V;
    /// The larger of two numbers without sign, or NaN if either is
    fn max_unsigned(self, a: Self::V, b: Self::V) -> Self::V;
    /// |a|
    fn abs(self, a: Self::V) -> Self::V;
    /// a, with its sign changed where b has a minus sign
    fn mul_sign(self, a: Self::V, b: Self::V) -> Self::V;
    /// Lanes where a <= b
    fn le(self, a: Self::V, b: Self::V) -> Self::M;
    /// Lanes where both are
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    /// Lanes where either is
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    /// A bit a lane, lane 0 lowest
    fn bits(self, m: Self::M) -> u32;
}
