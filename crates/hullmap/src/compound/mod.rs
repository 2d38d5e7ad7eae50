//! Compound shapes: queries between the unions of the hulls of two packs, by dual-tree traversal of
//! their BVHs. Either side may also be a single shape of any kind.
//!
//! A concave mesh is baked as convex parts, and the pack of its parts is a compound shape. The BVHs
//! in the packs find the pairs of hulls to query. The answers are the same as when every pair is
//! queried. [`CompoundManifolds`] keeps a contact manifold for every pair of parts that touch. Its
//! normals are normals of the union: [`seams`] corrects normals at edges between parts, where
//! bodies would otherwise stumble. [`BodyManifold`] chooses at most eight of all their points.
//!
//! # Complexity
//! A query of compounds with G and H parts compares at most (2 G − 1) (2 H − 1) pairs of boxes, and
//! queries each pair of parts at most once. If few boxes overlap, as on decomposed meshes that
//! touch, that is about log G + log H pairs of boxes for each pair of parts that touch.
//!
//! If all boxes overlap, [`contact`], [`contacts`] and manifolds query all G H pairs, because every
//! pair may be in contact. [`intersects`] and [`distance`] end at the first pair that overlaps. If
//! no pair does, [`intersects`] queries them all. No order of the tests avoids that. Against a
//! single shape the work is at most proportional to G. Bake with fewer parts (`--max-parts`),
//! or with less overlap, if that is too slow.
//!
//! # Examples
//! A pack of two unit cubes, 3 apart, against a copy of itself:
//! ```
//! # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let pack = two_cubes();
//! use hullmap::glam::DVec3;
//! use hullmap::{Compound, CompoundCache, Pose, Settings, compound};
//!
//! let cubes = Compound::new(&pack);
//! let b_in_a = Pose::from_translation(DVec3::new(3.25, 0.125, 0.0))?;
//! let mut cache = CompoundCache::default();
//! let deepest = compound::contact(&cubes, &cubes, b_in_a, &Settings::default(), &mut cache)
//!     .ok_or("no contact")?;
//! assert_eq!(deepest.hulls, [1, 0]);
//! assert!((deepest.answer.depth - 0.75).abs() < 1e-9);
//! # Ok(())
//! # }
//! ```
//!
//! # Reference
//! Dual-tree traversal: Ericson, "Real-Time Collision Detection", 2005, section 6.3; Gottschalk,
//! Lin, Manocha, "OBBTree", 1996. Distance by branch and bound: Larsen et al., "Fast distance
//! queries with rectangular swept sphere volumes", 2000.

#![forbid(unsafe_code)]

mod body_manifold;
mod bvh;
mod cache;
mod cast_motion;
mod clear;
pub mod half_space;
mod joined;
mod manifolds;
mod members;
mod motion;
mod near;
mod one_sided;
mod parts;
pub mod seams;
mod shared_sheet;
mod sheet;
mod signed_distance;
mod surface;
mod traversal;

use crate::cascade::{self, Stages};
use crate::pose::Pose;
use crate::solver::{Contact, Distance, Intersection, Overlap, Settings, Status, queries};
pub use body_manifold::{BodyManifold, BodyPoint, MAX_BODY_POINTS};
use bvh::Placement;
pub use cache::CompoundCache;
pub use cast_motion::cast_motion;
pub use clear::clear;
pub use joined::{Joined, Tile};
pub use manifolds::{CompoundManifolds, ManifoldCounts};
pub use members::Compound;
pub use motion::{cast, ray};
pub use one_sided::OneSided;
pub use parts::Parts;
pub use shared_sheet::SharedSheet;
use sheet::CandidatePair;
pub use signed_distance::signed_distance;
pub use surface::{SurfaceError, surface_distance};
use traversal::Traversal;

