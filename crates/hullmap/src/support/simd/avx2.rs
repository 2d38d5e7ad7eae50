//! SIMD with AVX2 and fused multiply-add: eight lanes at a time.
//!
//! This module contains unsafe code. Only [`Avx2::detect`] constructs an [`Avx2`], so a value of
//! that type proves that the processor has the instructions.
#![allow(unsafe_code)]

use std::arch::x86_64::{
    __m256, __m256d, __m256i, _CMP_EQ_OQ, _CMP_GE_OQ, _CMP_GT_OQ, _CMP_LT_OQ, _CMP_NGE_UQ, _CMP_NLT_UQ, _MM_HINT_T0,
    _mm_loadu_si128, _mm_prefetch, _mm256_add_pd, _mm256_add_ps, _mm256_blendv_epi8, _mm256_castps_si256,
    _mm256_castps256_ps128, _mm256_cmp_pd, _mm256_cmp_ps, _mm256_cvtepi16_epi32, _mm256_cvtepi32_ps, _mm256_cvtps_pd,
    _mm256_cvtss_f32, _mm256_extractf128_ps, _mm256_fmadd_ps, _mm256_loadu_pd, _mm256_loadu_ps, _mm256_max_pd,
    _mm256_max_ps, _mm256_min_pd, _mm256_movemask_pd, _mm256_movemask_ps, _mm256_mul_pd, _mm256_mul_ps,
    _mm256_permute_pd, _mm256_permute_ps, _mm256_permute2f128_pd, _mm256_permute2f128_ps, _mm256_set1_epi32,
    _mm256_set1_pd, _mm256_set1_ps, _mm256_setzero_si256, _mm256_storeu_ps, _mm256_storeu_si256, _mm256_sub_ps,
};

use hullmap_format::archive::{ArchivedBlock, LANES};
use rkyv::rend::{f32_le, i16_le};

use super::{Kernel, Pass, Simd};
use crate::facets::lane_set::LaneSet;
use crate::facets::table::{NormalBlock, PointBlock};

/// Proof that the processor has AVX2, FMA, BMI1, BMI2 and POPCNT.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2(());

impl Avx2 {
    pub(crate) fn detect() -> Option<Self> {
        let has_all = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("popcnt");
        has_all.then_some(Self(()))
    }

    /// Runs `kernel`, compiled for these instructions.
    #[inline(always)]
    pub(super) fn run<K: Kernel>(self, kernel: K, dir: [K::Scalar; 3]) -> K::Output {
        let [x, y, z] = dir;
        // SAFETY: `self` proves that the processor has the features that `compiled` is compiled
        // for.
        unsafe { compiled(self, kernel, x, y, z) }
    }

    /// Runs `pass`, compiled for these instructions.
    #[inline(always)]
    pub(super) fn pass(self, pass: &mut impl Pass) {
        // SAFETY: as above.
        unsafe { compiled_pass(self, pass) }
    }

    /// See [`Dispatch::argmin`](super::Dispatch::argmin).
    #[inline(always)]
    pub(super) fn argmin(self, values: &[[f64; LANES]]) -> usize {
        // SAFETY: `self` proves that the processor has the features.
        unsafe { argmin(values) }
    }
}

/// Bytes of a cache line.
const LINE: usize = 64;

/// Tells the processor to fetch all cache lines of `value`.
#[inline(always)]
pub(super) fn fetch<T>(value: &T) {
    fetch_bytes(std::ptr::from_ref(value).cast(), size_of::<T>());
}

/// Tells the processor to fetch `len` bytes from `start` on. SSE suffices, which every x86-64 has.
#[inline(always)]
pub(super) fn fetch_bytes(start: *const i8, len: usize) {
    for offset in (0..len).step_by(LINE) {
        // SAFETY: SSE is part of x86-64. The instruction changes nothing that the program can see,
        // and ignores addresses that are not mapped.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(offset)) };
    }
}

