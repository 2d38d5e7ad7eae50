//! The best of a leaf's candidates: first in f32, then, among those that f32 cannot tell apart, in f64.
//!
//! 1. Dot products of all candidates in f32, and the greatest of them.
//! 2. Usually no other is within [`MARGIN`] of it, which is more than f32 can be wrong by: it is the support vertex.
//! 3. Else those within the margin are compared in f64 over the stored f32 coordinates, where products are exact and the
//!    regret is that of two sums: 2e-16 of the largest term. The lowest vertex number wins among equals.
//!
//! So the answer is the same whichever instructions take step 1, with or without fused multiplications.

use hullmap_format::archive::{ArchivedBlock, LANES};

use crate::direction::Direction;

/// How far apart two f32 dot products must be to be told apart, as a share of |direction|₁ · greatest coordinate.
///
/// A coordinate of the direction is rounded once (2⁻²⁴), a product once, and a sum of three twice: five roundings at most
/// in each of two dot products, ten times 2⁻²⁴, where this is sixteen times.
const MARGIN: f32 = 1.0 / (1 << 20) as f32;

/// Margins below this are lost to underflow; above it, the products that matter are normal numbers.
const LEAST_MARGIN: f32 = 1e-32;

/// Margins above this belong to dot products, a million times as large, that may overflow.
const GREATEST_MARGIN: f32 = MARGIN * (f32::MAX / 2.0);

