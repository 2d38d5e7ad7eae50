//! Support vertex among a leaf's candidates: an f32 filter, then an f64 comparison of near ties.
//!
//! 1. Compute the dot products of all candidates in f32, and their maximum.
//! 2. Usually no other candidate is within [`MARGIN`] of the maximum. The margin exceeds the f32
//!    rounding error, so the candidate with the maximum is the support vertex.
//! 3. Otherwise, compare the candidates within the margin in f64. The coordinates are stored in
//!    f32, so the products are exact for an f32 direction, and the regret is the rounding error of
//!    two sums: 2e-16 of the largest term. The first of equal candidates wins; blocks list vertices
//!    by ascending index.
//!
//! The answer therefore does not depend on the instruction set that computes step 1, nor on whether
//! it fuses multiplications and additions.

use hullmap_format::archive::{ArchivedBlock, LANES};

use rkyv::rend::{f32_le, u32_le};

use super::candidate::{Candidate, exact_dot};
use super::direction::Direction;
use super::simd::Simd;

/// Minimum difference at which f32 orders two dot products reliably, relative to
/// |direction|₁ · (largest coordinate magnitude).
///
/// A direction coordinate is rounded once, a product once and a sum of three terms twice, by 2⁻²⁴
/// each. Five such errors are allowed for in each dot product, so ten in the difference of two. The
/// margin is sixteen.
const MARGIN: f32 = 1.0 / (1 << 20) as f32;

/// Absolute lower limit of the margin. Above it, the products that decide are normal numbers; below
/// it, they may underflow.
const MIN_MARGIN: f32 = 1e-32;

/// Absolute upper limit of the margin. Dot products are up to a million times as large, and would
/// overflow above it.
const MAX_MARGIN: f32 = MARGIN * (f32::MAX / 4.0);

/// Maximum number of runs that a long list of blocks is divided into.
const MAX_RUNS: usize = 64;

/// Minimum number of blocks in a run: the maximum over eight lanes costs as much as three blocks.
const MIN_RUN_BLOCKS: usize = 16;

/// The blocks as an array, if there are exactly `N`: `as_array` of Rust 1.93.
#[inline(always)]
pub(crate) fn exactly<const N: usize>(blocks: &[ArchivedBlock]) -> Option<&[ArchivedBlock; N]> {
    blocks.try_into().ok()
}

/// Support vertex among the candidates in `blocks`, of which there is at least one.
///
/// `reach` is the largest coordinate magnitude in any block.
#[inline(always)]
pub(crate) fn best<S: Simd>(simd: S, blocks: &[ArchivedBlock], dir: impl Direction, reach: f32) -> Candidate<'_> {
    let narrow = dir.narrow();
    let Some(margin) = margin(narrow, reach) else { return exact_best(blocks, dir.exact()) };
    // Most leaves have one to four blocks. A constant count unrolls the loops.
    if let Some(few) = exactly::<1>(blocks) {
        best_of_blocks(simd, few, dir, margin)
    } else if let Some(few) = exactly::<2>(blocks) {
        best_of_blocks(simd, few, dir, margin)
    } else if let Some(few) = exactly::<3>(blocks) {
        best_of_blocks(simd, few, dir, margin)
    } else if let Some(few) = exactly::<4>(blocks) {
        best_of_blocks(simd, few, dir, margin)
    } else {
        best_of_many(simd, blocks, dir, margin)
    }
}

/// Support vertex among the candidates of one to four blocks.
#[inline(always)]
#[expect(clippy::indexing_slicing, reason = "`lane` is taken modulo the number of lanes of all blocks")]
pub(crate) fn best_of_blocks<S: Simd, const N: usize>(
    simd: S,
    few: &[ArchivedBlock; N],
    dir: impl Direction,
    margin: f32,
) -> Candidate<'_> {
    let near = simd.near_best(few, dir.narrow(), margin);
    let is_alone = near & near.wrapping_sub(1) == 0;
    let lane = if is_alone { near.trailing_zeros() as usize } else { simd.exact_best(few, near, dir.exact()) };
    let lane = lane % (N * LANES);
    Candidate { block: &few[lane / LANES], lane: lane % LANES }
}

