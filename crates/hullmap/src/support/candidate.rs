//! Candidate for the support vertex: one lane of a leaf's block, and its dot product in f64.

use hullmap_format::archive::{ArchivedBlock, LANES};

/// A candidate, by block and lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate<'a> {
    pub(super) block: &'a ArchivedBlock,
    pub(super) lane: usize,
}

impl Candidate<'_> {
    #[inline(always)]
    #[expect(clippy::indexing_slicing, reason = "`lane` is taken modulo the number of lanes")]
    pub(crate) fn read(self) -> (u32, [f32; 3]) {
        let Self { block, lane } = self;
        // Always true already; it removes the compiler's bounds checks.
        let lane = lane % LANES;
        let point = [block.x[lane].to_native(), block.y[lane].to_native(), block.z[lane].to_native()];
        (block.vertex[lane].to_native(), point)
    }
}

/// Dot product of a lane with `dir` in f64. The products are exact if `dir` was widened from f32.
#[inline]
pub(crate) fn exact_dot(block: &ArchivedBlock, lane: usize, dir: [f64; 3]) -> f64 {
    let (_, point) = Candidate { block, lane }.read();
    f64::from(point[0]) * dir[0] + f64::from(point[1]) * dir[1] + f64::from(point[2]) * dir[2]
}
