//! Queries between whole packs: the union of a pack's hulls against the union of another's, or against one hull.
//!
//! A concave mesh is baked as convex parts; together they are a compound shape. Which pairs of hulls are looked at is found by the
//! trees of boxes that packs hold; the answers are those of all pairs.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let part = |name: &str, x: f32| hullmap_bake::PointSet {
//! #     name: name.into(),
//! #     positions: (0..8).map(|i| [x + (i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32]).collect(),
//! #     source_vertices: (0..8).collect(),
//! #     ..Default::default()
//! # };
//! # let bake = |set| hullmap_bake::bake_hull(&set, hullmap_bake::IndexKind::TREE);
//! # let hulls = [bake(part("left", 0.0))?, bake(part("right", 3.0))?];
//! # let pack = hullmap::Pack::from_bytes(&hullmap_bake::write_pack(&hulls, &Default::default())?)?;
//! use hullmap::glam::DVec3;
//! use hullmap::{Compound, CompoundCache, Pose, Settings, compound};
//!
//! let table = Compound::new(&pack);
//! let b_in_a = Pose::from_translation(DVec3::new(3.25, 0.125, 0.0))?;
//! let mut cache = CompoundCache::default();
//! let deepest = compound::contact(&table, &table, b_in_a, &Settings::default(), &mut cache).ok_or("apart")?;
//! println!("hulls {:?} are {:.3} deep in each other", deepest.hulls, deepest.answer.depth);
//! # assert_eq!(deepest.hulls, [1, 0]);
//! # assert!((deepest.answer.depth - 0.75).abs() < 1e-9);
//! # Ok(())
//! # }
//! ```
//!
//! # Reference
//! Ericson, "Real-Time Collision Detection", 2005, chapter 6.3 (two trees descended together); Gottschalk, Lin, Manocha, "OBBTree",
//! 1996. Distance by branch and bound: Larsen et al., "Fast distance queries with rectangular swept sphere volumes", 2000.

#![forbid(unsafe_code)]

mod boxes;
mod cache;
mod descent;

use crate::levels::{self, Levels};
use crate::{Contact, Distance, Hull, Intersection, Overlap, Pack, Pose, Settings, Status};
use boxes::Placement;
pub use cache::CompoundCache;
use descent::Descent;

/// Hulls as one shape: their union. Copying it copies a reference, or a hull.
#[derive(Clone, Copy, Debug)]
pub struct Compound<'a> {
    members: Members<'a>,
}

#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "a hull is some slices; behind a pointer it would need an owner")]
enum Members<'a> {
    Pack(&'a Pack),
    One(Hull<'a>),
}

impl<'a> Compound<'a> {
    /// All hulls of `pack`. They share its frame.
    pub fn new(pack: &'a Pack) -> Self {
        Self { members: Members::Pack(pack) }
    }

    /// Number of hulls, at least 1.
    pub fn hull_count(&self) -> usize {
        match self.members {
            Members::Pack(pack) => pack.hull_count(),
            Members::One(_) => 1,
        }
    }

    /// Number of boxes in its tree.
    fn node_count(&self) -> usize {
        match self.members {
            Members::Pack(pack) => pack.nodes().len(),
            Members::One(_) => 1,
        }
    }

    /// Hull number `index`, counted from 0; `None` past the last one.
    pub fn hull(&self, index: usize) -> Option<Hull<'a>> {
        match self.members {
            Members::Pack(pack) => pack.hull(index).ok(),
            Members::One(hull) => (index == 0).then_some(hull),
        }
    }
}

impl<'a> From<Hull<'a>> for Compound<'a> {
    /// One hull, as a compound of nothing else.
    fn from(hull: Hull<'a>) -> Self {
        Self { members: Members::One(hull) }
    }
}

impl<'a> From<&'a Pack> for Compound<'a> {
    fn from(pack: &'a Pack) -> Self {
        Self::new(pack)
    }
}

/// Distance of packs that were opened unchecked, and turn out to have no hulls.
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
};

/// Answer of a query between compounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compounded<T> {
    /// That of the pair of hulls that decides. Iterations and support calls are those of all pairs.
    pub answer: T,
    /// Number of that hull in A, and in B.
    pub hulls: [usize; 2],
    /// Pairs of hulls that were asked.
    pub pairs: u32,
    /// Pairs of boxes that were compared.
    pub boxes: u32,
}

