//! The best of a leaf's candidates: first in f32, then, among those that f32 cannot tell apart, in f64.
//!
//! 1. Dot products of all candidates in f32, and the greatest of them.
//! 2. Usually no other is within [`MARGIN`] of it, which is more than f32 can be wrong by: it is the support vertex.
//! 3. Else those within the margin are compared in f64 over the stored f32 coordinates, where products are exact and the
//!    regret is that of two sums: 2e-16 of the largest term. The lowest vertex number wins among equals.
//!
//! So the answer is the same whichever instructions take step 1, with or without fused multiplications.

use hullmap_format::archive::{ArchivedBlock, LANES};

use rkyv::rend::{f32_le, u32_le};

use crate::{direction::Direction, simd::Simd};

/// How far apart two f32 dot products must be to be told apart, as a share of |direction|₁ · greatest coordinate.
///
/// A coordinate of the direction is rounded once (2⁻²⁴), a product once, and a sum of three twice: five roundings at most
/// in each of two dot products, ten times 2⁻²⁴, where this is sixteen times.
const MARGIN: f32 = 1.0 / (1 << 20) as f32;

/// Margins below this are lost to underflow; above it, the products that matter are normal numbers.
const LEAST_MARGIN: f32 = 1e-32;

/// Margins above this belong to dot products, a million times as large, that may overflow.
const GREATEST_MARGIN: f32 = MARGIN * (f32::MAX / 4.0);

/// A candidate in its place: of a block, one lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate<'a> {
    block: &'a ArchivedBlock,
    lane: usize,
}

impl Candidate<'_> {
    /// Its vertex number and position.
    #[inline(always)]
    #[expect(clippy::indexing_slicing, reason = "`lane` is taken modulo the number of lanes")]
    pub(crate) fn read(self) -> (u32, [f32; 3]) {
        let Self { block, lane } = self;
        // Below LANES as it is: for the compiler.
        let lane = lane % LANES;
        let point = [block.x[lane].to_native(), block.y[lane].to_native(), block.z[lane].to_native()];
        (block.vertex[lane].to_native(), point)
    }
}

/// Blocks of a list that are looked at together for its greatest dot product.
const CHUNKS: usize = 64;

/// Least blocks of such a run: finding the greatest of eight lanes costs as much as three blocks.
const LEAST_CHUNK: usize = 16;

/// Vertex number and position of the best candidate in `blocks`, which are at least one.
///
/// `reach` is the greatest magnitude of a coordinate in any block.
#[inline(always)]
pub(crate) fn best<S: Simd>(simd: S, blocks: &[ArchivedBlock], dir: impl Direction, reach: f32) -> Candidate<'_> {
    let narrow = dir.narrow();
    let Some(margin) = margin(narrow, reach) else { return exact_best(blocks, dir.exact()) };
    // The usual leaf first.
    if let Some(few) = blocks.as_array::<1>() {
        best_of_few(simd, few, dir, margin)
    } else if let Some(few) = blocks.as_array::<2>() {
        best_of_few(simd, few, dir, margin)
    } else if let Some(few) = blocks.as_array::<3>() {
        best_of_few(simd, few, dir, margin)
    } else if let Some(few) = blocks.as_array::<4>() {
        best_of_few(simd, few, dir, margin)
    } else {
        best_of_many(simd, blocks, dir, margin)
    }
}

/// The best of up to four blocks.
#[inline(always)]
#[expect(clippy::indexing_slicing, reason = "`lane` is taken modulo the number of lanes of all blocks")]
pub(crate) fn best_of_few<S: Simd, const N: usize>(
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

/// The best of many blocks: the greatest f32 dot product of each of up to [`CHUNKS`] runs of them, then, in the runs that
/// reach the greatest of all, each candidate within the margin in f64.
#[inline(always)]
#[expect(clippy::indexing_slicing, reason = "runs are as long as makes at most `CHUNKS` of them")]
fn best_of_many<S: Simd>(simd: S, blocks: &[ArchivedBlock], dir: impl Direction, margin: f32) -> Candidate<'_> {
    let (narrow, exact) = (dir.narrow(), dir.exact());
    let run_len = blocks.len().div_ceil(CHUNKS).max(LEAST_CHUNK);
    let mut greatest = [0.0; CHUNKS];
    let mut least = f32::NEG_INFINITY;
    for (greatest, run) in greatest.iter_mut().zip(blocks.chunks(run_len)) {
        *greatest = simd.greatest(run, narrow);
        least = least.max(*greatest);
    }
    least -= margin;
    let mut best = Best::NONE;
    for (place, run) in blocks.chunks(run_len).enumerate().filter(|(place, _)| greatest[*place] >= least) {
        for (block, candidates) in run.iter().enumerate() {
            let mut near = simd.not_less(candidates, narrow, least);
            while near != 0 {
                let lane = near.trailing_zeros() as usize % LANES;
                near &= near - 1;
                best.take(exact_dot(candidates, lane, exact), place * run_len + block, lane);
            }
        }
    }
    best.of(blocks)
}

/// By how much two f32 dot products with `dir` must differ to be told apart; `None` where f32 cannot tell at all.
///
/// `reach` is the greatest magnitude of a coordinate of the points.
#[inline]
pub(crate) fn margin(dir: [f32; 3], reach: f32) -> Option<f32> {
    let margin = MARGIN * reach * (dir[0].abs() + dir[1].abs() + dir[2].abs());
    // NaN margins fail as well.
    (margin > LEAST_MARGIN && margin < GREATEST_MARGIN).then_some(margin)
}

/// What a list without blocks, which no checked pack has, would hold.
static NO_BLOCK: ArchivedBlock = ArchivedBlock {
    x: [f32_le::from_native(0.0); LANES],
    y: [f32_le::from_native(0.0); LANES],
    z: [f32_le::from_native(0.0); LANES],
    vertex: [u32_le::from_native(0); LANES],
};

