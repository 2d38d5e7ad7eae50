//! Linear scans with SIMD: f32 coordinates in blocks of 16, with x, y and z in separate arrays,
//! 64-byte aligned. Exact up to the rounding error of f32.
//!
//! There are three kernels, each a rival of its own: [`Portable`] (plain Rust that compilers turn
//! into baseline SSE2 or NEON), [`Avx2`] with FMA, and [`Avx512`]. The latter two take part if the
//! processor has them, so that nothing here needs `target-cpu`. Each keeps, lane by lane, the
//! maximum dot product so far and its block, in several accumulators so that no step waits for the
//! last. A reduction over the lanes ends the query.
//!
//! This module contains unsafe code: calls of functions for detected features, and aligned loads.
#![allow(unsafe_code)]

use glam::Vec3;

use crate::{
    query::{Rival, SupportQuery},
    subject::Subject,
};

/// Vertices in a block.
pub const LANES: usize = 16;

/// Lanes of the portable kernel: two baseline registers.
const PORTABLE_LANES: usize = 8;

/// Sixteen vertices.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Block {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
}

/// Position of a vertex in blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    block: usize,
    lane: usize,
}

impl Place {
    /// Index of the vertex; padding has indices beyond the last vertex.
    pub fn index(self) -> usize {
        self.block * LANES + self.lane
    }

    #[inline]
    fn position(self, blocks: &[Block]) -> Vec3 {
        let block = &blocks[self.block];
        Vec3::new(block.x[self.lane], block.y[self.lane], block.z[self.lane])
    }
}

/// The vertices in blocks. The last block is padded with vertex 0.
pub fn blocks(vertices: &[Vec3]) -> Vec<Block> {
    let group = |group: &[Vec3]| {
        let lane = |l: usize| group.get(l).copied().unwrap_or(vertices[0]);
        Block {
            x: std::array::from_fn(|l| lane(l).x),
            y: std::array::from_fn(|l| lane(l).y),
            z: std::array::from_fn(|l| lane(l).z),
        }
    };
    vertices.chunks(LANES).map(group).collect()
}

/// The best position, by the fastest kernel of this machine.
pub fn best_here(blocks: &[Block], dir: Vec3) -> Place {
    if let Some(kernel) = Avx512::detect() {
        kernel.best(blocks, dir)
    } else if let Some(kernel) = Avx2::detect() {
        kernel.best(blocks, dir)
    } else {
        Portable.best(blocks, dir)
    }
}

/// A scan of blocks. The existence of a value proves that the processor supports it.
pub trait Kernel: Copy {
    /// The rival's name.
    const NAME: &'static str;

    /// The kernel, if this machine can run it.
    fn detect() -> Option<Self>;

    /// A position with the maximum dot product. Without blocks, or for an invalid direction, some
    /// position in the first block.
    fn best(self, blocks: &[Block], dir: Vec3) -> Place;
}

/// Plain Rust over arrays.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

impl Kernel for Portable {
    const NAME: &'static str = "portable scan";

    fn detect() -> Option<Self> {
        Some(Self)
    }

    #[inline]
    fn best(self, blocks: &[Block], dir: Vec3) -> Place {
        let mut best = [f32::NEG_INFINITY; PORTABLE_LANES];
        let mut from = [0_u32; PORTABLE_LANES];
        let mut number = 0;
        for block in blocks {
            let parts = [&block.x, &block.y, &block.z].map(|c| c.as_chunks::<PORTABLE_LANES>().0);
            for part in 0..LANES / PORTABLE_LANES {
                let [x, y, z] = parts.map(|c| &c[part]);
                // One loop for each step: compilers vectorise each of them, but not all in one
                // loop.
                let dots: [f32; PORTABLE_LANES] =
                    std::array::from_fn(|lane| x[lane] * dir.x + y[lane] * dir.y + z[lane] * dir.z);
                let better: [u32; PORTABLE_LANES] =
                    std::array::from_fn(|lane| if dots[lane] > best[lane] { u32::MAX } else { 0 });
                for lane in 0..PORTABLE_LANES {
                    from[lane] = (number & better[lane]) | (from[lane] & !better[lane]);
                }
                for lane in 0..PORTABLE_LANES {
                    let bits = (dots[lane].to_bits() & better[lane]) | (best[lane].to_bits() & !better[lane]);
                    best[lane] = f32::from_bits(bits);
                }
                number += 1;
            }
        }
        let mut top = 0;
        for lane in 1..PORTABLE_LANES {
            if best[lane] > best[top] {
                top = lane;
            }
        }
        let index = from[top] as usize * PORTABLE_LANES + top;
        Place { block: index / LANES, lane: index % LANES }
    }
}