/// Distance for a pack without hulls, which only an unchecked pack can be: nothing is known.
const NOTHING_KNOWN: Distance = Distance {
    status: Status::Stalled,
    distance: 0.0,
    lower: 0.0,
    upper: f64::INFINITY,
    normal: glam::DVec3::X,
    point_a: glam::DVec3::ZERO,
    point_b: glam::DVec3::ZERO,
    iterations: 0,
    support_calls: 0,
    features: [u32::MAX; 2],
};

/// Answer of a query of compounds. See the [module's example](self).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CompoundAnswer<T> {
    /// Answer for the pair of hulls that decided the query. Its iterations and support calls are
    /// the sums over all pairs.
    pub answer: T,
    /// Indices of these hulls in A and in B; 0 on the side of a single shape.
    pub hulls: [usize; 2],
    /// Number of pairs of hulls queried. Triangles that an axis rules out do not count.
    pub pairs: u32,
    /// Number of pairs of boxes compared.
    pub boxes: u32,
}

/// Tests whether `a` and `b`, placed at `b_in_a`, share a point.
///
/// The status is the strongest over all pairs of hulls: overlapping, then touching, then undecided,
/// then separated. `hulls` is a pair with that status. If all are separated, it is the last pair
/// queried, or the first two hulls if no pair was queried.
///
/// `cache` belongs to this ordered pair of compounds; the query reads and updates it.
///
/// # Complexity
/// Starts with the pair that decided the last query, and ends at the first pair that overlaps.
/// Separated compounds cost all pairs of overlapping boxes, and the pairs of hulls in overlapping
/// leaves: at most G H pairs of hulls for compounds of G and H. No allocation.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::glam::DVec3;
/// use hullmap::{Compound, CompoundCache, Overlap, Pose, compound};
///
/// let cubes = Compound::new(&pack);
/// let mut cache = CompoundCache::default();
/// // B's left cube fits into the gap between A's cubes.
/// let between = Pose::from_translation(DVec3::new(1.5, 0.0, 0.0))?;
/// let found = compound::intersects(&cubes, &cubes, between, &mut cache);
/// assert_eq!(found.answer.status, Overlap::Separated);
/// # Ok(())
/// # }
/// ```
pub fn intersects<A: Parts + ?Sized, B: Parts + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    cache: &mut CompoundCache,
) -> CompoundAnswer<Intersection> {
    let answer = Intersection { status: Overlap::Separated, iterations: 0, support_calls: 0 };
    let mut best = CompoundAnswer { answer, hulls: [0, 0], pairs: 0, boxes: 0 };
    let query = |best: &mut CompoundAnswer<Intersection>, pair: [usize; 2], cache: &mut CompoundCache| {
        let found = if let (Some(a), Some(b)) = (a.part_as_hull(pair[0]), b.part_as_hull(pair[1])) {
            cascade::intersects(&a, &b, b_in_a, Stages::default(), cache.pair(pair)).intersection
        } else if let Some(parts) =
            CandidatePair::new(a, b, pair, b_in_a).filter(|parts| !parts.is_behind() && !parts.is_apart(0.0))
        {
            queries::intersects(&parts.a, &parts.b, b_in_a, cache.pair(pair))
        } else {
            return;
        };
        best.pairs += 1;
        best.answer.iterations += found.iterations;
        best.answer.support_calls += found.support_calls;
        if strength(found.status) >= strength(best.answer.status) {
            (best.answer.status, best.hulls) = (found.status, pair);
        }
    };
    let first = cache.first([a.part_count(), b.part_count()]);
    if let Some(pair) = first {
        query(&mut best, pair, cache);
        if best.answer.status == Overlap::Overlapping {
            return best;
        }
    }
    let mut traversal = Traversal::new(Placement::new(a.nodes(), b.nodes(), b_in_a));
    while let Some(pair) = traversal.next(0.0) {
        if Some(pair) == first {
            continue;
        }
        query(&mut best, pair, cache);
        if best.answer.status == Overlap::Overlapping {
            break;
        }
    }
    best.boxes = traversal.boxes();
    if best.answer.is_hit() {
        cache.set_first(best.hulls);
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

/// Distance between two compounds; 0 if any pair of hulls overlaps.
///
/// Points, normal and distance belong to the nearest pair. The interval contains the distance of
/// the compounds: no pair is nearer than `lower`, and the distance of some pair is at most `upper`.
/// The status is the status of the nearest pair, unless another pair's interval makes the whole
/// wider than the settings allow. Then it is the status of that other pair.
///
/// `cache` belongs to this ordered pair of compounds; the query reads and updates it.
///
/// # Complexity
/// Branch and bound. Starts with the nearest pair of the last query, and visits only boxes nearer
/// than the nearest pair so far, nearest first: at most G H pairs of hulls for compounds of G and
/// H. No allocation.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::glam::DVec3;
/// use hullmap::{Compound, CompoundCache, Pose, Settings, compound};
///
/// let cubes = Compound::new(&pack);
/// let mut cache = CompoundCache::default();
/// let b_in_a = Pose::from_translation(DVec3::new(6.0, 0.0, 0.0))?;
/// let gap = compound::distance(&cubes, &cubes, b_in_a, &Settings::default(), &mut cache);
/// // A's right cube and B's left cube.
/// assert_eq!(gap.hulls, [1, 0]);
/// assert!((gap.answer.distance - 2.0).abs() < 1e-12);
/// # Ok(())
/// # }
/// ```
pub fn distance<A: Parts + ?Sized, B: Parts + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut CompoundCache,
) -> CompoundAnswer<Distance> {
    let mut search =
        Nearest { a, b, b_in_a, settings, best: None, lower: (f64::INFINITY, Status::Exact), upper: f64::INFINITY };
    let (mut pairs, mut iterations, mut support_calls) = (0, 0, 0);
    let mut query = |search: &mut Nearest<A, B>, pair: [usize; 2], cache: &mut CompoundCache| {
        if let Some(found) = search.query(pair, cache) {
            pairs += 1;
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
    let (mut answer, hulls) = search.answer();
    (answer.iterations, answer.support_calls) = (iterations, support_calls);
    cache.set_first(hulls);
    CompoundAnswer { answer, hulls, pairs, boxes: traversal.boxes() }
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
    fn query(&mut self, pair: [usize; 2], cache: &mut CompoundCache) -> Option<Distance> {
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
        let (mut answer, hulls) = self.best.unwrap_or((NOTHING_KNOWN, [0, 0]));
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

/// Calls `visit` with the contact of every pair of hulls that is not proved separated.
///
/// `visit` receives the indices of the hulls in A and in B, and their
/// [`contact`](crate::contact()). The order follows the traversal, and is the same for the same
/// input. Returns the number of contacts and the cost.
///
/// `cache` belongs to this ordered pair of compounds; the query reads and updates it.
///
/// # Complexity
/// All pairs of overlapping boxes, and one contact query for each pair of hulls in overlapping
/// leaves: G H of them if all overlap, for compounds of G and H hulls. No allocation.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::glam::DVec3;
/// use hullmap::{Compound, CompoundCache, Pose, Settings, compound};
///
/// let cubes = Compound::new(&pack);
/// let mut cache = CompoundCache::default();
/// let above = Pose::from_translation(DVec3::new(0.0, 0.0, 0.875))?;
/// let mut depths = Vec::new();
/// let visit = |_: [usize; 2], contact: &hullmap::Contact| depths.push(contact.depth);
/// let counts = compound::contacts(&cubes, &cubes, above, &Settings::default(), &mut cache, visit);
/// assert_eq!(counts.hits, 2);
/// assert!(depths.iter().all(|depth| (depth - 0.125).abs() < 1e-12));
/// # Ok(())
/// # }
/// ```
pub fn contacts<A: Parts + ?Sized, B: Parts + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut CompoundCache,
    mut visit: impl FnMut([usize; 2], &Contact),
) -> ContactCounts {
    let mut traversal = Traversal::new(Placement::new(a.nodes(), b.nodes(), b_in_a));
    let mut sum = ContactCounts::default();
    while let Some(pair) = traversal.next(0.0) {
        let Some(parts) = CandidatePair::new(a, b, pair, b_in_a) else { continue };
        if parts.is_behind() || parts.is_apart(0.0) {
            continue;
        }
        let found = parts.contact(settings, cache.pair(pair));
        sum.pairs += 1;
        sum.iterations += found.iterations;
        sum.support_calls += found.support_calls;
        if found.hit {
            sum.hits += 1;
            visit(pair, &found);
        }
    }
    sum.boxes = traversal.boxes();
    sum
}

/// Number of contacts that [`contacts`] visited, and the cost. See the example there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ContactCounts {
    /// Number of pairs of hulls not proved separated: the calls of `visit`.
    pub hits: u32,
    /// Number of pairs of hulls queried.
    pub pairs: u32,
    /// Number of pairs of boxes compared.
    pub boxes: u32,
    /// Solver iterations, summed over all pairs of hulls.
    pub iterations: u32,
    /// Pairs of support queries, summed over all pairs of hulls.
    pub support_calls: u32,
}

/// Contact of the pair of hulls with the maximum penetration depth; `None` if all pairs are proved
/// separated.
///
/// The interval contains the maximum depth of any pair: `depth_lower` is the maximum lower bound
/// over all pairs, `depth_upper` the maximum upper bound. Moving B by less than `depth_lower` in
/// any direction leaves the compounds overlapping. Moving it by `depth_upper` along `normal`
/// separates this pair; other pairs may still overlap then, or begin to.
///
/// `cache` belongs to this ordered pair of compounds; the query reads and updates it.
///
/// # Complexity
/// As [`contacts`].
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::glam::DVec3;
/// use hullmap::{Compound, CompoundCache, Pose, Settings, compound};
///
/// let cubes = Compound::new(&pack);
/// let mut cache = CompoundCache::default();
/// let above = Pose::from_translation(DVec3::new(0.0, 0.0, 0.75))?;
/// let deepest = compound::contact(&cubes, &cubes, above, &Settings::default(), &mut cache)
///     .ok_or("no contact")?;
/// assert!((deepest.answer.depth - 0.25).abs() < 1e-12);
/// assert_eq!(deepest.answer.normal, DVec3::Z);
///
/// let far = Pose::from_translation(DVec3::new(0.0, 0.0, 9.0))?;
/// assert!(compound::contact(&cubes, &cubes, far, &Settings::default(), &mut cache).is_none());
/// # Ok(())
/// # }
/// ```
pub fn contact<A: Parts + ?Sized, B: Parts + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut CompoundCache,
) -> Option<CompoundAnswer<Contact>> {
    let mut deepest: Option<(Contact, [usize; 2])> = None;
    let (mut lower, mut upper) = (0.0_f64, 0.0_f64);
    let sum = contacts(a, b, b_in_a, settings, cache, |pair, found| {
        (lower, upper) = (lower.max(found.depth_lower), upper.max(found.depth_upper));
        // Ties go to the lowest indices, so that the answer does not depend on the shape of the
        // BVHs.
        let is_deeper =
            deepest.is_none_or(|(best, hulls)| found.depth > best.depth || found.depth == best.depth && pair < hulls);
        if is_deeper {
            deepest = Some((*found, pair));
        }
    });
    let (answer, hulls) = deepest?;
    let (iterations, support_calls) = (sum.iterations, sum.support_calls);
    let answer = Contact { depth_lower: lower, depth_upper: upper, iterations, support_calls, ..answer };
    Some(CompoundAnswer { answer, hulls, pairs: sum.pairs, boxes: sum.boxes })
}
