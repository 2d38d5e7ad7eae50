//! Operations of an instruction set, and the code that is compiled once for each set.

use hullmap_format::archive::{ArchivedBlock, LANES};
use rkyv::rend::i16_le;

use crate::facets::lane_set::LaneSet;
use crate::facets::table::{NormalBlock, PointBlock};

/// Operations on blocks of eight candidates. Every implementation is an instruction set.
pub(crate) trait Simd: Copy {
    /// Mask of the candidates whose dot product is within `margin` of the maximum over all `N`
    /// blocks: one bit per lane, with the first block in the lowest bits. NaN counts as within. `N`
    /// is at most 4.
    fn near_best<const N: usize>(self, blocks: &[ArchivedBlock; N], dir: [f32; 3], margin: f32) -> u32;

    /// Lane with the maximum dot product in f64 among those in the mask `near`; the lowest lane
    /// among equals, and any lane if all are NaN. Each product and each sum is rounded once, in the
    /// order x, y, z.
    fn exact_best<const N: usize>(self, blocks: &[ArchivedBlock; N], near: u32, dir: [f64; 3]) -> usize;

    /// Mask of the lanes whose dot product is not less than `threshold`, one bit per lane. NaN is
    /// not less.
    fn not_less(self, block: &ArchivedBlock, dir: [f32; 3], threshold: f32) -> u32;

    /// Mask of the edges whose dot product is less than `threshold`, one bit per edge. NaN is not
    /// less.
    fn edges_below(self, edges: [&[i16_le; LANES]; 3], dir: [f32; 3], threshold: f32) -> u32;

    /// Maximum dot product over all lanes of all blocks. NaN may be ignored. There is at least one
    /// block.
    fn max_dot(self, blocks: &[ArchivedBlock], dir: [f32; 3]) -> f32;

    /// For each of eight faces, the maximum height of all `points`, and the lowest index of a point
    /// that has it. Calls `each` with the index of every point and its heights: the dot product
    /// with the normal plus the offset. Each product and each sum is rounded once, in the order x,
    /// y, z, offset. No height is NaN.
    fn highest<const N: usize>(
        self,
        points: &[PointBlock; N],
        faces: &NormalBlock,
        each: impl FnMut(usize, [f32; LANES]),
    ) -> ([f32; LANES], [u32; LANES]);

    /// `center` + M p for eight points p, where `rows` are the rows of M. Each product and each sum
    /// is rounded once, in the order x, y, z, centre.
    fn transform(self, points: &PointBlock, rows: &[[f32; 3]; 3], center: [f32; 3]) -> PointBlock;

    /// The points whose dot product is within `margin` of the maximum, counted over the blocks as
    /// one slice. Each product and each sum is rounded once, in the order x, y, z. Points are
    /// finite.
    fn near_farthest<const N: usize>(self, points: &[PointBlock; N], dir: [f32; 3], margin: f32) -> LaneSet;

    /// Mask of the values less than `threshold`, one bit per lane. NaN is less.
    fn less(self, values: &[f32; LANES], threshold: f32) -> u32;
}

/// A pass over arrays: code that is compiled once per instruction set, and keeps its results.
pub(crate) trait Pass {
    /// Must be `#[inline(always)]`, as [`Kernel::run`].
    fn run<S: Simd>(&mut self, simd: S);
}

/// A SIMD kernel: code that is compiled once per instruction set and runs for one direction.
pub(crate) trait Kernel: Copy {
    type Scalar;
    type Output;
    /// Must be `#[inline(always)]`, and so must everything that it calls in an inner loop: only
    /// then is it compiled with the instruction set of its caller.
    fn run<S: Simd>(self, simd: S, dir: [Self::Scalar; 3]) -> Self::Output;
}