/// AVX2 with FMA: half a block at a time.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

/// AVX-512: a block at a time.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(());

#[cfg(target_arch = "x86_64")]
impl Kernel for Avx2 {
    const NAME: &'static str = "AVX2 scan";

    fn detect() -> Option<Self> {
        (is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")).then_some(Self(()))
    }

    #[inline]
    fn best(self, blocks: &[Block], dir: Vec3) -> Place {
        // SAFETY: `self` comes from `detect`, its field being private: the processor has AVX2, FMA.
        unsafe { x86::best_avx2(blocks, dir) }
    }
}

#[cfg(target_arch = "x86_64")]
impl Kernel for Avx512 {
    const NAME: &'static str = "AVX-512 scan";

    fn detect() -> Option<Self> {
        is_x86_feature_detected!("avx512f").then_some(Self(()))
    }

    #[inline]
    fn best(self, blocks: &[Block], dir: Vec3) -> Place {
        // SAFETY: `self` comes from `detect`, its field being private: the processor has AVX-512F.
        unsafe { x86::best_avx512(blocks, dir) }
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl Kernel for Avx2 {
    const NAME: &'static str = "AVX2 scan";

    fn detect() -> Option<Self> {
        None
    }

    fn best(self, blocks: &[Block], dir: Vec3) -> Place {
        Portable.best(blocks, dir)
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl Kernel for Avx512 {
    const NAME: &'static str = "AVX-512 scan";

    fn detect() -> Option<Self> {
        None
    }

    fn best(self, blocks: &[Block], dir: Vec3) -> Place {
        Portable.best(blocks, dir)
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    use super::{Block, LANES, Place, Vec3};

    /// Accumulators: as many as the cycles of a step's compare and blend.
    const ACCUMULATORS: usize = 4;

    /// Lanes of an AVX2 register.
    const HALF: usize = LANES / 2;

    /// Dot products of a block with one direction.
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn dots_avx512(block: &Block, dir: &[__m512; 3]) -> __m512 {
        // SAFETY: each of the block's arrays is 16 f32, a register's worth, and starts at a
        // multiple of 64 bytes in a block that is aligned to 64.
        let (x, y, z) = unsafe {
            (_mm512_load_ps(block.x.as_ptr()), _mm512_load_ps(block.y.as_ptr()), _mm512_load_ps(block.z.as_ptr()))
        };
        _mm512_fmadd_ps(z, dir[2], _mm512_fmadd_ps(y, dir[1], _mm512_mul_ps(x, dir[0])))
    }

    /// Lane by lane, the greater of two dot products, and its block.
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn greater_avx512(best: (__m512, __m512i), other: (__m512, __m512i)) -> (__m512, __m512i) {
        // False for NaN: then `best` stays.
        let better = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(other.0, best.0);
        (_mm512_mask_mov_ps(best.0, better, other.0), _mm512_mask_mov_epi32(best.1, better, other.1))
    }

    #[target_feature(enable = "avx512f")]
    pub(super) fn best_avx512(blocks: &[Block], dir: Vec3) -> Place {
        let dir = [_mm512_set1_ps(dir.x), _mm512_set1_ps(dir.y), _mm512_set1_ps(dir.z)];
        let one = _mm512_set1_epi32(1);
        let mut number = _mm512_setzero_si512();
        let mut best = (_mm512_set1_ps(f32::NEG_INFINITY), number);
        let (groups, rest) = blocks.as_chunks::<ACCUMULATORS>();
        if !groups.is_empty() {
            let mut bests = [best; ACCUMULATORS];
            for group in groups {
                for step in 0..ACCUMULATORS {
                    bests[step] = greater_avx512(bests[step], (dots_avx512(&group[step], &dir), number));
                    number = _mm512_add_epi32(number, one);
                }
            }
            best = greater_avx512(greater_avx512(bests[0], bests[1]), greater_avx512(bests[2], bests[3]));
        }
        for block in rest {
            best = greater_avx512(best, (dots_avx512(block, &dir), number));
            number = _mm512_add_epi32(number, one);
        }
        let greatest = _mm512_set1_ps(_mm512_reduce_max_ps(best.0));
        // If the maximum is NaN, no lane is equal. Then the result is lane 0, in bounds.
        let lane = _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(best.0, greatest).trailing_zeros() as usize % LANES;
        let from = _mm512_permutexvar_epi32(_mm512_set1_epi32(lane as i32), best.1);
        Place { block: _mm512_cvtsi512_si32(from) as usize, lane }
    }

    /// Dot products of half a block, lanes 0 to 7 or 8 to 15, with one direction.
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn dots_avx2<const SECOND: bool>(block: &Block, dir: &[__m256; 3]) -> __m256 {
        let at = if SECOND { HALF } else { 0 };
        // SAFETY: `at` is 0 or 8, so that 8 of an array's 16 f32 follow it; the array starts at a
        // multiple of 64 bytes and its second half at one of 32, a register's alignment.
        let (x, y, z) = unsafe {
            (
                _mm256_load_ps(block.x.as_ptr().add(at)),
                _mm256_load_ps(block.y.as_ptr().add(at)),
                _mm256_load_ps(block.z.as_ptr().add(at)),
            )
        };
        _mm256_fmadd_ps(z, dir[2], _mm256_fmadd_ps(y, dir[1], _mm256_mul_ps(x, dir[0])))
    }

    /// Lane by lane, the greater of two dot products, and its block.
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn greater_avx2(best: (__m256, __m256i), other: (__m256, __m256i)) -> (__m256, __m256i) {
        // False for NaN: then `best` stays.
        let better = _mm256_cmp_ps::<_CMP_GT_OQ>(other.0, best.0);
        (_mm256_blendv_ps(best.0, other.0, better), _mm256_blendv_epi8(best.1, other.1, _mm256_castps_si256(better)))
    }

    #[target_feature(enable = "avx2,fma")]
    pub(super) fn best_avx2(blocks: &[Block], dir: Vec3) -> Place {
        let dir = [_mm256_set1_ps(dir.x), _mm256_set1_ps(dir.y), _mm256_set1_ps(dir.z)];
        let one = _mm256_set1_epi32(1);
        // Counts halves of blocks.
        let mut number = _mm256_setzero_si256();
        let mut best = (_mm256_set1_ps(f32::NEG_INFINITY), number);
        let (groups, rest) = blocks.as_chunks::<{ ACCUMULATORS / 2 }>();
        if !groups.is_empty() {
            let mut bests = [best; ACCUMULATORS];
            for group in groups {
                let [a, b] = group;
                bests[0] = greater_avx2(bests[0], (dots_avx2::<false>(a, &dir), number));
                number = _mm256_add_epi32(number, one);
                bests[1] = greater_avx2(bests[1], (dots_avx2::<true>(a, &dir), number));
                number = _mm256_add_epi32(number, one);
                bests[2] = greater_avx2(bests[2], (dots_avx2::<false>(b, &dir), number));
                number = _mm256_add_epi32(number, one);
                bests[3] = greater_avx2(bests[3], (dots_avx2::<true>(b, &dir), number));
                number = _mm256_add_epi32(number, one);
            }
            best = greater_avx2(greater_avx2(bests[0], bests[1]), greater_avx2(bests[2], bests[3]));
        }
        for block in rest {
            best = greater_avx2(best, (dots_avx2::<false>(block, &dir), number));
            number = _mm256_add_epi32(number, one);
            best = greater_avx2(best, (dots_avx2::<true>(block, &dir), number));
            number = _mm256_add_epi32(number, one);
        }
        // Broadcast the maximum to all lanes.
        let swapped = _mm256_max_ps(best.0, _mm256_permute2f128_ps::<1>(best.0, best.0));
        let pairs = _mm256_max_ps(swapped, _mm256_permute_ps::<0b01_00_11_10>(swapped));
        let greatest = _mm256_max_ps(pairs, _mm256_permute_ps::<0b10_11_00_01>(pairs));
        // If the maximum is NaN, no lane is equal. Then the result is lane 0, in bounds.
        let equal = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_EQ_OQ>(best.0, greatest));
        let lane = equal.trailing_zeros() as usize % HALF;
        let from = _mm256_permutevar8x32_epi32(best.1, _mm256_set1_epi32(lane as i32));
        let half = _mm256_cvtsi256_si32(from) as usize;
        Place { block: half / 2, lane: half % 2 * HALF + lane }
    }
}

/// The vertices in blocks, and a kernel that scans them.
#[derive(Clone, Debug)]
pub struct SimdScan<K> {
    blocks: Vec<Block>,
    vertex_count: usize,
    kernel: K,
}

impl<K: Kernel> SimdScan<K> {
    /// The vertices of `subject`; `None` if this machine cannot run the kernel.
    pub fn new(subject: &Subject) -> Option<Self> {
        let vertices: Vec<Vec3> = subject.vertices().collect();
        Some(Self { blocks: blocks(&vertices), vertex_count: vertices.len(), kernel: K::detect()? })
    }
}

impl<K: Kernel> Rival for SimdScan<K> {
    type Query<'a>
        = Scan<'a, K>
    where
        K: 'a;

    fn name(&self) -> &str {
        K::NAME
    }

    fn is_exact(&self) -> bool {
        true
    }

    /// The padding.
    fn index_bytes(&self) -> usize {
        self.footprint_bytes() - size_of::<[f32; 3]>() * self.vertex_count
    }

    fn footprint_bytes(&self) -> usize {
        size_of_val(self.blocks.as_slice())
    }

    fn query(&self) -> Scan<'_, K> {
        Scan { blocks: &self.blocks, kernel: self.kernel }
    }

    fn duplicate(&self) -> Self {
        Self { blocks: self.blocks.clone(), ..*self }
    }
}

/// See [`SimdScan`].
pub struct Scan<'a, K> {
    blocks: &'a [Block],
    kernel: K,
}

impl<K: Kernel> SupportQuery for Scan<'_, K> {
    #[inline]
    fn support(&mut self, dir: Vec3) -> Vec3 {
        self.kernel.best(self.blocks, dir).position(self.blocks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::directions;
    use shapes::families::Family;

    /// Compared by value, since any of several equal vertices is correct, and FMA rounds less.
    #[test]
    fn kernels_agree_at_every_length() {
        for n in (8..100).chain([127, 128, 129, 1_000]) {
            let vertices: Vec<Vec3> = Family::Sphere.points(n, 5).into_iter().map(Vec3::from_array).collect();
            let blocks = blocks(&vertices);
            for dir in directions::random(200, n as u64) {
                let value = |place: Place| place.position(&blocks).as_dvec3().dot(dir.as_dvec3());
                let truth = vertices.iter().map(|v| v.as_dvec3().dot(dir.as_dvec3())).fold(f64::NEG_INFINITY, f64::max);
                let portable = value(Portable.best(&blocks, dir));
                assert!((truth - portable).abs() < 2e-7, "portable, n = {n}, {dir}");
                if let Some(kernel) = Avx2::detect() {
                    assert!((truth - value(kernel.best(&blocks, dir))).abs() < 2e-7, "AVX2, n = {n}, {dir}");
                }
                if let Some(kernel) = Avx512::detect() {
                    assert!((truth - value(kernel.best(&blocks, dir))).abs() < 2e-7, "AVX-512, n = {n}, {dir}");
                }
            }
        }
    }

    #[test]
    fn the_last_vertex_can_win() {
        for n in 1..70 {
            let vertices: Vec<Vec3> = (0..n).map(|i| Vec3::new(i as f32, 0.0, 0.0)).collect();
            let blocks = blocks(&vertices);
            assert_eq!(best_here(&blocks, Vec3::X).index(), n - 1);
            assert_eq!(Portable.best(&blocks, Vec3::X).index(), n - 1);
            assert_eq!(best_here(&blocks, Vec3::NEG_X).position(&blocks), Vec3::ZERO);
        }
    }

    #[test]
    fn invalid_directions_return_some_vertex() {
        let blocks = blocks(&[Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE]);
        for dir in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::new(f32::NAN, 1.0, 0.0)] {
            assert!(best_here(&blocks, dir).position(&blocks).is_finite());
            assert!(Portable.best(&blocks, dir).position(&blocks).is_finite());
        }
    }
}
