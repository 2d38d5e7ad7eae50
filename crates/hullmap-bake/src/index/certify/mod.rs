//! Certificate of a direction index: a proof that every direction leads to a leaf that lists its
//! support vertex. It is computed only from the hull and from the index as it is stored, and
//! shares no step with the construction of the index.
//!
//! The normal cones of the vertices tile the sphere of directions (the Gauss map). Their borders
//! are the arcs of the edges: along the arc of an edge, its two ends are support vertices. So a
//! leaf is exact if, and only if, it lists
//! - both ends of every edge whose arc crosses the leaf's region, and
//! - if no arc crosses the region, the vertex whose cone contains it.
//!
//! # Steps
//! 1. Each lane of each block must hold a vertex and its position.
//! 2. `arcs` computes the arcs from the faces, and clips them to the faces of the cube. There,
//!    arcs are straight segments, and regions are convex polygons.
//! 3. `descent` follows all arcs through all nodes at once.
//! 4. In each leaf, both conditions are checked (`Certifier::leaf`).
//!
//! # Rounding
//! A direction near the border of a region may be located on either side of it. Around a cell of
//! the grid, that is less than [`cube::CELL_SLACK`], and the arcs are followed through the cell
//! widened by nearly as much: nothing more is needed.
//!
//! At a plane or at a step of a fan, the error is a few 1e-15, and cones that reach no farther are
//! not listed beyond. There, a region has a *core*, in which the conditions must hold, and a
//! *reach*, from which directions may lead to the leaf (`region`). The regret changes by at most
//! the diameter times the angle between two directions. So the regret is at most the greatest
//! distance of a point of the reach from the core, times the diameter. It must be at most
//! [`LIMIT`].
//!
//! Where two planes meet at a very small angle, the reach has a spike beyond the core, and between
//! planes that nearly coincide there is no core at all. Both are slivers, and the regret is bounded
//! along the sliver's axis (`Certifier::sliver`).
//!
//! # Premises
//! The hull is proven ([`crate::hull::certify`]). A query finds the best of the candidates that a
//! leaf lists.
//!
//! # Complexity
//! O(arcs · regions that an arc crosses). It is bounded for any index (`WORK`).

mod arcs;
mod descent;
mod region;

use glam::DVec3;
use hullmap_format::{
    IndexKind,
    archive::{Block, LANES},
    cube,
    node::Words,
};
use rayon::prelude::*;

use crate::hull::Hull;
use arcs::{Arcs, Piece};
use region::{Cell, Part};

/// Maximum regret of a proven index, relative to the diameter. A support query is exact up to
/// 2e-7, of which the hull's distance from its source points may take the other half.
pub const LIMIT: f64 = 1e-7;

/// Length from which a spike of a region beyond its core is treated as a sliver.
const SPIKE: f64 = 0.1 * LIMIT;

/// Maximum number of regions and pieces of arcs visited on a face of the cube, in multiples of the
/// index's words, the blocks' lanes and the hull's edges together.
///
/// Indices of all families visit at most a tenth of it. A hostile index, whose nodes are shared so
/// that they are visited again and again, is given up.
const WORK: usize = 64;

/// How far beyond the plane between two cones a point may lie to count as a point of the cone:
/// rounding error, relative to the lengths of the edge and of the direction.
const ON_PLANE: f64 = 1e-15;

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

/// Result of the proof of an index.
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
    fn and(self, other: Self) -> Self {
        Self {
            regret: self.regret.max(other.regret),
            leaves: self.leaves + other.leaves,
            pieces: self.pieces + other.pieces,
        }
    }
}

/// Proves the index of `hull`, which is stored as these words and blocks.
///
/// The words must have passed the checks of [`hullmap_format::walk`].
///
/// # Errors
/// A leaf that is not proven; always the same for the same index.
pub fn certify<W: Words + Sync + ?Sized>(
    hull: &Hull,
    kind: IndexKind,
    words: &W,
    blocks: impl IntoIterator<Item = Block>,
) -> Result<Proof, Unproven> {
    let lanes = lanes(hull, blocks)?;
    let certifier = Certifier::new(hull, kind, words, &lanes);
    if kind == IndexKind::None || hull.rank < 2 {
        return certifier.everywhere();
    }
    let arcs = Arcs::new(hull);
    let faces: Vec<Result<Proof, Unproven>> =
        (0..6).into_par_iter().map(|face| certifier.face(face, arcs.on_face(face, cube_slack()))).collect();
    faces.into_iter().try_fold(Proof::default(), |all, face| Ok(all.and(face?)))
}

/// How far beyond a cell arcs are followed. It is less than the margin by which the baker widens
/// cells, so that its rounding error does not matter, and more than directions are misplaced.
fn cube_slack() -> f64 {
    cube::CELL_SLACK - 1e-10
}

