//! Portable SIMD, four lanes at a time: glam's `Vec4` is SSE2 on x86-64, NEON on AArch64, scalar
//! elsewhere.

use glam::Vec4;
use hullmap_format::archive::{ArchivedBlock, LANES};
use rkyv::rend::{f32_le, i16_le};

use super::operations::Simd;
use crate::facets::lane_set::LaneSet;
use crate::facets::table::{NormalBlock, PointBlock};
use crate::support::candidate::exact_dot;

/// The instruction set that every processor has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

#[inline(always)]
#[expect(clippy::indexing_slicing, reason = "reads lanes 0..4 or 4..8 of eight")]
fn four(from: &[f32_le; LANES], half: usize) -> Vec4 {
    Vec4::from_array([0, 1, 2, 3].map(|lane| from[4 * half + lane].to_native()))
}

#[inline(always)]
fn dots(block: &ArchivedBlock, dir: [Vec4; 3]) -> [Vec4; 2] {
    [0, 1].map(|half| four(&block.x, half) * dir[0] + four(&block.y, half) * dir[1] + four(&block.z, half) * dir[2])
}

/// Mask of the lanes that are not less than `threshold`. NaN is not less.
#[inline(always)]
fn mask(dots: [Vec4; 2], threshold: f32) -> u32 {
    let threshold = Vec4::splat(threshold);
    !(dots[0].cmplt(threshold).bitmask() | dots[1].cmplt(threshold).bitmask() << 4) & 0xff
}

/// See [`Dispatch::argmin`](super::Dispatch::argmin).
#[inline(never)]
pub(super) fn argmin(values: &[[f64; LANES]]) -> usize {
    let less = |a: f64, b: f64| if a < b { a } else { b };
    let mut low = [f64::INFINITY; LANES];
    for chunk in values {
        for (low, value) in low.iter_mut().zip(chunk) {
            *low = less(*value, *low);
        }
    }
    let four = [less(low[0], low[4]), less(low[1], low[5]), less(low[2], low[6]), less(low[3], low[7])];
    let min = less(less(four[0], four[2]), less(four[1], four[3]));
    for (index, chunk) in values.iter().enumerate() {
        let mut equal = 0_u32;
        for (lane, value) in chunk.iter().enumerate() {
            equal |= u32::from(*value == min) << lane;
        }
        if equal != 0 {
            return index * LANES + equal.trailing_zeros() as usize;
        }
    }
    0
}

#[inline(always)]
fn halves([a, b, c, d, e, f, g, h]: &[f32; LANES]) -> [Vec4; 2] {
    [Vec4::new(*a, *b, *c, *d), Vec4::new(*e, *f, *g, *h)]
}

impl Simd for Portable {
    #[inline(always)]
    fn near_best<const N: usize>(self, blocks: &[ArchivedBlock; N], dir: [f32; 3], margin: f32) -> u32 {
        let dir = dir.map(Vec4::splat);
        let dots = blocks.each_ref().map(|block| dots(block, dir));
        let max = dots.iter().flatten().fold(Vec4::NEG_INFINITY, |max, dot| dot.max(max));
        let threshold = max.max_element() - margin;
        dots.iter().rev().fold(0, |all, dots| all << LANES | mask(*dots, threshold))
    }

    #[inline(always)]
    #[expect(clippy::indexing_slicing, reason = "`lane` is taken modulo the number of lanes of all blocks")]
    fn exact_best<const N: usize>(self, blocks: &[ArchivedBlock; N], mut near: u32, dir: [f64; 3]) -> usize {
        let mut best = (f64::NEG_INFINITY, 0);
        while near != 0 {
            let lane = near.trailing_zeros() as usize % (N * LANES);
            near &= near - 1;
            let dot = exact_dot(&blocks[lane / LANES], lane % LANES, dir);
            // NaN compares false: the previous lane stays.
            if dot > best.0 {
                best = (dot, lane);
            }
        }
        best.1
    }

    #[inline(always)]
    fn not_less(self, block: &ArchivedBlock, dir: [f32; 3], threshold: f32) -> u32 {
        mask(dots(block, dir.map(Vec4::splat)), threshold)
    }

    #[inline(always)]
    #[expect(clippy::indexing_slicing, reason = "reads lanes 0..4 or 4..8 of eight")]
    fn edges_below(self, edges: [&[i16_le; LANES]; 3], dir: [f32; 3], threshold: f32) -> u32 {
        let dir = dir.map(Vec4::splat);
        let dots = [0, 1].map(|half| {
            let four = |c: &[i16_le; LANES]| {
                Vec4::from_array([0, 1, 2, 3].map(|lane| f32::from(c[4 * half + lane].to_native())))
            };
            four(edges[0]) * dir[0] + four(edges[1]) * dir[1] + four(edges[2]) * dir[2]
        });
        let threshold = Vec4::splat(threshold);
        dots[0].cmplt(threshold).bitmask() | dots[1].cmplt(threshold).bitmask() << 4
    }

