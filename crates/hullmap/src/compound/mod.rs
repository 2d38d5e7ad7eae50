//! Geometries with parts: queries by dual-tree traversal of their BVHs. Either side may also be a
//! single shape of any kind.
//!
//! A concave mesh is baked as convex parts, and the pack of its parts is a compound. The parts of a
//! triangle mesh and of a height field are their triangles. The BVHs find the pairs of parts to
//! query. The answers are the same as when every pair is queried. [`CompoundManifolds`] keeps a
//! contact manifold for every pair of parts that touch. Its normals are normals of the union:
//! [`seams`] corrects normals at edges between parts, where bodies would otherwise stumble.
//! [`BodyManifold`] chooses at most eight of all their points.
//!
//! # Complexity
//! A query of compounds with G and H parts compares at most (2 G − 1) (2 H − 1) pairs of boxes, and
//! queries each pair of parts at most once. If few boxes overlap, as on decomposed meshes that
//! touch, that is about log G + log H pairs of boxes for each pair of parts that touch.
//!
//! If all boxes overlap, `contact`, `contacts` and manifolds query all G H pairs, because every
//! pair may be in contact. `intersects` and `distance` end at the first pair that overlaps. If
//! no pair does, `intersects` queries them all. No order of the tests avoids that. Against a
//! single shape the work is at most proportional to G. Bake with fewer parts (`--max-parts`),
//! or with less overlap, if that is too slow.
//!
//! # Reference
//! Dual-tree traversal: Ericson, "Real-Time Collision Detection", 2005, section 6.3; Gottschalk,
//! Lin, Manocha, "OBBTree", 1996. Distance by branch and bound: Larsen et al., "Fast distance
//! queries with rectangular swept sphere volumes", 2000.

#![forbid(unsafe_code)]

mod body_manifold;
pub(crate) mod bvh;
mod carrying;
pub(crate) mod cast_motion;
pub(crate) mod clear;
pub(crate) mod half_space;
mod joined;
mod manifolds;
mod members;
pub(crate) mod motion;
mod near;
mod one_sided;
pub(crate) mod parts;
pub mod seams;
mod shared_sheet;
mod sheet;
pub(crate) mod signed_distance;
mod surface;
mod traversal;
#[cfg(test)]
mod work;

use crate::cascade;
use crate::pose::Pose;
use crate::solver::{Cache, Contact, Distance, Intersection, Overlap, Settings, Status, queries};
pub use body_manifold::{BodyManifold, BodyPoint, MAX_BODY_POINTS};
use bvh::Placement;
pub use joined::{Joined, Tile};
pub use manifolds::{CompoundManifolds, ManifoldCounts};
pub use members::Compound;
pub use one_sided::OneSided;
pub use parts::Parts;
pub use shared_sheet::SharedSheet;
use sheet::CandidatePair;
pub use surface::{SurfaceError, surface_distance};
use traversal::Traversal;

/// Indices of two parts, as answers have them.
fn indices(pair: [usize; 2]) -> [u32; 2] {
    pair.map(|index| index as u32)
}

/// Tests whether `a` and `b`, placed at `b_in_a`, share a point.
///
/// # Complexity
/// Starts with the pair that decided the last query, and ends at the first pair that overlaps.
/// Otherwise all pairs of overlapping boxes, and the pairs of parts in overlapping leaves.
pub(crate) fn intersects<A: Parts + ?Sized, B: Parts + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    cache: &mut Cache,
) -> Intersection {
    let mut best = Intersection { status: Overlap::Separated, ..Intersection::default() };
    let query = |best: &mut Intersection, pair: [usize; 2], cache: &mut Cache| {
        let Some(parts) = CandidatePair::new(a, b, pair, b_in_a) else { return };
        if parts.is_behind() || parts.is_apart(0.0) {
            return;
        }
        let found = cascade::intersects(&parts.a, &parts.b, b_in_a, cache.pair(pair));
        best.iterations += found.iterations;
        best.support_calls += found.support_calls;
        if strength(found.status) >= strength(best.status) {
            (best.status, best.parts) = (found.status, indices(pair));
        }
    };
    let first = cache.first([a.part_count(), b.part_count()]);
    if let Some(pair) = first {
        query(&mut best, pair, cache);
        if best.status == Overlap::Overlapping {
            return best;
        }
    }
    let mut traversal = Traversal::new(Placement::new(a.nodes(), b.nodes(), b_in_a));
    while best.status != Overlap::Overlapping
        && let Some(pair) = traversal.next(0.0)
    {
        if Some(pair) != first {
            query(&mut best, pair, cache);
        }
    }
    if best.is_hit() {
        cache.set_first(best.parts.map(|part| part as usize));
    }
    best
}

/// Rank of the status of a pair. The highest rank is the status of the compounds.
fn strength(status: Overlap) -> u8 {
    match status {
        Overlap::Separated => 0,
        Overlap::Undecided => 1,
        Overlap::Touching => 2,
        Overlap::Overlapping => 3,
    }
}

