//! Mergers of parts, cheapest first, at one limit after the other.
//!
//! # Steps
//! 1. For each pair of parts near each other, keep the volume that a merger adds, and the distance
//!    of the farthest known point in the hull of both. The pair *waits* until the limit reaches it.
//! 2. Take the cheapest pair that does not wait. Merge it if the hull of both is proven, and if all
//!    parts together overlap little enough. Otherwise, it waits for a greater limit.
//! 3. At a greater limit, go on. So the number of parts only falls, and pairs whose point is still
//!    too far cost nothing.
//!
//! # Overlap
//! The sum of the parts' volumes exceeds the volume of their union by at most the sum of what each
//! pair has in common, since a point in k parts is in k (k - 1) / 2 pairs. The union contains that
//! of the parts before mergers, whose volume is bounded in the same way. The quotient of both bounds
//! the overlap, apart from the error of the common volumes, which are estimated by points.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::{body::Body, context::Search, piece::Piece, shape::Part};
use crate::{fit::planes::HalfSpace, spread::spread};

/// Number of points by which the common volume of two bodies is estimated.
const COMMON_POINTS: usize = 512;

/// Number of parts above which none are merged: the time grows with its square.
const MANY: usize = 1024;

/// Number of parts up to which parts that are far from each other are merged, too: across others.
const FEW: usize = 48;

/// Number of mergers that may fail to be proven at one limit, in addition to one for each part.
const FAILURES: usize = 16;

/// Maximum number of points by which mergers are tested.
const MAX_FORBIDDEN: usize = 20_000;

/// Distance from a plane up to which a point counts as on it, relative to the body's diagonal.
const ON_PLANE: f64 = 1e-9;

/// A point, and its distance from the solid.
type Far = (f64, DVec3);

/// A merger of two parts. Its hull is built again where it is needed, since there are many.
#[derive(Clone, Copy, Debug)]
struct Merger {
    /// The volume that it adds.
    cost: f64,
    /// Distance from the solid that the hull of both is known to reach.
    waits: f64,
}

/// Parts that are being merged.
#[derive(Clone, Debug)]
pub struct Join {
    /// The parts by their indices; `None` for those that were merged.
    parts: Vec<Option<Part>>,
    count: usize,
    mergers: BTreeMap<(usize, usize), Merger>,
    /// Points that are too far from the solid, the farthest first.
    forbidden: Vec<Far>,
    /// The volumes that parts have in common, where they have any.
    common: BTreeMap<(usize, usize), f64>,
    /// A lower bound on the volume of the union.
    union: f64,
    /// Greatest index that was paired with all before it, and whether far ones were.
    paired: (usize, bool),
}

impl Join {
    /// Parts that are not merged yet, and points that no part may contain.
    ///
    /// # Complexity
    /// O(n²) comparisons of boxes for n parts, and an estimate for each pair whose boxes overlap.
    pub fn new(search: &Search, parts: Vec<Part>, forbidden: &[DVec3]) -> Self {
        let count = parts.len();
        let volumes: Vec<f64> = parts.iter().map(|part| part.piece.body.volume()).collect();
        let mut join = Self {
            parts: parts.into_iter().map(Some).collect(),
            count,
            mergers: BTreeMap::new(),
            forbidden: Vec::new(),
            common: BTreeMap::new(),
            union: 0.0,
            paired: (0, false),
        };
        if count > MANY {
            return join;
        }
        join.forbid(search, forbidden);
        let of_part = |j: usize| {
            if search.is_over() {
                return Vec::new();
            }
            let with = |i: usize| Some(((i, j), join.common_volume(i, &join.parts[j].as_ref()?.piece)));
            (0..j).filter_map(with).filter(|(_, volume)| *volume > 0.0).collect::<Vec<_>>()
        };
        let common: Vec<_> = (0..count).into_par_iter().map(of_part).collect();
        join.common = common.into_iter().flatten().collect();
        let largest = volumes.iter().copied().fold(0.0, f64::max);
        join.union = (volumes.iter().sum::<f64>() - join.common.values().sum::<f64>()).max(largest);
        join
    }

