//! The proof of an index.

/// A proof of an index.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Proof {
    /// Bound on the regret of a query in any direction, relative to the diameter, beyond the
    /// rounding error of the dot products.
    pub regret: f64,
    /// Number of leaves, counted once for each region that leads to them.
    pub leaves: usize,
    /// Number of pieces into which the leaves' regions cut the arcs.
    pub pieces: usize,
}

impl Proof {
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            regret: self.regret.max(other.regret),
            leaves: self.leaves + other.leaves,
            pieces: self.pieces + other.pieces,
        }
    }
}