/// Distance between two geometries; 0 if any pair of parts overlaps.
///
/// # Complexity
/// Branch and bound. Starts with the nearest pair of the last query, and visits only boxes nearer
/// than the nearest pair so far, nearest first.
pub(crate) fn distance<A: Parts + ?Sized, B: Parts + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
) -> Distance {
    let mut search =
        Nearest { a, b, b_in_a, settings, best: None, lower: (f64::INFINITY, Status::Exact), upper: f64::INFINITY };
    let (mut iterations, mut support_calls) = (0, 0);
    let mut query = |search: &mut Nearest<A, B>, pair: [usize; 2], cache: &mut Cache| {
        if let Some(found) = search.query(pair, cache) {
            iterations += found.iterations;
            support_calls += found.support_calls;
        }
    };
    let first = cache.first([a.part_count(), b.part_count()]).unwrap_or([0, 0]);
    query(&mut search, first, cache);
    let mut traversal = Traversal::new(Placement::new(a.nodes(), b.nodes(), b_in_a));
    while search.upper > 0.0
        && let Some(pair) = traversal.next(search.upper)
    {
        if pair != first {
            query(&mut search, pair, cache);
        }
    }
    let (answer, pair) = search.answer();
    cache.set_first(pair);
    Distance { iterations, support_calls, parts: indices(pair), ..answer }
}

/// Branch-and-bound search for the nearest pair.
struct Nearest<'q, A: ?Sized, B: ?Sized> {
    a: &'q A,
    b: &'q B,
    b_in_a: Pose,
    settings: &'q Settings,
    best: Option<(Distance, [usize; 2])>,
    /// Minimum lower bound over all pairs, and the status of that pair.
    lower: (f64, Status),
    /// Minimum upper bound over all pairs.
    upper: f64,
}

impl<A: Parts + ?Sized, B: Parts + ?Sized> Nearest<'_, A, B> {
    fn query(&mut self, pair: [usize; 2], cache: &mut Cache) -> Option<Distance> {
        let CandidatePair { a, b, .. } = CandidatePair::new(self.a, self.b, pair, self.b_in_a)
            .filter(|parts| self.upper == f64::INFINITY || !parts.is_apart(self.upper))?;
        let found = queries::distance(&a, &b, self.b_in_a, self.settings, cache.pair(pair));
        // Overlapping ranks before touching, although both distances are 0.
        let rank = |found: &Distance| (found.distance, found.status != Status::Overlapping);
        if self.best.is_none_or(|(best, _)| rank(&found) < rank(&best)) {
            self.best = Some((found, pair));
        }
        if found.lower < self.lower.0 {
            self.lower = (found.lower, found.status);
        }
        self.upper = self.upper.min(found.upper);
        Some(found)
    }

    fn answer(self) -> (Distance, [usize; 2]) {
        // The first pair of hulls is always queried, and exists in checked packs.
        // Only an unchecked pack can lack hulls.
        let nothing = || (Distance { status: Status::Stalled, ..Distance::default() }, [0, 0]);
        let (mut answer, hulls) = self.best.unwrap_or_else(nothing);
        answer.upper = self.upper;
        if self.lower.0 < answer.lower {
            answer.lower = self.lower.0;
            // NaN takes the failing branch.
            if !(answer.upper - answer.lower <= self.settings.relative_tolerance() * answer.distance) {
                answer.status = self.lower.1;
            }
        }
        (answer, hulls)
    }
}

/// Calls `visit` with the contact of every pair of parts that is not proved separated, and returns
/// the number of contacts and the cost.
///
/// # Complexity
/// All pairs of overlapping boxes, and one contact query for each pair of parts in overlapping
/// leaves.
pub(crate) fn contacts<A: Parts + ?Sized, B: Parts + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
    visit: &mut dyn FnMut(&Contact),
) -> ContactCounts {
    let mut traversal = Traversal::new(Placement::new(a.nodes(), b.nodes(), b_in_a));
    let mut sum = ContactCounts::default();
    while let Some(pair) = traversal.next(0.0) {
        let Some(parts) = CandidatePair::new(a, b, pair, b_in_a) else { continue };
        if parts.is_behind() || parts.is_apart(0.0) {
            continue;
        }
        let found = parts.contact(settings, cache.pair(pair));
        sum.visit(Contact { parts: indices(pair), ..found }, visit);
    }
    sum.boxes = traversal.boxes();
    sum
}

/// Number of contacts that [`contacts`](crate::contacts()) visited, and the cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ContactCounts {
    /// Number of pairs of parts not proved separated: the calls of `visit`.
    pub hits: u32,
    /// Number of pairs of parts queried.
    pub pairs: u32,
    /// Number of pairs of boxes compared.
    pub boxes: u32,
    /// Solver iterations, summed over all pairs of parts.
    pub iterations: u32,
    /// Pairs of support queries, summed over all pairs of parts.
    pub support_calls: u32,
}

impl ContactCounts {
    /// Counts the contact of a pair, and visits it if it is a hit.
    pub(crate) fn visit(&mut self, found: Contact, visit: &mut dyn FnMut(&Contact)) {
        self.pairs += 1;
        self.iterations += found.iterations;
        self.support_calls += found.support_calls;
        if found.hit {
            self.hits += 1;
            visit(&found);
        }
    }
}

/// Contact of the pair of parts with the maximum penetration depth; not a hit if all pairs are
/// proved separated.
pub(crate) fn contact<A: Parts + ?Sized, B: Parts + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
) -> Contact {
    let mut deepest = Contact::SEPARATED_PARTS;
    let (mut depth_lower, mut depth_upper) = (0.0_f64, 0.0_f64);
    let counts = contacts(a, b, b_in_a, settings, cache, &mut |found| {
        (depth_lower, depth_upper) = (depth_lower.max(found.depth_lower), depth_upper.max(found.depth_upper));
        // Ties go to the lowest indices, so that the answer does not depend on the shape of the
        // BVHs.
        let is_as_deep = found.depth == deepest.depth && found.parts < deepest.parts;
        if !deepest.hit || found.depth > deepest.depth || is_as_deep {
            deepest = *found;
        }
    });
    let ContactCounts { iterations, support_calls, .. } = counts;
    Contact { depth_lower, depth_upper, iterations, support_calls, ..deepest }
}