/// Support vertex among the candidates of many blocks.
///
/// Divides the blocks into at most [`MAX_RUNS`] runs and computes the maximum f32 dot product of
/// each. Only runs whose maximum is within the margin of the overall maximum are scanned again in
/// f64.
#[inline(always)]
#[expect(clippy::indexing_slicing, reason = "`run_len` is chosen so that there are at most `MAX_RUNS` runs")]
fn best_of_many<S: Simd>(simd: S, blocks: &[ArchivedBlock], dir: impl Direction, margin: f32) -> Candidate<'_> {
    let (narrow, exact) = (dir.narrow(), dir.exact());
    let run_len = blocks.len().div_ceil(MAX_RUNS).max(MIN_RUN_BLOCKS);
    let mut run_max = [0.0; MAX_RUNS];
    let mut threshold = f32::NEG_INFINITY;
    for (run_max, run) in run_max.iter_mut().zip(blocks.chunks(run_len)) {
        *run_max = simd.max_dot(run, narrow);
        threshold = threshold.max(*run_max);
    }
    threshold -= margin;
    let mut best = Best::NONE;
    for (run_index, run) in blocks.chunks(run_len).enumerate().filter(|(index, _)| run_max[*index] >= threshold) {
        for (block, candidates) in run.iter().enumerate() {
            let mut near = simd.not_less(candidates, narrow, threshold);
            while near != 0 {
                let lane = near.trailing_zeros() as usize % LANES;
                near &= near - 1;
                best.update(exact_dot(candidates, lane, exact), run_index * run_len + block, lane);
            }
        }
    }
    best.candidate(blocks)
}

/// Minimum difference at which f32 orders two dot products with `dir` reliably; `None` where they
/// may underflow or overflow, or where `dir` is zero or NaN.
///
/// `reach` is the largest coordinate magnitude of the points.
#[inline]
pub(crate) fn margin(dir: [f32; 3], reach: f32) -> Option<f32> {
    let margin = MARGIN * reach * (dir[0].abs() + dir[1].abs() + dir[2].abs());
    // NaN takes the failing branch.
    (margin > MIN_MARGIN && margin < MAX_MARGIN).then_some(margin)
}

/// Stands in for the block of an empty list, which no checked pack contains.
static NO_BLOCK: ArchivedBlock = ArchivedBlock {
    x: [f32_le::from_native(0.0); LANES],
    y: [f32_le::from_native(0.0); LANES],
    z: [f32_le::from_native(0.0); LANES],
    vertex: [u32_le::from_native(0); LANES],
};

struct Best {
    dot: f64,
    block: usize,
    lane: usize,
}

impl Best {
    const NONE: Self = Self { dot: f64::NEG_INFINITY, block: 0, lane: 0 };

    /// Replaces the candidate if `dot` is larger. A NaN is never larger, so the previous candidate
    /// stays.
    fn update(&mut self, dot: f64, block: usize, lane: usize) {
        if dot > self.dot {
            *self = Self { dot, block, lane };
        }
    }

    fn candidate<'a>(&self, blocks: &'a [ArchivedBlock]) -> Candidate<'a> {
        Candidate { block: blocks.get(self.block).unwrap_or(&NO_BLOCK), lane: self.lane }
    }
}

/// Support vertex among all lanes of all blocks, in f64: the slow, obvious twin.
fn exact_best(blocks: &[ArchivedBlock], dir: [f64; 3]) -> Candidate<'_> {
    let mut best = Best::NONE;
    for (index, block) in blocks.iter().enumerate() {
        for lane in 0..LANES {
            best.update(exact_dot(block, lane, dir), index, lane);
        }
    }
    best.candidate(blocks)
}

#[cfg(test)]
mod tests {
    use rkyv::rend::{f32_le, u32_le};
    use shapes::{families, rng::SplitMix64};

    use std::marker::PhantomData;

    use super::*;
    use crate::support::simd::{Dispatch, Kernel, Portable, dispatches};

    fn blocks(points: &[[f32; 3]]) -> Vec<ArchivedBlock> {
        let block = |(index, chunk): (usize, &[[f32; 3]])| {
            let lane = |lane: usize| lane.min(chunk.len() - 1);
            let component = |i: usize| std::array::from_fn(|l| f32_le::from_native(chunk[lane(l)][i]));
            let vertex = std::array::from_fn(|l| u32_le::from_native((index * LANES + lane(l)) as u32));
            ArchivedBlock { x: component(0), y: component(1), z: component(2), vertex }
        };
        points.chunks(LANES).enumerate().map(block).collect()
    }