/// Whether any hull of `a` and any of `b`, placed at `b_in_a`, share a point.
///
/// The status is the strongest of all pairs': overlapping before touching before undecided before separated. The pair is one
/// that has it; of compounds apart, the pair asked last, or the first hulls where none was.
///
/// `cache` belongs to this ordered pair of compounds; it is read and brought up to date.
///
/// # Complexity
/// Ends at the first pair that overlaps, and begins with the one of last time. Apart: pairs of boxes that overlap, and the pairs of
/// hulls in them. No allocation.
pub fn intersects(a: &Compound, b: &Compound, b_in_a: Pose, cache: &mut CompoundCache) -> Compounded<Intersection> {
    let answer = Intersection { status: Overlap::Separated, iterations: 0, support_calls: 0 };
    let mut best = Compounded { answer, hulls: [0, 0], pairs: 0, boxes: 0 };
    let ask = |best: &mut Compounded<Intersection>, pair: [usize; 2], cache: &mut CompoundCache| {
        let [Some(hull_a), Some(hull_b)] = [a.hull(pair[0]), b.hull(pair[1])] else { return };
        let found = levels::intersects(&hull_a, &hull_b, b_in_a, Levels::default(), cache.pair(pair)).intersection;
        best.pairs += 1;
        best.answer.iterations += found.iterations;
        best.answer.support_calls += found.support_calls;
        if strength(found.status) >= strength(best.answer.status) {
            (best.answer.status, best.hulls) = (found.status, pair);
        }
    };
    let first = cache.first(a, b);
    if let Some(pair) = first {
        ask(&mut best, pair, cache);
        if best.answer.status == Overlap::Overlapping {
            return best;
        }
    }
    let mut descent = Descent::new(Placement::new(a, b, b_in_a));
    while let Some(pair) = descent.next(0.0) {
        if Some(pair) == first {
            continue;
        }
        ask(&mut best, pair, cache);
        if best.answer.status == Overlap::Overlapping {
            break;
        }
    }
    best.boxes = descent.boxes();
    if best.answer.is_hit() {
        cache.set_first(best.hulls);
    }
    best
}

/// Order of what pairs say of the whole.
fn strength(status: Overlap) -> u8 {
    match status {
        Overlap::Separated => 0,
        Overlap::Undecided => 1,
        Overlap::Touching => 2,
        Overlap::Overlapping => 3,
    }
}

/// Distance of the unions; 0 when any pair of hulls overlaps.
///
/// Points, normal and distance are those of the nearest pair. The interval holds the distance of the unions: no pair is nearer than
/// `lower`, and some pair is as near as `upper`. The status is that pair's, unless another pair's interval reaches lower than the
/// settings allow: then it is that one's.
///
/// `cache` belongs to this ordered pair of compounds; it is read and brought up to date.
///
/// # Complexity
/// Branch and bound: boxes nearer than the nearest pair so far, nearest first, from the nearest pair of last time on. No allocation.
pub fn distance(
    a: &Compound,
    b: &Compound,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut CompoundCache,
) -> Compounded<Distance> {
    let mut search =
        Nearest { a, b, b_in_a, settings, best: None, lower: (f64::INFINITY, Status::Exact), upper: f64::INFINITY };
    let (mut pairs, mut iterations, mut support_calls) = (0, 0, 0);
    let mut ask = |search: &mut Nearest, pair: [usize; 2], cache: &mut CompoundCache| {
        if let Some(found) = search.ask(pair, cache) {
            pairs += 1;
            iterations += found.iterations;
            support_calls += found.support_calls;
        }
    };
    let first = cache.first(a, b).unwrap_or([0, 0]);
    ask(&mut search, first, cache);
    let mut descent = Descent::new(Placement::new(a, b, b_in_a));
    while search.upper > 0.0
        && let Some(pair) = descent.next(search.upper)
    {
        if pair != first {
            ask(&mut search, pair, cache);
        }
    }
    let (mut answer, hulls) = search.answer();
    (answer.iterations, answer.support_calls) = (iterations, support_calls);
    cache.set_first(hulls);
    Compounded { answer, hulls, pairs, boxes: descent.boxes() }
}

/// The nearest pair so far.
struct Nearest<'q, 'a> {
    a: &'q Compound<'a>,
    b: &'q Compound<'a>,
    b_in_a: Pose,
    settings: &'q Settings,
    best: Option<(Distance, [usize; 2])>,
    /// The least lower end, and its pair's status.
    lower: (f64, Status),
    upper: f64,
}