/// The vertices in the lanes of the blocks.
fn lanes(hull: &Hull, blocks: impl IntoIterator<Item = Block>) -> Result<Vec<[u32; LANES]>, Unproven> {
    let mut all = Vec::new();
    for (index, block) in blocks.into_iter().enumerate() {
        for lane in 0..LANES {
            let position = [block.x[lane], block.y[lane], block.z[lane]];
            // Bit by bit: a NaN differs.
            let vertex = hull.vertices.get(block.vertex[lane] as usize);
            if vertex.is_none_or(|vertex| vertex.map(f32::to_bits) != position.map(f32::to_bits)) {
                return Err(Unproven::Lane { block: index, lane });
            }
        }
        all.push(block.vertex);
    }
    Ok(all)
}

/// A hull and its index.
struct Certifier<'a, W: ?Sized> {
    kind: IndexKind,
    words: &'a W,
    lanes: &'a [[u32; LANES]],
    positions: Vec<DVec3>,
    /// For each vertex, where its neighbours start in `neighbours`.
    starts: Vec<u32>,
    neighbours: Vec<u32>,
    diameter: f64,
    /// Maximum of [`Visits::work`].
    work: usize,
}

/// Findings of a descent so far.
#[derive(Default)]
struct Visits {
    proof: Proof,
    /// Number of regions and pieces visited.
    work: usize,
    pending: Vec<descent::Pending>,
}

impl<'a, W: Words + Sync + ?Sized> Certifier<'a, W> {
    fn new(hull: &Hull, kind: IndexKind, words: &'a W, lanes: &'a [[u32; LANES]]) -> Self {
        let lists = hull.neighbours();
        let starts = std::iter::once(0).chain(lists.iter().scan(0, |end, list| {
            *end += list.len() as u32;
            Some(*end)
        }));
        let starts: Vec<u32> = starts.collect();
        let neighbours = lists.concat();
        let size = words.word_count() + lanes.len() * LANES + neighbours.len();
        Self {
            kind,
            words,
            lanes,
            positions: hull.positions(),
            starts,
            neighbours,
            diameter: hull.diameter,
            work: WORK * size,
        }
    }

    /// Proves that every leaf lists every vertex: of a hull without an index, or of a hull without
    /// arcs, which has one or two vertices.
    fn everywhere(&self) -> Result<Proof, Unproven> {
        let per_leaf = if self.kind == IndexKind::None { self.lanes.len().max(1) } else { 1 };
        let direction = DVec3::X;
        let leaves = self.lanes.chunks(per_leaf);
        let proof = Proof { leaves: leaves.len(), ..Proof::default() };
        for leaf in leaves {
            let mut listed = vec![false; self.positions.len()];
            leaf.iter().flatten().for_each(|&vertex| listed[vertex as usize] = true);
            if let Some(vertex) = listed.iter().position(|is_listed| !is_listed) {
                return Err(Unproven::Missing { slot: 0, vertex: vertex as u32, direction });
            }
        }
        Ok(proof)
    }

    /// Proves one face of the cube.
    fn face(&self, face: u32, pieces: Vec<Piece>) -> Result<Proof, Unproven> {
        let mut visits = Visits::default();
        self.descend(face, pieces, &mut visits)?;
        Ok(visits.proof)
    }

    /// Checks a leaf: its candidates in `run`, and the pieces of arcs that cross its region.
    fn leaf(
        &self,
        slot: usize,
        run: std::ops::Range<usize>,
        cell: &Cell,
        pieces: &[Piece],
        visits: &mut Visits,
    ) -> Result<(), Unproven> {
        let candidates = self.lanes.get(run).unwrap_or_default().as_flattened();
        visits.proof.leaves += 1;
        visits.proof.pieces += pieces.len();
        for piece in pieces {
            if let Some(&vertex) = piece.vertices.iter().find(|vertex| !candidates.contains(vertex)) {
                let direction = cell.direction(piece.middle());
                return Err(Unproven::Missing { slot, vertex, direction });
            }
        }
        let regret = match &cell.part {
            // A square of the grid: its widened region contains all directions that lead to it.
            None => 0.0,
            Some(part) => self.beyond_core(candidates, cell, part),
        };
        // NaN takes the failing branch.
        if !(regret <= LIMIT) {
            return Err(Unproven::Thin { slot, bound: regret });
        }
        visits.proof.regret = visits.proof.regret.max(regret);
        if pieces.is_empty()
            && let Some(point) = cell.point()
            && !self.has_support(candidates, cell.direction(point))
        {
            return Err(Unproven::Elsewhere { slot, direction: cell.direction(point) });
        }
        Ok(())
    }

