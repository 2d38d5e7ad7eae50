//! What is proven of an index, or why it is not proven.

use glam::DVec3;

/// Maximum regret of a proven index, relative to the diameter. A support query is exact up to
/// 2e-7, of which the hull's distance from its source points may take the other half.
pub const LIMIT: f64 = 1e-7;

/// Why an index is not proven.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unproven {
    /// A leaf does not list a support vertex.
    #[error("in direction {direction}, the leaf at word {slot} does not list support vertex {vertex}")]
    Missing {
        /// Word of the slot that refers to the leaf.
        slot: usize,
        /// The vertex.
        vertex: u32,
        /// A direction in which it is a support vertex, up to rounding error.
        direction: DVec3,
    },
    /// No arc crosses a leaf, and none of its candidates is the support vertex there.
    #[error("in direction {direction}, the leaf at word {slot} does not list the support vertex")]
    Elsewhere {
        /// Word of the slot that refers to the leaf.
        slot: usize,
        /// A direction that leads to the leaf.
        direction: DVec3,
    },
    /// The region of a leaf is so thin that rounding error may matter.
    #[error(
        "the leaf at word {slot} has a region so thin that its regret may reach {bound:.1e} of the diameter (at most {LIMIT:.1e} is exact)"
    )]
    Thin {
        /// Word of the slot that refers to the leaf.
        slot: usize,
        /// Bound on the regret, relative to the diameter.
        bound: f64,
    },
    /// A lane of a block does not hold a vertex of the hull.
    #[error("lane {lane} of block {block} does not hold a vertex of the hull")]
    Lane {
        /// Index of the block.
        block: usize,
        /// Index of the lane.
        lane: usize,
    },
    /// A plane or a fan has a normal or an axis that is not of unit length, or a step of a fan does
    /// not start at its own angle.
    #[error("the node at word {at} has a vector that is not of unit length, or a step at the wrong angle")]
    Node {
        /// First word of the node.
        at: usize,
    },
    /// The nodes of the index are shared in such a way that a proof would take too long.
    #[error("a proof would take too long: the index visits its nodes too often")]
    Work,
}

/// What has been proven of an index.
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
