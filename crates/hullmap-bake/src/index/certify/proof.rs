//! The proof of an index, or the reason why there is none.

use glam::DVec3;

/// Maximum regret of a proven index, relative to the diameter. A support query is exact up to
/// 2e-7, of which the hull's distance from its source points may take the other half.
pub const LIMIT: f64 = 1e-7;

/// Why an index is not proven.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum Unproven {
    /// A leaf does not list a support vertex.
    #[error("in direction {direction}, the leaf at word {slot} does not list support vertex {vertex}")]
    Missing { slot: usize, vertex: u32, direction: DVec3 },
    /// No arc crosses a leaf, and none of its candidates is the support vertex there.
    #[error("in direction {direction}, the leaf at word {slot} does not list the support vertex")]
    Elsewhere { slot: usize, direction: DVec3 },
    /// The region of a leaf is so thin that rounding error may matter.
    #[error(
        "the leaf at word {slot} has a region so thin that its regret may reach {bound:.1e} of the diameter (at most {LIMIT:.1e} is exact)"
    )]
    Thin { slot: usize, bound: f64 },
    /// A lane of a block does not hold a vertex of the hull.
    #[error("lane {lane} of block {block} does not hold a vertex of the hull")]
    Lane { block: usize, lane: usize },
    /// A plane or a fan has a vector that is not of unit length, or a step of a fan does not start
    /// at its own angle.
    #[error("the node at word {at} has a vector that is not of unit length, or a step at the wrong angle")]
    Node { at: usize },
    /// Nodes are shared so that a proof would take too long.
    #[error("a proof would take too long: the index visits its nodes too often")]
    Work,
}

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