    #[inline(always)]
    fn max_dot(self, blocks: &[ArchivedBlock], dir: [f32; 3]) -> f32 {
        let dir = dir.map(Vec4::splat);
        let mut max = [Vec4::NEG_INFINITY; 2];
        for block in blocks {
            let dots = dots(block, dir);
            max = [dots[0].max(max[0]), dots[1].max(max[1])];
        }
        max[0].max(max[1]).max_element()
    }

    #[inline(always)]
    #[expect(clippy::indexing_slicing, reason = "`N` blocks of eight lanes")]
    fn highest<const N: usize>(
        self,
        points: &[PointBlock; N],
        faces: &NormalBlock,
        mut each: impl FnMut(usize, [f32; LANES]),
    ) -> ([f32; LANES], [u32; LANES]) {
        let mut highest = ([f32::NEG_INFINITY; LANES], [0; LANES]);
        for index in 0..LANES * N {
            let point = points[index / LANES].0.map(|c| c[index % LANES]);
            let heights = heights(faces, point);
            for ((height, highest), point) in heights.iter().zip(&mut highest.0).zip(&mut highest.1) {
                let is_higher = height > highest;
                *highest = if is_higher { *height } else { *highest };
                *point = if is_higher { index as u32 } else { *point };
            }
            each(index, heights);
        }
        highest
    }

    #[inline(always)]
    #[expect(clippy::indexing_slicing, reason = "halves of blocks, and three axes")]
    fn transform(self, points: &PointBlock, rows: &[[f32; 3]; 3], center: [f32; 3]) -> PointBlock {
        let [x, y, z] = points.0.each_ref().map(halves);
        let component = |axis: usize| {
            let [a, b, c] = rows[axis].map(Vec4::splat);
            let half = |i: usize| a * x[i] + b * y[i] + c * z[i] + Vec4::splat(center[axis]);
            whole([half(0), half(1)])
        };
        PointBlock([component(0), component(1), component(2)])
    }

    #[inline(always)]
    fn near_farthest<const N: usize>(self, points: &[PointBlock; N], dir: [f32; 3], margin: f32) -> LaneSet {
        let dots = point_dots(points, dir);
        let max = dots.iter().flatten().fold(Vec4::NEG_INFINITY, |max, dot| dot.max(max)).max_element();
        let mut near = LaneSet::EMPTY;
        for (block, dots) in dots.iter().enumerate() {
            let [low, high] = dots.map(|dot| dot.cmpge(Vec4::splat(max - margin)).bitmask());
            near.add_block(block, low | high << 4);
        }
        near
    }

    #[inline(always)]
    fn less(self, values: &[f32; LANES], threshold: f32) -> u32 {
        let threshold = Vec4::splat(threshold);
        let [low, high] = halves(values).map(|half| half.cmpge(threshold).bitmask());
        !(low | high << 4) & 0xff
    }
}

/// Heights of a point over eight faces.
#[inline(always)]
#[expect(clippy::indexing_slicing, reason = "halves of blocks, and three axes")]
fn heights(faces: &NormalBlock, point: [f32; 3]) -> [f32; LANES] {
    let point = point.map(Vec4::splat);
    let [x, y, z] = faces.normal.each_ref().map(halves);
    let offset = halves(&faces.offset);
    let half = |i: usize| x[i] * point[0] + y[i] * point[1] + z[i] * point[2] + offset[i];
    whole([half(0), half(1)])
}

/// Dot products of all points with `dir`.
#[inline(always)]
#[expect(clippy::indexing_slicing, reason = "two halves of a block")]
fn point_dots<const N: usize>(points: &[PointBlock; N], dir: [f32; 3]) -> [[Vec4; 2]; N] {
    let dir = dir.map(Vec4::splat);
    points.each_ref().map(|PointBlock(block)| {
        let [x, y, z] = block.each_ref().map(halves);
        [0, 1].map(|i: usize| x[i] * dir[0] + y[i] * dir[1] + z[i] * dir[2])
    })
}

#[inline(always)]
fn whole([low, high]: [Vec4; 2]) -> [f32; LANES] {
    let ([a, b, c, d], [e, f, g, h]) = (low.to_array(), high.to_array());
    [a, b, c, d, e, f, g, h]
}
