//! Eight lanes at a time, with AVX2 and fused multiply-add.
//!
//! One of the two modules of the crate with unsafe code. An [`Avx2`] is made by [`Avx2::detect`] alone, so that having one
//! proves that the processor has the instructions.
#![allow(unsafe_code)]

use std::arch::x86_64::{
    __m256, __m256d, _CMP_EQ_OQ, _CMP_LT_OQ, _CMP_NLT_UQ, _mm_loadu_si128, _mm256_add_pd, _mm256_castps256_ps128,
    _mm256_cmp_pd, _mm256_cmp_ps, _mm256_cvtepi16_epi32, _mm256_cvtepi32_ps, _mm256_cvtps_pd, _mm256_cvtss_f32,
    _mm256_extractf128_ps, _mm256_fmadd_ps, _mm256_loadu_pd, _mm256_loadu_ps, _mm256_max_pd, _mm256_max_ps,
    _mm256_min_pd, _mm256_movemask_pd, _mm256_movemask_ps, _mm256_mul_pd, _mm256_mul_ps, _mm256_permute_pd,
    _mm256_permute_ps, _mm256_permute2f128_pd, _mm256_permute2f128_ps, _mm256_set1_pd, _mm256_set1_ps, _mm256_sub_ps,
};

use hullmap_format::archive::{ArchivedBlock, LANES};
use rkyv::rend::{f32_le, i16_le};

use super::{Simd, Work};

/// Proof that the processor has AVX2 and FMA (and BMI, as every such processor has).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2(());

impl Avx2 {
    pub(crate) fn detect() -> Option<Self> {
        let has_all = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2");
        has_all.then_some(Self(()))
    }

    /// Does `work` in a function compiled for these instructions.
    #[inline(always)]
    pub(super) fn run<W: Work>(self, work: W, dir: [W::Scalar; 3]) -> W::Answer {
        let [x, y, z] = dir;
        // SAFETY: `self` proves that the processor has the features that `compiled` is compiled for.
        unsafe { compiled(self, work, x, y, z) }
    }

    /// Where the least of `values` is, which come in whole chunks: the first place of several. 0 when there are none, or NaN
    /// alone.
    #[inline(always)]
    pub(super) fn least(self, values: &[[f64; LANES]]) -> usize {
        // SAFETY: `self` proves that the processor has the features.
        unsafe { least(values) }
    }
}

/// First the least value, then the places that hold it, 64 at a time: nothing to predict where there are no more.
#[target_feature(enable = "avx2,bmi1")]
fn least(values: &[[f64; LANES]]) -> usize {
    let mut low = [_mm256_set1_pd(f64::INFINITY); 2];
    for chunk in values {
        let halves = load_pd(chunk);
        low = [_mm256_min_pd(halves[0], low[0]), _mm256_min_pd(halves[1], low[1])];
    }
    let low = _mm256_min_pd(low[0], low[1]);
    let low = _mm256_min_pd(low, _mm256_permute2f128_pd::<1>(low, low));
    let low = _mm256_min_pd(low, _mm256_permute_pd::<0b0101>(low));
    for (number, chunks) in values.chunks(64 / LANES).enumerate() {
        let mut equal = 0_u64;
        for chunk in chunks.iter().rev() {
            let halves = load_pd(chunk);
            let mask = |half| _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_EQ_OQ>(half, low)) as u32;
            equal = equal << LANES | u64::from(mask(halves[0]) | mask(halves[1]) << 4);
        }
        if equal != 0 {
            return 64 * number + equal.trailing_zeros() as usize;
        }
    }
    0
}