/// Finds the minimum, then its first index by comparing 64 values per step: for up to 64 values, no
/// branch depends on where the minimum is.
#[target_feature(enable = "avx2,bmi1")]
fn argmin(values: &[[f64; LANES]]) -> usize {
    let mut low = [_mm256_set1_pd(f64::INFINITY); 2];
    for chunk in values {
        let halves = load_pd(chunk);
        low = [_mm256_min_pd(halves[0], low[0]), _mm256_min_pd(halves[1], low[1])];
    }
    let low = _mm256_min_pd(low[0], low[1]);
    let low = _mm256_min_pd(low, _mm256_permute2f128_pd::<1>(low, low));
    let low = _mm256_min_pd(low, _mm256_permute_pd::<0b0101>(low));
    for (index, chunks) in values.chunks(64 / LANES).enumerate() {
        let mut equal = 0_u64;
        for chunk in chunks.iter().rev() {
            let halves = load_pd(chunk);
            let mask = |half| _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_EQ_OQ>(half, low)) as u32;
            equal = equal << LANES | u64::from(mask(halves[0]) | mask(halves[1]) << 4);
        }
        if equal != 0 {
            return 64 * index + equal.trailing_zeros() as usize;
        }
    }
    0
}

#[inline]
#[target_feature(enable = "avx2")]
fn load_pd(from: &[f64; LANES]) -> [__m256d; 2] {
    // SAFETY: each load reads 32 bytes, the first or the last four of the array's eight f64, at any
    // alignment.
    unsafe { [_mm256_loadu_pd(from.as_ptr()), _mm256_loadu_pd(from.as_ptr().add(4))] }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
fn compiled<K: Kernel>(avx2: Avx2, kernel: K, x: K::Scalar, y: K::Scalar, z: K::Scalar) -> K::Output {
    // Three scalars, not an array, so that they are passed in registers.
    kernel.run(avx2, [x, y, z])
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
fn compiled_pass(avx2: Avx2, pass: &mut impl Pass) {
    pass.run(avx2);
}

impl Simd for Avx2 {
    #[inline(always)]
    fn near_best<const N: usize>(self, blocks: &[ArchivedBlock; N], dir: [f32; 3], margin: f32) -> u32 {
        // SAFETY: `self` proves that the processor has the features. The same holds in the methods
        // below.
        unsafe { near_best(blocks, dir, margin) }
    }

    #[inline(always)]
    fn exact_best<const N: usize>(self, blocks: &[ArchivedBlock; N], _near: u32, dir: [f64; 3]) -> usize {
        // SAFETY: as above, `self` proves that the processor has the features.
        unsafe { exact_best(blocks, dir) }
    }

    #[inline(always)]
    fn not_less(self, block: &ArchivedBlock, dir: [f32; 3], threshold: f32) -> u32 {
        // SAFETY: as above, `self` proves that the processor has the features.
        unsafe { mask(dots(block, splat(dir)), _mm256_set1_ps(threshold)) }
    }

    #[inline(always)]
    fn edges_below(self, edges: [&[i16_le; LANES]; 3], dir: [f32; 3], threshold: f32) -> u32 {
        // SAFETY: as above, `self` proves that the processor has the features.
        unsafe { edges_below(edges, dir, threshold) }
    }

    #[inline(always)]
    fn max_dot(self, blocks: &[ArchivedBlock], dir: [f32; 3]) -> f32 {
        // SAFETY: as above, `self` proves that the processor has the features.
        unsafe { max_dot(blocks, dir) }
    }

    #[inline(always)]
    fn highest<const N: usize>(
        self,
        points: &[PointBlock; N],
        faces: &NormalBlock,
        each: impl FnMut(usize, [f32; LANES]),
    ) -> ([f32; LANES], [u32; LANES]) {
        // SAFETY: as above, `self` proves that the processor has the features.
        unsafe { highest(points, faces, each) }
    }

    #[inline(always)]
    fn transform(self, points: &PointBlock, rows: &[[f32; 3]; 3], center: [f32; 3]) -> PointBlock {
        // SAFETY: as above, `self` proves that the processor has the features.
        unsafe { transform(points, rows, center) }
    }

    #[inline(always)]
    fn near_farthest<const N: usize>(self, points: &[PointBlock; N], dir: [f32; 3], margin: f32) -> LaneSet {
        // SAFETY: as above, `self` proves that the processor has the features.
        unsafe { near_farthest(points, dir, margin) }
    }

    #[inline(always)]
    fn less(self, values: &[f32; LANES], threshold: f32) -> u32 {
        // SAFETY: as above, `self` proves that the processor has the features.
        unsafe { less(values, threshold) }
    }
}

/// The dot products of eight points, without fused operations.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn products([x, y, z]: &[[f32; LANES]; 3], dir: [__m256; 3]) -> __m256 {
    let xy = _mm256_add_ps(_mm256_mul_ps(load_ps(x), dir[0]), _mm256_mul_ps(load_ps(y), dir[1]));
    _mm256_add_ps(xy, _mm256_mul_ps(load_ps(z), dir[2]))
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn highest<const N: usize>(
    points: &[PointBlock; N],
    NormalBlock { normal, offset }: &NormalBlock,
    mut each: impl FnMut(usize, [f32; LANES]),
) -> ([f32; LANES], [u32; LANES]) {
    let offset = load_ps(offset);
    let mut highest = _mm256_set1_ps(f32::NEG_INFINITY);
    let mut point_of = _mm256_setzero_si256();
    for (block, PointBlock([x, y, z])) in points.iter().enumerate() {
        for (lane, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
            let index = LANES * block + lane;
            let heights = _mm256_add_ps(products(normal, splat([*x, *y, *z])), offset);
            let is_higher = _mm256_castps_si256(_mm256_cmp_ps::<_CMP_GT_OQ>(heights, highest));
            point_of = _mm256_blendv_epi8(point_of, _mm256_set1_epi32(index as i32), is_higher);
            highest = _mm256_max_ps(heights, highest);
            each(index, store_ps(heights));
        }
    }
    (store_ps(highest), store_epi32(point_of))
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn transform(PointBlock(points): &PointBlock, rows: &[[f32; 3]; 3], center: [f32; 3]) -> PointBlock {
    let mut out = PointBlock([[0.0; LANES]; 3]);
    for ((out, row), center) in out.0.iter_mut().zip(rows).zip(center) {
        *out = store_ps(_mm256_add_ps(products(points, splat(*row)), _mm256_set1_ps(center)));
    }
    out
}

/// The dot products of all points, and their maximum in every lane.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn all_products<const N: usize>(points: &[PointBlock; N], dir: [f32; 3]) -> ([__m256; N], __m256) {
    let dir = splat(dir);
    let mut all = [_mm256_set1_ps(f32::NEG_INFINITY); N];
    let mut max = _mm256_set1_ps(f32::NEG_INFINITY);
    for (dots, PointBlock(block)) in all.iter_mut().zip(points) {
        *dots = products(block, dir);
        max = _mm256_max_ps(*dots, max);
    }
    (all, max_lane(max))
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn near_farthest<const N: usize>(points: &[PointBlock; N], dir: [f32; 3], margin: f32) -> LaneSet {
    let (all, max) = all_products(points, dir);
    let threshold = _mm256_sub_ps(max, _mm256_set1_ps(margin));
    let mut near = LaneSet::EMPTY;
    for (block, dots) in all.iter().enumerate() {
        near.add_block(block, _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_GE_OQ>(*dots, threshold)) as u32);
    }
    near
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn store_epi32(values: __m256i) -> [u32; LANES] {
    let mut to = [0; LANES];
    // SAFETY: writes the 32 bytes of the array, at any alignment.
    unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), values) };
    to
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn less(values: &[f32; LANES], threshold: f32) -> u32 {
    _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_NGE_UQ>(load_ps(values), _mm256_set1_ps(threshold))) as u32
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn load_ps(from: &[f32; LANES]) -> __m256 {
    // SAFETY: reads the 32 bytes of the array, at any alignment.
    unsafe { _mm256_loadu_ps(from.as_ptr()) }
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn store_ps(values: __m256) -> [f32; LANES] {
    let mut to = [0.0; LANES];
    // SAFETY: writes the 32 bytes of the array, at any alignment.
    unsafe { _mm256_storeu_ps(to.as_mut_ptr(), values) };
    to
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn near_best<const N: usize>(blocks: &[ArchivedBlock; N], dir: [f32; 3], margin: f32) -> u32 {
    let dir = splat(dir);
    let mut all = [_mm256_set1_ps(f32::NEG_INFINITY); N];
    let mut max = all[0];
    for (dot, block) in all.iter_mut().zip(blocks) {
        *dot = dots(block, dir);
        max = _mm256_max_ps(*dot, max);
    }
    let threshold = _mm256_sub_ps(max_lane(max), _mm256_set1_ps(margin));
    let mut near = 0;
    for dot in all.iter().rev() {
        near = near << LANES | mask(*dot, threshold);
    }
    near
}

/// Computes all lanes, not only the near ones, so that there are no branches to mispredict.
#[inline]
#[target_feature(enable = "avx2,fma")]
#[expect(clippy::indexing_slicing, reason = "`half` is 0 or 1, of two halves")]
fn exact_best<const N: usize>(blocks: &[ArchivedBlock; N], dir: [f64; 3]) -> usize {
    let dir = [_mm256_set1_pd(dir[0]), _mm256_set1_pd(dir[1]), _mm256_set1_pd(dir[2])];
    let mut all = [[_mm256_set1_pd(f64::NEG_INFINITY); 2]; N];
    let mut max = all[0][0];
    for (dots, block) in all.iter_mut().zip(blocks) {
        let [x, y, z] = [widen(load(&block.x)), widen(load(&block.y)), widen(load(&block.z))];
        for half in 0..2 {
            let [x, y, z] =
                [_mm256_mul_pd(x[half], dir[0]), _mm256_mul_pd(y[half], dir[1]), _mm256_mul_pd(z[half], dir[2])];
            dots[half] = _mm256_add_pd(_mm256_add_pd(x, y), z);
            max = _mm256_max_pd(dots[half], max);
        }
    }
    let max = _mm256_max_pd(max, _mm256_permute2f128_pd::<1>(max, max));
    let max = _mm256_max_pd(max, _mm256_permute_pd::<0b0101>(max));
    let mut equal = 0_u32;
    for dots in all.iter().rev() {
        for half in dots.iter().rev() {
            equal = equal << 4 | _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_EQ_OQ>(*half, max)) as u32;
        }
    }
    // The mask is empty if all are NaN: the modulo keeps the result in range.
    equal.trailing_zeros() as usize % (N * LANES)
}

/// The lower and the upper four lanes, converted to f64.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn widen(a: __m256) -> [__m256d; 2] {
    [_mm256_cvtps_pd(_mm256_castps256_ps128(a)), _mm256_cvtps_pd(_mm256_extractf128_ps::<1>(a))]
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn max_dot(blocks: &[ArchivedBlock], dir: [f32; 3]) -> f32 {
    let dir = splat(dir);
    // Four independent maxima, because each maximum has to wait for the previous one.
    let mut max = [_mm256_set1_ps(f32::NEG_INFINITY); 4];
    let (fours, rest) = blocks.as_chunks::<4>();
    for four in fours {
        for (max, block) in max.iter_mut().zip(four) {
            *max = _mm256_max_ps(dots(block, dir), *max);
        }
    }
    for block in rest {
        max[0] = _mm256_max_ps(dots(block, dir), max[0]);
    }
    let [a, b, c, d] = max;
    _mm256_cvtss_f32(max_lane(_mm256_max_ps(_mm256_max_ps(a, b), _mm256_max_ps(c, d))))
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn splat(dir: [f32; 3]) -> [__m256; 3] {
    [_mm256_set1_ps(dir[0]), _mm256_set1_ps(dir[1]), _mm256_set1_ps(dir[2])]
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn dots(block: &ArchivedBlock, dir: [__m256; 3]) -> __m256 {
    let x = _mm256_mul_ps(load(&block.x), dir[0]);
    let xy = _mm256_fmadd_ps(load(&block.y), dir[1], x);
    _mm256_fmadd_ps(load(&block.z), dir[2], xy)
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn load(from: &[f32_le; LANES]) -> __m256 {
    // SAFETY: reads the 32 bytes of the array: eight f32 without padding, in the byte order of
    // x86-64, at any alignment.
    unsafe { _mm256_loadu_ps(from.as_ptr().cast()) }
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn edges_below(edges: [&[i16_le; LANES]; 3], dir: [f32; 3], threshold: f32) -> u32 {
    let [x, y, z] = edges;
    let dot = _mm256_mul_ps(load_short(x), _mm256_set1_ps(dir[0]));
    let dot = _mm256_fmadd_ps(load_short(y), _mm256_set1_ps(dir[1]), dot);
    let dot = _mm256_fmadd_ps(load_short(z), _mm256_set1_ps(dir[2]), dot);
    _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(dot, _mm256_set1_ps(threshold))) as u32
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn load_short(from: &[i16_le; LANES]) -> __m256 {
    // SAFETY: reads the 16 bytes of the array: eight i16 without padding, in the byte order of
    // x86-64, at any alignment.
    let short = unsafe { _mm_loadu_si128(from.as_ptr().cast()) };
    _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(short))
}

/// Mask of the lanes that are not less than `threshold`. NaN is not less.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn mask(dots: __m256, threshold: __m256) -> u32 {
    _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_NLT_UQ>(dots, threshold)) as u32
}

/// Maximum over the lanes, in every lane.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn max_lane(a: __m256) -> __m256 {
    let a = _mm256_max_ps(a, _mm256_permute2f128_ps::<1>(a, a));
    let a = _mm256_max_ps(a, _mm256_permute_ps::<0b01_00_11_10>(a));
    _mm256_max_ps(a, _mm256_permute_ps::<0b10_11_00_01>(a))
}
