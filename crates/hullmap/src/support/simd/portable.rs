//! Portable SIMD, four lanes at a time: glam's `Vec4` is SSE2 on x86-64, NEON on AArch64, scalar
//! elsewhere.

use glam::Vec4;
use hullmap_format::archive::{ArchivedBlock, LANES};
use rkyv::rend::{f32_le, i16_le};

use super::Simd;
use crate::support::candidate::exact_dot;
use crate::support::facets::{NormalBlock, PointBlock};

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

/// See [`Dispatch::farthest`](super::Dispatch::farthest).
#[inline(never)]
pub(super) fn farthest(
    normals: &[NormalBlock],
    points: &[PointBlock],
    count: usize,
    value: &mut [[f32; LANES]],
    mut index: Option<&mut [[u32; LANES]]>,
) {
    for (b, (block, value)) in normals.iter().zip(value).enumerate() {
        let [x, y, z] = block.normal.each_ref().map(halves);
        let offset = halves(&block.offset);
        for half in 0..2 {
            let (mut best, mut at) = (Vec4::NEG_INFINITY, Vec4::ZERO);
            let mut number = 0;
            for (p, PointBlock([px, py, pz])) in points.iter().enumerate() {
                let inside = count.saturating_sub(LANES * p).min(LANES);
                for ((px, py), pz) in px.iter().zip(py).zip(pz).take(inside) {
                    let [Some(x), Some(y), Some(z)] = [&x, &y, &z].map(|c| c.get(half)) else { continue };
                    let dot = *x * Vec4::splat(*px) + *y * Vec4::splat(*py) + *z * Vec4::splat(*pz);
                    let farther = dot.cmpgt(best);
                    best = Vec4::select(farther, dot, best);
                    // As bits: a number that is only moved.
                    at = Vec4::select(farther, Vec4::splat(f32::from_bits(number)), at);
                    number += 1;
                }
            }
            let Some(offset) = offset.get(half) else { continue };
            if let Some(to) = value.get_mut(4 * half..4 * half + 4) {
                to.copy_from_slice(&(best + *offset).to_array());
            }
            let to = index.as_mut().and_then(|index| index.get_mut(b)?.get_mut(4 * half..4 * half + 4));
            if let Some(to) = to {
                to.copy_from_slice(&at.to_array().map(f32::to_bits));
            }
        }
    }
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
}