    #[derive(Clone, Copy)]
    struct Fast<'a, T>(&'a [ArchivedBlock], f32, PhantomData<T>);

    impl<T> Kernel for Fast<'_, T>
    where
        T: Copy,
        [T; 3]: Direction,
    {
        type Scalar = T;
        type Output = (u32, [f32; 3]);
        #[inline(always)]
        fn run<S: Simd>(self, simd: S, dir: [T; 3]) -> Self::Output {
            best(simd, self.0, dir, self.1).read()
        }
    }

    fn fast<T: Copy>(dispatch: Dispatch, blocks: &[ArchivedBlock], dir: [T; 3], reach: f32) -> (u32, [f32; 3])
    where
        [T; 3]: Direction,
    {
        dispatch.run(Fast(blocks, reach, PhantomData), dir)
    }

    /// The fast path against its slow twin, over block counts, scales and offsets, with ties and
    /// near ties.
    #[test]
    fn f32_and_f64_paths_agree() {
        let mut rng = SplitMix64::new(5);
        let mut near = 0;
        for (count, scale, offset) in [
            (8, 1.0, 0.0),
            (5, 1e-3, 7.0),
            (16, 1e6, 0.0),
            (32, 1.0, 1e4),
            (24, 1.0, 0.0),
            (200, 1.0, 0.0),
            (4999, 1.0, 0.0),
            (8, 1e-40, 0.0),
        ] {
            let points: Vec<[f32; 3]> =
                families::cube_grid(count.max(8), 1)[..count].iter().map(|p| p.map(|c| c * scale + offset)).collect();
            let reach = points.iter().flatten().fold(0.0, |reach: f32, c| reach.max(c.abs()));
            let blocks = blocks(&points);
            for round in 0..3000 {
                let mut dir = rng.direction();
                if round % 3 == 0 {
                    // Grid points tie in directions along the axes, and nearly tie in directions
                    // close to them.
                    dir[round % 2] *= [0.0, 1e-7][round / 3 % 2];
                }
                let narrow = dir.map(|c| c as f32);
                for dispatch in dispatches() {
                    let instructions = dispatch.instructions();
                    assert_eq!(
                        fast(dispatch, &blocks, dir, reach),
                        exact_best(&blocks, dir).read(),
                        "{instructions:?} {dir:?}"
                    );
                    let exact = exact_best(&blocks, narrow.map(f64::from)).read();
                    assert_eq!(fast(dispatch, &blocks, narrow, reach), exact, "{instructions:?} {narrow:?}");
                }
                let first = blocks.first_chunk::<1>().unwrap();
                let lane_count = |margin| Portable.near_best(first, narrow, margin).count_ones();
                near += usize::from(margin(narrow, reach).is_some_and(|margin| lane_count(margin) > 1));
            }
        }
        assert!((1000..17_000).contains(&near), "{near} of 24,000 directions have a near tie");
    }

    #[test]
    fn overflowing_dot_products_are_compared_in_f64() {
        let blocks = blocks(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f32::MAX, 0.0, 0.0]]);
        for dir in [[1e30, 0.0, 0.0], [1e30, -1e30, 1e30]] {
            assert_eq!(best(Portable, &blocks, dir, f32::MAX).read().0, 2);
        }
        // Two products overflow with opposite signs: the sum is small for one point and large for
        // the other.
        let blocks = self::blocks(&[[2e9, 1.6e9, 0.0], [1e9, 0.0, 0.0]]);
        assert_eq!(best(Portable, &blocks, [2e29, -2e29, 0.0], 2e9).read().0, 1);
        assert_eq!(best(Portable, &blocks, [2.0, -2.0, 0.0], 2e9).read().0, 1);
        assert!(best(Portable, &blocks, [f32::NAN; 3], f32::MAX).read().0 < 3);
        assert_eq!(margin([0.0; 3], 1.0), None);
        assert_eq!(margin([f32::NAN; 3], 1.0), None);
    }
}