/// The best so far, and where it is.
struct Best {
    dot: f64,
    block: usize,
    lane: usize,
}

impl Best {
    const NONE: Self = Self { dot: f64::NEG_INFINITY, block: 0, lane: 0 };

    /// Takes a candidate if it is better. False for NaN: then the one before stays.
    fn take(&mut self, dot: f64, block: usize, lane: usize) {
        if dot > self.dot {
            *self = Self { dot, block, lane };
        }
    }

    fn of<'a>(&self, blocks: &'a [ArchivedBlock]) -> Candidate<'a> {
        Candidate { block: blocks.get(self.block).unwrap_or(&NO_BLOCK), lane: self.lane }
    }
}

/// The best of all lanes of all blocks, in f64: the slow, obvious twin.
fn exact_best(blocks: &[ArchivedBlock], dir: [f64; 3]) -> Candidate<'_> {
    let mut best = Best::NONE;
    for (number, block) in blocks.iter().enumerate() {
        for lane in 0..LANES {
            best.take(exact_dot(block, lane, dir), number, lane);
        }
    }
    best.of(blocks)
}

/// The dot product of a lane in f64, where the products are exact or nearly so.
#[inline]
pub(crate) fn exact_dot(block: &ArchivedBlock, lane: usize, dir: [f64; 3]) -> f64 {
    let (_, point) = Candidate { block, lane }.read();
    f64::from(point[0]) * dir[0] + f64::from(point[1]) * dir[1] + f64::from(point[2]) * dir[2]
}

#[cfg(test)]
mod tests {
    use rkyv::rend::{f32_le, u32_le};
    use shapes::{families, rng::SplitMix64};

    use std::marker::PhantomData;

    use super::*;
    use crate::simd::{Instructions, Level, Portable, Work};

    fn blocks(points: &[[f32; 3]]) -> Vec<ArchivedBlock> {
        let block = |(number, chunk): (usize, &[[f32; 3]])| {
            let lane = |lane: usize| lane.min(chunk.len() - 1);
            let component = |i: usize| std::array::from_fn(|l| f32_le::from_native(chunk[lane(l)][i]));
            let vertex = std::array::from_fn(|l| u32_le::from_native((number * LANES + lane(l)) as u32));
            ArchivedBlock { x: component(0), y: component(1), z: component(2), vertex }
        };
        points.chunks(LANES).enumerate().map(block).collect()
    }

    /// All that this processor has.
    fn levels() -> impl Iterator<Item = Level> {
        [Instructions::Portable, Instructions::Avx2].into_iter().filter_map(Level::of)
    }

    #[derive(Clone, Copy)]
    struct Fast<'a, T>(&'a [ArchivedBlock], f32, PhantomData<T>);

    impl<T> Work for Fast<'_, T>
    where
        T: Copy,
        [T; 3]: Direction,
    {
        type Scalar = T;
        type Answer = (u32, [f32; 3]);
        #[inline(always)]
        fn with<S: Simd>(self, simd: S, dir: [T; 3]) -> Self::Answer {
            best(simd, self.0, dir, self.1).read()
        }
    }

    fn fast<T: Copy>(level: Level, blocks: &[ArchivedBlock], dir: [T; 3], reach: f32) -> (u32, [f32; 3])
    where
        [T; 3]: Direction,
    {
        level.run(Fast(blocks, reach, PhantomData), dir)
    }

    /// The fast path against its slow twin, over block counts, scales and offsets, with ties and near ties.
    #[test]
    fn what_f32_says_is_what_f64_says() {
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
                    // Grid points tie in directions along the axes, and nearly tie beside them.
                    dir[round % 2] *= [0.0, 1e-7][round / 3 % 2];
                }
                let narrow = dir.map(|c| c as f32);
                for level in levels() {
                    let instructions = level.instructions();
                    assert_eq!(
                        fast(level, &blocks, dir, reach),
                        exact_best(&blocks, dir).read(),
                        "{instructions:?} {dir:?}"
                    );
                    let exact = exact_best(&blocks, narrow.map(f64::from)).read();
                    assert_eq!(fast(level, &blocks, narrow, reach), exact, "{instructions:?} {narrow:?}");
                }
                let first = blocks.first_chunk::<1>().unwrap();
                let lane_count = |margin| Portable.near_best(first, narrow, margin).count_ones();
                near += usize::from(margin(narrow, reach).is_some_and(|margin| lane_count(margin) > 1));
            }
        }
        assert!((1000..17_000).contains(&near), "{near} of 24,000 are near ties");
    }

    #[test]
    fn directions_that_overflow_are_decided_all_the_same() {
        let blocks = blocks(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f32::MAX, 0.0, 0.0]]);
        for dir in [[1e30, 0.0, 0.0], [1e30, -1e30, 1e30]] {
            assert_eq!(best(Portable, &blocks, dir, f32::MAX).read().0, 2);
        }
        // Two products that overflow with opposite signs, where one point's sum is small and the other's is not.
        let blocks = self::blocks(&[[2e9, 1.6e9, 0.0], [1e9, 0.0, 0.0]]);
        assert_eq!(best(Portable, &blocks, [2e29, -2e29, 0.0], 2e9).read().0, 1);
        assert_eq!(best(Portable, &blocks, [2.0, -2.0, 0.0], 2e9).read().0, 1);
        assert!(best(Portable, &blocks, [f32::NAN; 3], f32::MAX).read().0 < 3);
        assert_eq!(margin([0.0; 3], 1.0), None);
        assert_eq!(margin([f32::NAN; 3], 1.0), None);
    }
}
