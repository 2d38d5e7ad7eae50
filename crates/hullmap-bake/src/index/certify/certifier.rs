use std::ops::Range;

use glam::DVec3;
use hullmap_format::{IndexKind, archive::LANES, node::Words};

use super::arcs::Piece;
use super::proof::Proof;
use super::region::{self, Cell, Outline};
use crate::error::{REGRET_LIMIT, Unproven};
use crate::hull::{Hull, adjacency::Adjacency};

/// Length from which a spike of a region beyond its core is treated as a sliver.
const SPIKE: f64 = 0.1 * REGRET_LIMIT;

/// Maximum number of regions and pieces of arcs visited on a face of the cube, in multiples of the
/// index's words, the blocks' lanes and the hull's edges together. Indices of all families visit at
/// most a tenth of it; a hostile index, whose nodes are shared, is given up.
const WORK: usize = 64;

/// How far beyond the plane between two cones a point may lie to count as a point of the cone:
/// rounding error, relative to the lengths of the edge and of the direction.
const ON_PLANE: f64 = 1e-15;

pub struct Certifier<'a, W: ?Sized> {
    pub kind: IndexKind,
    pub words: &'a W,
    lanes: &'a [[u32; LANES]],
    positions: Vec<DVec3>,
    adjacency: Adjacency,
    diameter: f64,
    pub work: usize,
}

impl<'a, W: Words + Sync + ?Sized> Certifier<'a, W> {
    pub fn new(hull: &Hull, kind: IndexKind, words: &'a W, lanes: &'a [[u32; LANES]]) -> Self {
        let adjacency = Adjacency::new(hull);
        let size = words.word_count() + lanes.len() * LANES + adjacency.neighbours.len();
        Self { kind, words, lanes, positions: hull.positions(), adjacency, diameter: hull.diameter, work: WORK * size }
    }

    /// Proves that every leaf lists every vertex: of a hull without an index, or of a hull without
    /// arcs, which has one or two vertices.
    pub fn everywhere(&self) -> Result<Proof, Unproven> {
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

    /// Checks a leaf: its candidates in `run`, and the pieces of arcs that cross its region.
    pub fn leaf(
        &self,
        slot: usize,
        run: Range<usize>,
        cell: &Cell,
        pieces: &[Piece],
        proof: &mut Proof,
    ) -> Result<(), Unproven> {
        let candidates = self.lanes.get(run).unwrap_or_default().as_flattened();
        proof.leaves += 1;
        proof.pieces += pieces.len();
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
        if !(regret <= REGRET_LIMIT) {
            return Err(Unproven::Thin { slot, bound: regret });
        }
        proof.regret = proof.regret.max(regret);
        if pieces.is_empty()
            && let Some(point) = cell.point()
            && !self.has_support(candidates, cell.direction(point))
        {
            return Err(Unproven::Elsewhere { slot, direction: cell.direction(point) });
        }
        Ok(())
    }

    fn best(&self, candidates: &[u32], direction: DVec3) -> u32 {
        let height = |vertex: &u32| self.positions[*vertex as usize].dot(direction);
        candidates.iter().copied().max_by(|a, b| height(a).total_cmp(&height(b))).unwrap_or(0)
    }

    /// Whether a candidate is the support vertex in `direction`: on a convex hull, that is a vertex
    /// without a better neighbour.
    fn has_support(&self, candidates: &[u32], direction: DVec3) -> bool {
        // The dot products of two vertices may be equal although one of them is better.
        candidates.iter().any(|&candidate| {
            self.adjacency.neighbours(candidate).iter().all(|&neighbour| {
                let edge = self.positions[neighbour as usize] - self.positions[candidate as usize];
                edge.dot(direction) <= ON_PLANE * edge.length() * direction.length()
            })
        })
    }

    /// Bound on the regret of these candidates in a region whose core is exact, relative to the
    /// diameter. Spikes beyond the core are cut off and treated as slivers.
    fn beyond_core(&self, candidates: &[u32], cell: &Cell, part: &Outline) -> f64 {
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
    /// segment, the height of the support vertex is a convex function, and the height of a
    /// candidate is linear. So a candidate's regret between two points is at most the greater of
    /// its regrets there. If no candidate has a small regret at both ends, the segment is halved.
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
        if at_both <= 0.75 * REGRET_LIMIT || from.max(to) > 0.75 * REGRET_LIMIT {
            return at_both;
        }
        if length <= 0.25 * REGRET_LIMIT {
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
        while let Some(next) =
            self.adjacency.neighbours(top).iter().copied().max_by(|a, b| height(*a).total_cmp(&height(*b)))
            && height(next) > height(top)
        {
            top = next;
        }
        let scale = direction.length() * self.diameter;
        candidates.iter().map(|candidate| (height(top) - height(*candidate)) / scale).collect()
    }
}