    fn neighbours(&self, vertex: u32) -> &[u32] {
        &self.neighbours[self.starts[vertex as usize] as usize..self.starts[vertex as usize + 1] as usize]
    }

    /// The candidate with the maximum dot product.
    fn best(&self, candidates: &[u32], direction: DVec3) -> u32 {
        let height = |vertex: &u32| self.positions[*vertex as usize].dot(direction);
        candidates.iter().copied().max_by(|a, b| height(a).total_cmp(&height(b))).unwrap_or(0)
    }

    /// Whether a candidate is the support vertex in `direction`: on a convex hull, that is a vertex
    /// of which no neighbour is better.
    fn has_support(&self, candidates: &[u32], direction: DVec3) -> bool {
        // The dot products of two vertices may be equal although one of them is better.
        candidates.iter().any(|&candidate| {
            self.neighbours(candidate).iter().all(|&neighbour| {
                let edge = self.positions[neighbour as usize] - self.positions[candidate as usize];
                edge.dot(direction) <= ON_PLANE * edge.length() * direction.length()
            })
        })
    }

    /// Bound on the regret of these candidates in a region whose core is exact, relative to the
    /// diameter. Spikes beyond the core are cut off and treated as slivers.
    fn beyond_core(&self, candidates: &[u32], cell: &Cell, part: &Part) -> f64 {
        if part.core.is_empty() {
            return self.sliver(candidates, cell, &part.reach);
        }
        let mut reach = part.reach.clone();
        let mut bound: f64 = 0.0;
        // Each cut removes a corner, and leaves two within a rounding error of the core.
        for _ in 0..part.reach.len() {
            let [tip, nearest] = region::farthest(&reach, &part.core);
            let gap = region::between(tip, nearest);
            if gap <= SPIKE {
                return bound.max(gap);
            }
            let (spike, rest) = region::cut_across(&reach, nearest, tip);
            bound = bound.max(self.sliver(candidates, cell, &spike));
            reach = rest;
        }
        let [tip, nearest] = region::farthest(&reach, &part.core);
        bound.max(region::between(tip, nearest))
    }

    /// Bound on the regret of these candidates in a thin region, relative to the diameter.
    ///
    /// Every point of the region is near the segment between its two farthest corners. Along the
    /// segment, the height of the support vertex is a convex function, and that of a candidate is
    /// linear. So a candidate's regret between two points is at most the greater of its regrets
    /// there. Where no candidate's is small at both ends, the segment is halved.
    fn sliver(&self, candidates: &[u32], cell: &Cell, reach: &[[f64; 2]]) -> f64 {
        let (ends, width) = region::axis(reach);
        let ends = ends.map(|end| cell.direction(end));
        width + self.regret_between(candidates, ends, ends.map(|end| self.regrets(candidates, end)))
    }

    fn regret_between(&self, candidates: &[u32], ends: [DVec3; 2], regrets: [Vec<f64>; 2]) -> f64 {
        let least = |regrets: &[f64]| regrets.iter().copied().fold(f64::INFINITY, f64::min);
        let at_both: Vec<f64> = regrets[0].iter().zip(&regrets[1]).map(|(a, b)| a.max(*b)).collect();
        let [at_both, from, to] = [&at_both, &regrets[0], &regrets[1]].map(|regrets| least(regrets));
        let length = ends[0].distance(ends[1]);
        if at_both <= 0.75 * LIMIT || from.max(to) > 0.75 * LIMIT {
            return at_both;
        }
        if length <= 0.25 * LIMIT {
            return from.max(to) + length;
        }
        let middle = 0.5 * (ends[0] + ends[1]);
        let at_middle = self.regrets(candidates, middle);
        let [from, to] = regrets;
        let lower = self.regret_between(candidates, [ends[0], middle], [from, at_middle.clone()]);
        lower.max(self.regret_between(candidates, [middle, ends[1]], [at_middle, to]))
    }

    /// Regret of each candidate in `direction`, relative to the diameter. The support vertex is
    /// found by climbing from the best candidate.
    fn regrets(&self, candidates: &[u32], direction: DVec3) -> Vec<f64> {
        let best = self.best(candidates, direction);
        let height = |vertex: u32| (self.positions[vertex as usize] - self.positions[best as usize]).dot(direction);
        let mut top = best;
        while let Some(next) = self.neighbours(top).iter().copied().max_by(|a, b| height(*a).total_cmp(&height(*b)))
            && height(next) > height(top)
        {
            top = next;
        }
        let scale = direction.length() * self.diameter;
        candidates.iter().map(|candidate| (height(top) - height(*candidate)) / scale).collect()
    }
}

#[cfg(test)]
mod tests;