impl Nearest<'_, '_> {
    fn ask(&mut self, pair: [usize; 2], cache: &mut CompoundCache) -> Option<Distance> {
        let (hull_a, hull_b) = (self.a.hull(pair[0])?, self.b.hull(pair[1])?);
        let found = crate::distance(&hull_a, &hull_b, self.b_in_a, self.settings, cache.pair(pair));
        // Overlapping goes before touching, though both are 0 long.
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
        // Checked packs have a first hull, which is asked.
        let (mut answer, hulls) = self.best.unwrap_or((NOTHING_KNOWN, [0, 0]));
        answer.upper = self.upper;
        if self.lower.0 < answer.lower {
            answer.lower = self.lower.0;
            // NaN takes the branch that says so.
            if !(answer.upper - answer.lower <= self.settings.relative_gap() * answer.distance) {
                answer.status = self.lower.1;
            }
        }
        (answer, hulls)
    }
}

/// Contact of every pair of hulls that are not proved apart, handed to `visit` with the hulls' numbers in A and in B; how many there
/// were, and what they cost.
///
/// Each contact is that of [`contact`](crate::contact()) between the two hulls. The order is that of the descent through the trees:
/// the same for the same input.
///
/// `cache` belongs to this ordered pair of compounds; it is read and brought up to date.
///
/// # Complexity
/// Pairs of boxes that overlap, and one contact for each pair of hulls in them. No allocation.
pub fn contacts(
    a: &Compound,
    b: &Compound,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut CompoundCache,
    mut visit: impl FnMut([usize; 2], &Contact),
) -> Contacts {
    let mut descent = Descent::new(Placement::new(a, b, b_in_a));
    let mut sum = Contacts::default();
    while let Some(pair) = descent.next(0.0) {
        let [Some(hull_a), Some(hull_b)] = [a.hull(pair[0]), b.hull(pair[1])] else { continue };
        let found = crate::contact(&hull_a, &hull_b, b_in_a, settings, cache.pair(pair));
        sum.pairs += 1;
        sum.iterations += found.iterations;
        sum.support_calls += found.support_calls;
        if found.hit {
            sum.hits += 1;
            visit(pair, &found);
        }
    }
    sum.boxes = descent.boxes();
    sum
}

/// What [`contacts`] counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Contacts {
    /// Pairs that are not apart.
    pub hits: u32,
    /// Pairs of hulls that were asked.
    pub pairs: u32,
    /// Pairs of boxes that were compared.
    pub boxes: u32,
    /// Steps of all pairs.
    pub iterations: u32,
    /// Pairs of support queries of all pairs.
    pub support_calls: u32,
}

/// Contact of the pair of hulls that are deepest in each other; `None` where all pairs are proved apart.
///
/// The interval holds the greatest depth of any pair: `depth_lower` is the greatest lower end of all pairs, `depth_upper` the greatest
/// upper one. Moving B by less than `depth_lower`, whichever way, leaves the compounds overlapping. Moving it by `depth_upper` along
/// `normal` parts this pair; other pairs may then still overlap, or come to overlap.
///
/// `cache` belongs to this ordered pair of compounds; it is read and brought up to date.
///
/// # Complexity
/// As [`contacts`].
pub fn contact(
    a: &Compound,
    b: &Compound,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut CompoundCache,
) -> Option<Compounded<Contact>> {
    let mut deepest: Option<(Contact, [usize; 2])> = None;
    let (mut lower, mut upper) = (0.0_f64, 0.0_f64);
    let sum = contacts(a, b, b_in_a, settings, cache, |pair, found| {
        (lower, upper) = (lower.max(found.depth_lower), upper.max(found.depth_upper));
        // Of equals the first by number, whatever the trees look like.
        let is_deeper =
            deepest.is_none_or(|(best, hulls)| found.depth > best.depth || found.depth == best.depth && pair < hulls);
        if is_deeper {
            deepest = Some((*found, pair));
        }
    });
    let (answer, hulls) = deepest?;
    let (iterations, support_calls) = (sum.iterations, sum.support_calls);
    let answer = Contact { depth_lower: lower, depth_upper: upper, iterations, support_calls, ..answer };
    Some(Compounded { answer, hulls, pairs: sum.pairs, boxes: sum.boxes })
}
