//! Dot products of eight candidates at once, with the instructions that the processor has.
//!
//! A build for plain x86-64 holds every path; which one a hull takes is found out when the hull is taken from its pack, and
//! can be chosen ([`Instructions`]), for a whole process by the variable [`VARIABLE`]. All give the same answers: they only pick the candidates that f32 cannot tell apart
//! from the best, by a margin wider than they can differ ([`crate::candidates`]).
//!
//! To add a set of instructions, implement [`Simd`] for a type that only its detection can make (as `avx2` does), and add
//! it to [`Instructions`] and [`Level`]. On AArch64, `portable` already is NEON: glam's `Vec4` uses it.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod portable;

use std::sync::{
    Once,
    atomic::{AtomicBool, Ordering},
};

use hullmap_format::archive::{ArchivedBlock, LANES};
use rkyv::rend::i16_le;

pub(crate) use portable::Portable;

/// The environment variable that chooses the instructions of a process: `portable` or `avx2`.
const VARIABLE: &str = "HULLMAP_INSTRUCTIONS";

/// Whether the variable asks for plain instructions.
static PORTABLE: AtomicBool = AtomicBool::new(false);

/// Reads the variable, the first time that it is called: when a pack is opened, so that no query ever does.
pub(crate) fn read_variable() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let portable = std::env::var_os(VARIABLE).is_some_and(|value| value == "portable");
        PORTABLE.store(portable, Ordering::Relaxed);
    });
}

/// A set of vector instructions.
///
/// Every hull uses the best that the processor has, unless [`Hull::with_instructions`](crate::Hull::with_instructions) chooses, or the
/// environment variable `HULLMAP_INSTRUCTIONS`, for the whole process: `portable`, or `avx2`, the default where there is any. It is
/// read once, when the first pack is opened. Other values, and what the processor has not, are ignored: a word in the environment must
/// not keep a game from starting. [`Hull::instructions`](crate::Hull::instructions) tells what came of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Instructions {
    /// What every processor of the target has: SSE2 on x86-64, NEON on AArch64, plain numbers elsewhere.
    Portable,
    /// AVX2 with fused multiply-add, on x86-64.
    Avx2,
}

/// A way to multiply eight candidates with a direction.
pub(crate) trait Simd: Copy {
    /// Dot products of the lanes of `N` blocks, and which of them are not less than the greatest by more than `margin`:
    /// one bit a lane, those of the first block lowest. NaN is not less. `N` is 4 at most.
    fn near_best<const N: usize>(self, blocks: &[ArchivedBlock; N], dir: [f32; 3], margin: f32) -> u32;

    /// The lane, of those in the mask `near`, with the greatest dot product in f64, each product and sum rounded once, in
    /// the order x, y, z. The lowest of those that are equal; for NaN any.
    fn exact_best<const N: usize>(self, blocks: &[ArchivedBlock; N], near: u32, dir: [f64; 3]) -> usize;

    /// Which lanes' dot products are not less than `least`, one bit a lane. NaN is not less.
    fn not_less(self, block: &ArchivedBlock, dir: [f32; 3], least: f32) -> u32;

    /// Which of eight edges' dot products are less than `least`, one bit an edge. NaN is not.
    fn edges_below(self, edges: [&[i16_le; LANES]; 3], dir: [f32; 3], least: f32) -> u32;

    /// The greatest dot product of any lane; NaN may be passed over. There is at least one block.
    fn greatest(self, blocks: &[ArchivedBlock], dir: [f32; 3]) -> f32;
}

/// What is done with one set of instructions or another, in some direction.
pub(crate) trait Work: Copy {
    type Scalar;
    type Answer;
    /// Compiled once for each set; must be `#[inline(always)]`, and so must be what it calls in an inner loop.
    fn with<S: Simd>(self, simd: S, dir: [Self::Scalar; 3]) -> Self::Answer;
}

/// The instructions that a hull uses.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Level {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Avx2),
}

impl Level {
    /// The best that this processor has, or what the environment asks for.
    pub(crate) fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        if !PORTABLE.load(Ordering::Relaxed)
            && let Some(avx2) = avx2::Avx2::detect()
        {
            return Self::Avx2(avx2);
        }
        Self::Portable
    }

    /// The asked ones, if this processor has them.
    pub(crate) fn of(instructions: Instructions) -> Option<Self> {
        match instructions {
            Instructions::Portable => Some(Self::Portable),
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx2 => avx2::Avx2::detect().map(Self::Avx2),
            #[cfg(not(target_arch = "x86_64"))]
            Instructions::Avx2 => None,
        }
    }

    /// Where the least of `values` is, which come in whole chunks: the first place of several. 0 when there are none, or NaN
    /// alone.
    #[inline(always)]
    pub(crate) fn least(self, values: &[[f64; LANES]]) -> usize {
        match self {
            Self::Portable => portable::least(values),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(avx2) => avx2.least(values),
        }
    }

    pub(crate) fn instructions(self) -> Instructions {
        match self {
            Self::Portable => Instructions::Portable,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => Instructions::Avx2,
        }
    }

    /// Does `work` with these instructions.
    #[inline(always)]
    pub(crate) fn run<W: Work>(self, work: W, dir: [W::Scalar; 3]) -> W::Answer {
        let [x, y, z] = dir;
        match self {
            Self::Portable => portable(work, x, y, z),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(avx2) => avx2.run(work, [x, y, z]),
        }
    }
}

/// Apart, so that the path for other instructions can be inlined where it is asked for.
#[inline(never)]
fn portable<W: Work>(work: W, x: W::Scalar, y: W::Scalar, z: W::Scalar) -> W::Answer {
    work.with(Portable, [x, y, z])
}

#[cfg(test)]
mod tests {
    use super::*;
    use shapes::rng::SplitMix64;

    #[test]
    fn least_is_the_first_of_the_least() {
        let mut rng = SplitMix64::new(3);
        for chunks in [1, 2, 7, 8, 9, 40] {
            for round in 0..200 {
                let mut values = vec![[f64::INFINITY; LANES]; chunks];
                for value in values.as_flattened_mut() {
                    // Few values, so that there are ties; infinity for slots that are empty.
                    *value = (rng.between(0.0, 20.0) as i32 - 4 + round % 3).into();
                    *value = if *value > 10.0 { f64::INFINITY } else { *value };
                }
                let flat = values.as_flattened();
                let expected = (0..flat.len()).fold(0, |best, at| if flat[at] < flat[best] { at } else { best });
                for level in [Instructions::Portable, Instructions::Avx2].into_iter().filter_map(Level::of) {
                    assert_eq!(level.least(&values), expected, "{:?} {values:?}", level.instructions());
                }
            }
        }
        assert_eq!(Level::best().least(&[]), 0);
        assert_eq!(Level::best().least(&[[f64::NAN; LANES]]), 0);
    }
}
