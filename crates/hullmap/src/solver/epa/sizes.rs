//! The sizes of polytopes, and memory for the large ones.

use super::polytope::Polytope;

/// Maximum number of vertices of each polytope size. The first is enough for small hulls and
/// touching pairs, the second for nearly all queries, the third for sphere-like hulls; the last
/// limits the cost of a query.
pub(super) const SIZES: [usize; 4] = [24, 64, 256, 1024];

/// The polytopes of the last two sizes.
#[derive(Clone, Debug)]
pub(in crate::solver) struct Large {
    pub(super) big: Polytope<{ SIZES[2] }, { 2 * SIZES[2] }>,
    pub(super) biggest: Polytope<{ SIZES[3] }, { 2 * SIZES[3] }>,
}

impl Large {
    pub(in crate::solver) fn empty() -> Self {
        Self { big: Polytope::empty(0.0), biggest: Polytope::empty(0.0) }
    }
}