    /// The number of parts.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The parts.
    pub fn parts(&self) -> impl Iterator<Item = &Part> {
        self.parts.iter().flatten()
    }

    /// Merges parts as long as merged parts are within the limit of `search`, and all parts overlap
    /// by at most `overlap` of the volume of their union, or not more than before. Ends with
    /// `wanted` parts.
    ///
    /// # Complexity
    /// A hull for each new pair of parts near each other, and one for each pair that no longer
    /// waits. The number of proofs is limited.
    pub fn merge(&mut self, search: &Search, overlap: f64, wanted: usize) {
        let limit = search.scale.limit;
        let allowed = overlap * self.union;
        let mut failures = FAILURES + self.count;
        self.forbidden.retain(|(distance, _)| *distance > limit);
        // More pairs are near each other at a greater limit.
        self.paired.0 = 0;
        while self.count <= MANY && self.count > wanted && failures > 0 && !search.is_over() {
            self.pair(search);
            let possible = self.mergers.iter().filter(|(_, merger)| merger.waits <= limit);
            let cheapest = possible.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost).then(a.0.cmp(b.0)));
            let Some(pair) = cheapest.map(|(pair, _)| *pair) else { break };
            if let Err(tried) = self.merged(search, pair, allowed) {
                failures -= usize::from(tried.is_unproven);
                self.wait(pair, tried.waits.max(limit.next_up()));
            }
        }
    }

    /// Merges two parts.
    fn merged(&mut self, search: &Search, pair: (usize, usize), allowed: f64) -> Result<(), Refused> {
        let refused = |waits: f64| Refused { waits, is_unproven: false };
        let [Some(a), Some(b)] = [pair.0, pair.1].map(|i| self.parts[i].as_ref()) else { return Err(refused(0.0)) };
        let body = hull_of_both(search, a, b);
        if let Some((distance, _)) = self.forbidden_in(search, &body) {
            return Err(refused(distance));
        }
        let piece = united(search, &a.piece, &b.piece, body);
        let is_of_pair = |(i, j): &(usize, usize)| [i, j].iter().any(|k| **k == pair.0 || **k == pair.1);
        let common: Vec<(usize, f64)> = (0..self.parts.len())
            .filter(|k| *k != pair.0 && *k != pair.1)
            .map(|k| (k, self.common_volume(k, &piece)))
            .filter(|(_, volume)| *volume > 0.0)
            .collect();
        let before: f64 = self.common.values().sum();
        let gone: f64 = self.common.iter().filter(|(pair, _)| is_of_pair(pair)).map(|(_, volume)| volume).sum();
        let after = before - gone + common.iter().map(|(_, volume)| volume).sum::<f64>();
        if after > allowed.max(before) {
            return Err(refused(0.0));
        }
        let beyond = search.points_beyond(&piece.body);
        if !beyond.is_empty() {
            return Err(refused(self.forbid(search, &beyond)));
        }
        let part = match search.shaped(&piece) {
            Ok(part) => part,
            Err(point) => {
                let points: Vec<DVec3> = point.into_iter().collect();
                return Err(Refused { waits: self.forbid(search, &points), is_unproven: true });
            }
        };
        let index = self.parts.len();
        self.common.retain(|pair, _| !is_of_pair(pair));
        self.common.extend(common.into_iter().map(|(k, volume)| ((k, index), volume)));
        self.mergers.retain(|pair, _| !is_of_pair(pair));
        (self.parts[pair.0], self.parts[pair.1]) = (None, None);
        self.parts.push(Some(part));
        self.count -= 1;
        Ok(())
    }

    /// Adds the pairs of parts that are near each other and not known yet.
    fn pair(&mut self, search: &Search) {
        let is_few = self.count <= FEW;
        let first = if is_few && !self.paired.1 { 0 } else { self.paired.0 };
        let gap = DVec3::splat(if is_few { f64::INFINITY } else { search.scale.limit });
        let bodies: Vec<(usize, &Body)> =
            self.parts.iter().enumerate().filter_map(|(i, part)| Some((i, &part.as_ref()?.piece.body))).collect();
        let is_near = |a: &Body, b: &Body| a.low.cmple(b.high + gap).all() && b.low.cmple(a.high + gap).all();
        let mut pairs = Vec::new();
        for (k, (j, b)) in bodies.iter().enumerate().filter(|(_, (j, _))| *j >= first) {
            let near = bodies[..k].iter().filter(|(_, a)| is_near(a, b)).map(|(i, _)| (*i, *j));
            pairs.extend(near.filter(|pair| !self.mergers.contains_key(pair)));
        }
        let merger = |(i, j): (usize, usize)| {
            let (a, b) = (self.parts[i].as_ref()?, self.parts[j].as_ref().filter(|_| !search.is_over())?);
            let body = hull_of_both(search, a, b);
            let waits = self.forbidden_in(search, &body).map_or(0.0, |(distance, _)| distance);
            Some(((i, j), Merger { cost: body.volume() - a.piece.body.volume() - b.piece.body.volume(), waits }))
        };
        let new: Vec<_> = pairs.into_par_iter().filter_map(merger).collect();
        self.mergers.extend(new);
        self.paired = (self.parts.len(), is_few);
    }

    fn wait(&mut self, pair: (usize, usize), distance: f64) {
        if let Some(merger) = self.mergers.get_mut(&pair) {
            merger.waits = distance;
        }
    }

    /// The farthest of the forbidden points in a body.
    fn forbidden_in(&self, search: &Search, body: &Body) -> Option<Far> {
        self.forbidden.iter().copied().find(|(_, p)| search.scale.is_inside(body, *p))
    }

    /// Adds points that no part may contain, and returns the distance of the farthest one.
    fn forbid(&mut self, search: &Search, points: &[DVec3]) -> f64 {
        let solid = search.field.solid();
        let far: Vec<Far> = points.par_iter().map(|p| (solid.distance(*p), *p)).collect();
        let farthest = far.iter().map(|(distance, _)| *distance).fold(0.0, f64::max);
        self.forbidden.extend(far);
        self.forbidden.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.forbidden.truncate(MAX_FORBIDDEN);
        farthest
    }

    /// The volume that a part has in common with a piece, from the share of evenly spread points.
    fn common_volume(&self, index: usize, piece: &Piece) -> f64 {
        let Some(part) = &self.parts[index] else { return 0.0 };
        let (a, b) = (&part.piece.body, &piece.body);
        let (low, high) = (a.low.max(b.low), a.high.min(b.high));
        let size = high - low;
        if size.min_element() <= 0.0 || is_divided(&part.piece, piece) || is_divided(piece, &part.piece) {
            return 0.0;
        }
        let points = (0..COMMON_POINTS).map(|k| low + size * DVec3::from_array(spread(k)));
        let share = points.filter(|p| a.holds(*p, 0.0) && b.holds(*p, 0.0)).count() as f64 / COMMON_POINTS as f64;
        share * size.x * size.y * size.z
    }
}

/// Why two parts were not merged.
struct Refused {
    /// Distance from the solid that their hull is known to reach; 0 if none is known.
    waits: f64,
    is_unproven: bool,
}

/// The hull of two parts' surfaces.
fn hull_of_both(search: &Search, a: &Part, b: &Part) -> Body {
    search.scale.body(&[a.piece.body.points.as_slice(), &b.piece.body.points].concat())
}

/// The union of two pieces, whose hull is `body`.
fn united(search: &Search, a: &Piece, b: &Piece, body: Body) -> Piece {
    let holds = |plane: &&HalfSpace| body.points.iter().all(|p| plane.height(*p) <= search.scale.tolerance());
    let planes = a.planes.iter().chain(&b.planes).filter(holds).copied().collect();
    Piece { atoms: [a.atoms.as_slice(), &b.atoms].concat(), body, planes, forbidden: Vec::new() }
}

/// Whether a plane that bounds a piece has another one on its other side.
fn is_divided(a: &Piece, b: &Piece) -> bool {
    let slack = ON_PLANE * b.body.diagonal();
    a.planes.iter().any(|plane| b.body.points.iter().all(|p| plane.height(*p) >= -slack))
}