#[inline]
#[target_feature(enable = "avx2")]
fn load_pd(from: &[f64; LANES]) -> [__m256d; 2] {
    // SAFETY: the 32 bytes read each time are four f64 of the array's eight, the first and the last; any alignment will do.
    unsafe { [_mm256_loadu_pd(from.as_ptr()), _mm256_loadu_pd(from.as_ptr().add(4))] }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2")]
fn compiled<W: Work>(avx2: Avx2, work: W, x: W::Scalar, y: W::Scalar, z: W::Scalar) -> W::Answer {
    // Three numbers, not an array: they stay in registers.
    work.with(avx2, [x, y, z])
}

impl Simd for Avx2 {
    #[inline(always)]
    fn near_best<const N: usize>(self, blocks: &[ArchivedBlock; N], dir: [f32; 3], margin: f32) -> u32 {
        // SAFETY: `self` proves that the processor has the features; so in the methods below.
        unsafe { near_best(blocks, dir, margin) }
    }

    #[inline(always)]
    fn exact_best<const N: usize>(self, blocks: &[ArchivedBlock; N], _near: u32, dir: [f64; 3]) -> usize {
        // SAFETY: see above.
        unsafe { exact_best(blocks, dir) }
    }

    #[inline(always)]
    fn not_less(self, block: &ArchivedBlock, dir: [f32; 3], least: f32) -> u32 {
        // SAFETY: see above.
        unsafe { mask(dots(block, splat(dir)), _mm256_set1_ps(least)) }
    }

    #[inline(always)]
    fn edges_below(self, edges: [&[i16_le; LANES]; 3], dir: [f32; 3], least: f32) -> u32 {
        // SAFETY: see above.
        unsafe { edges_below(edges, dir, least) }
    }

    #[inline(always)]
    fn greatest(self, blocks: &[ArchivedBlock], dir: [f32; 3]) -> f32 {
        // SAFETY: see above.
        unsafe { greatest(blocks, dir) }
    }
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn near_best<const N: usize>(blocks: &[ArchivedBlock; N], dir: [f32; 3], margin: f32) -> u32 {
    let dir = splat(dir);
    let mut all = [_mm256_set1_ps(f32::NEG_INFINITY); N];
    let mut greatest = all[0];
    for (dot, block) in all.iter_mut().zip(blocks) {
        *dot = dots(block, dir);
        greatest = _mm256_max_ps(*dot, greatest);
    }
    let least = _mm256_sub_ps(greatest_lane(greatest), _mm256_set1_ps(margin));
    let mut near = 0;
    for dot in all.iter().rev() {
        near = near << LANES | mask(*dot, least);
    }
    near
}

/// All lanes, not only those that are near: so there is nothing to predict.
#[inline]
#[target_feature(enable = "avx2,fma")]
#[expect(clippy::indexing_slicing, reason = "`half` is 0 or 1, of two halves")]
fn exact_best<const N: usize>(blocks: &[ArchivedBlock; N], dir: [f64; 3]) -> usize {
    let dir = [_mm256_set1_pd(dir[0]), _mm256_set1_pd(dir[1]), _mm256_set1_pd(dir[2])];
    let mut all = [[_mm256_set1_pd(f64::NEG_INFINITY); 2]; N];
    let mut greatest = all[0][0];
    for (dots, block) in all.iter_mut().zip(blocks) {
        let [x, y, z] = [widen(load(&block.x)), widen(load(&block.y)), widen(load(&block.z))];
        for half in 0..2 {
            let [x, y, z] =
                [_mm256_mul_pd(x[half], dir[0]), _mm256_mul_pd(y[half], dir[1]), _mm256_mul_pd(z[half], dir[2])];
            dots[half] = _mm256_add_pd(_mm256_add_pd(x, y), z);
            greatest = _mm256_max_pd(dots[half], greatest);
        }
    }
    let greatest = _mm256_max_pd(greatest, _mm256_permute2f128_pd::<1>(greatest, greatest));
    let greatest = _mm256_max_pd(greatest, _mm256_permute_pd::<0b0101>(greatest));
    let mut equal = 0_u32;
    for dots in all.iter().rev() {
        for half in dots.iter().rev() {
            equal = equal << 4 | _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_EQ_OQ>(*half, greatest)) as u32;
        }
    }
    // None is equal where all are NaN.
    equal.trailing_zeros() as usize % (N * LANES)
}

/// The lower and the upper four lanes in double precision.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn widen(a: __m256) -> [__m256d; 2] {
    [_mm256_cvtps_pd(_mm256_castps256_ps128(a)), _mm256_cvtps_pd(_mm256_extractf128_ps::<1>(a))]
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn greatest(blocks: &[ArchivedBlock], dir: [f32; 3]) -> f32 {
    let dir = splat(dir);
    // Four at a time, as one maximum waits for the one before.
    let mut greatest = [_mm256_set1_ps(f32::NEG_INFINITY); 4];
    let (fours, rest) = blocks.as_chunks::<4>();
    for four in fours {
        for (greatest, block) in greatest.iter_mut().zip(four) {
            *greatest = _mm256_max_ps(dots(block, dir), *greatest);
        }
    }
    for block in rest {
        greatest[0] = _mm256_max_ps(dots(block, dir), greatest[0]);
    }
    let [a, b, c, d] = greatest;
    _mm256_cvtss_f32(greatest_lane(_mm256_max_ps(_mm256_max_ps(a, b), _mm256_max_ps(c, d))))
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
    // SAFETY: the 32 bytes read are those of the array: eight f32 without gaps, in the byte order of x86-64; any alignment
    // will do.
    unsafe { _mm256_loadu_ps(from.as_ptr().cast()) }
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn edges_below(edges: [&[i16_le; LANES]; 3], dir: [f32; 3], least: f32) -> u32 {
    let [x, y, z] = edges;
    let dot = _mm256_mul_ps(load_short(x), _mm256_set1_ps(dir[0]));
    let dot = _mm256_fmadd_ps(load_short(y), _mm256_set1_ps(dir[1]), dot);
    let dot = _mm256_fmadd_ps(load_short(z), _mm256_set1_ps(dir[2]), dot);
    _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(dot, _mm256_set1_ps(least))) as u32
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn load_short(from: &[i16_le; LANES]) -> __m256 {
    // SAFETY: the 16 bytes read are those of the array: eight i16 without gaps, in the byte order of x86-64; any alignment
    // will do.
    let short = unsafe { _mm_loadu_si128(from.as_ptr().cast()) };
    _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(short))
}

/// Lanes that are not less than `least`, NaN among them.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn mask(dots: __m256, least: __m256) -> u32 {
    _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_NLT_UQ>(dots, least)) as u32
}

/// The greatest lane, in all lanes.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn greatest_lane(a: __m256) -> __m256 {
    let a = _mm256_max_ps(a, _mm256_permute2f128_ps::<1>(a, a));
    let a = _mm256_max_ps(a, _mm256_permute_ps::<0b01_00_11_10>(a));
    _mm256_max_ps(a, _mm256_permute_ps::<0b10_11_00_01>(a))
}