/// Vertex number and position of the best candidate in `blocks`, which are at least one.
///
/// `reach` is the greatest magnitude of a coordinate in any block.
#[inline]
pub(crate) fn best(blocks: &[ArchivedBlock], dir: impl Direction, reach: f32) -> (u32, [f32; 3]) {
    let narrow = dir.narrow();
    let Some(margin) = margin(narrow, reach) else { return exact_best(blocks, dir.exact()) };
    if let [block] = blocks {
        let near = lanes::near_best(block, narrow, margin);
        let lane = near.trailing_zeros() as usize % LANES;
        if near & near.wrapping_sub(1) == 0 {
            return at(block, lane);
        }
        return best_of(block, near, dir.exact());
    }
    match lanes::alone_best(blocks, narrow, margin) {
        Some((block, lane)) => at(&blocks[block], lane),
        None => exact_best(blocks, dir.exact()),
    }
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

/// The best of the lanes in the mask `near`, in f64.
#[cold]
fn best_of(block: &ArchivedBlock, mut near: u32, dir: [f64; 3]) -> (u32, [f32; 3]) {
    let mut best = (f64::NEG_INFINITY, 0);
    while near != 0 {
        let lane = near.trailing_zeros() as usize % LANES;
        near &= near - 1;
        let dot = exact_dot(block, lane, dir);
        if dot > best.0 {
            best = (dot, lane);
        }
    }
    at(block, best.1)
}

/// The best of all lanes of all blocks, in f64: the slow, obvious twin.
fn exact_best(blocks: &[ArchivedBlock], dir: [f64; 3]) -> (u32, [f32; 3]) {
    let mut best = (f64::NEG_INFINITY, 0, 0);
    for (number, block) in blocks.iter().enumerate() {
        for lane in 0..LANES {
            let dot = exact_dot(block, lane, dir);
            // False for NaN: then the first lane stays.
            if dot > best.0 {
                best = (dot, number, lane);
            }
        }
    }
    blocks.get(best.1).map_or((0, [0.0; 3]), |block| at(block, best.2))
}

#[inline]
fn exact_dot(block: &ArchivedBlock, lane: usize, dir: [f64; 3]) -> f64 {
    let (_, point) = at(block, lane);
    f64::from(point[0]) * dir[0] + f64::from(point[1]) * dir[1] + f64::from(point[2]) * dir[2]
}

#[inline]
fn at(block: &ArchivedBlock, lane: usize) -> (u32, [f32; 3]) {
    let point = [block.x[lane].to_native(), block.y[lane].to_native(), block.z[lane].to_native()];
    (block.vertex[lane].to_native(), point)
}

/// Step 1, four lanes at a time: glam's `Vec4` is SSE2 on x86-64, NEON on AArch64, and plain numbers elsewhere.
mod lanes {
    use glam::Vec4;
    use rkyv::rend::f32_le;

    use super::*;

    #[inline]
    fn four(from: &[f32_le; LANES], half: usize) -> Vec4 {
        Vec4::from_array([0, 1, 2, 3].map(|lane| from[4 * half + lane].to_native()))
    }

    #[inline]
    fn dots(block: &ArchivedBlock, half: usize, dir: [Vec4; 3]) -> Vec4 {
        four(&block.x, half) * dir[0] + four(&block.y, half) * dir[1] + four(&block.z, half) * dir[2]
    }

    /// Lanes that are not less than `least`, as a mask: NaN is not, and then is decided in f64.
    #[inline]
    fn not_less(low: Vec4, high: Vec4, least: f32) -> u32 {
        let least = Vec4::splat(least);
        !(low.cmplt(least).bitmask() | high.cmplt(least).bitmask() << 4) & 0xff
    }

    /// Lanes whose dot product is not below the greatest by more than `margin`, as a mask.
    #[inline]
    pub(super) fn near_best(block: &ArchivedBlock, dir: [f32; 3], margin: f32) -> u32 {
        let dir = dir.map(Vec4::splat);
        let (low, high) = (dots(block, 0, dir), dots(block, 1, dir));
        not_less(low, high, low.max(high).max_element() - margin)
    }

    /// Block and lane of the greatest dot product, if no other comes within `margin` of it.
    #[inline]
    pub(super) fn alone_best(blocks: &[ArchivedBlock], dir: [f32; 3], margin: f32) -> Option<(usize, usize)> {
        let dir = dir.map(Vec4::splat);
        let (mut best, mut second) = ([Vec4::NEG_INFINITY; 2], [Vec4::NEG_INFINITY; 2]);
        // Numbers of blocks, kept as f32 for the select: exact as far as any list of candidates is long.
        let mut from = [Vec4::ZERO; 2];
        for (number, block) in blocks.iter().enumerate() {
            for half in 0..2 {
                let dot = dots(block, half, dir);
                from[half] = Vec4::select(dot.cmpgt(best[half]), Vec4::splat(number as f32), from[half]);
                second[half] = second[half].max(dot.min(best[half]));
                best[half] = best[half].max(dot);
            }
        }
        let least = best[0].max(best[1]).max_element() - margin;
        let near = not_less(best[0], best[1], least);
        let lane = near.trailing_zeros() as usize % LANES;
        let alone = near.is_power_of_two()
            && second[0].max(second[1]).max_element() < least
            && blocks.len() < 1 << f32::MANTISSA_DIGITS;
        alone.then(|| (from[lane / 4].to_array()[lane % 4] as usize, lane))
    }
}

#[cfg(test)]
mod tests {
    use rkyv::rend::{f32_le, u32_le};
    use shapes::{families, rng::SplitMix64};

    use super::*;

    fn blocks(points: &[[f32; 3]]) -> Vec<ArchivedBlock> {
        let block = |(number, chunk): (usize, &[[f32; 3]])| {
            let lane = |lane: usize| lane.min(chunk.len() - 1);
            let component = |i: usize| std::array::from_fn(|l| f32_le::from_native(chunk[lane(l)][i]));
            let vertex = std::array::from_fn(|l| u32_le::from_native((number * LANES + lane(l)) as u32));
            ArchivedBlock { x: component(0), y: component(1), z: component(2), vertex }
        };
        points.chunks(LANES).enumerate().map(block).collect()
    }

    /// The fast path against its slow twin, over block counts, scales and offsets, with ties and near ties.
    #[test]
    fn what_f32_says_is_what_f64_says() {
        let mut rng = SplitMix64::new(5);
        let mut near = 0;
        for (count, scale, offset) in
            [(8, 1.0, 0.0), (5, 1e-3, 7.0), (16, 1e6, 0.0), (32, 1.0, 1e4), (200, 1.0, 0.0), (8, 1e-40, 0.0)]
        {
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
                assert_eq!(best(&blocks, dir, reach), exact_best(&blocks, dir), "{dir:?}");
                assert_eq!(best(&blocks, narrow, reach), exact_best(&blocks, narrow.map(f64::from)), "{narrow:?}");
                let lane_count = |margin| lanes::near_best(&blocks[0], narrow, margin).count_ones();
                near += usize::from(margin(narrow, reach).is_some_and(|margin| lane_count(margin) > 1));
            }
        }
        assert!((1000..17_000).contains(&near), "{near} of 18,000 are near ties");
    }

    #[test]
    fn directions_that_overflow_are_decided_all_the_same() {
        let blocks = blocks(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f32::MAX, 0.0, 0.0]]);
        for dir in [[1e30, 0.0, 0.0], [1e30, -1e30, 1e30]] {
            assert_eq!(best(&blocks, dir, f32::MAX).0, 2);
        }
        // Two products that overflow with opposite signs, where one point's sum is small and the other's is not.
        let blocks = self::blocks(&[[2e9, 1.6e9, 0.0], [1e9, 0.0, 0.0]]);
        assert_eq!(best(&blocks, [2e29, -2e29, 0.0], 2e9).0, 1);
        assert_eq!(best(&blocks, [2.0, -2.0, 0.0], 2e9).0, 1);
        assert!(best(&blocks, [f32::NAN; 3], f32::MAX).0 < 3);
        assert_eq!(margin([0.0; 3], 1.0), None);
        assert_eq!(margin([f32::NAN; 3], 1.0), None);
    }
}
