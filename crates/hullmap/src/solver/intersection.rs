//! Intersection test: do two shapes share a point? MPR decides, EPA settles what MPR leaves open.
//!
//! # Reference
//! Kenwright, Algorithm 1 lines 1 to 9; section 4.1 for the order of the tests.
//!
//! # Steps
//! 1. Balls around and inside the shapes: no support call.
//! 2. The last separating axis: one support call. The last portal with the origin behind it: none.
//! 3. Portal discovery, then portal refinement until the answer is known.
//! 4. EPA, which needs no portal, settles the rest: flat shapes, touching shapes, reached limits.
//!
//! # Deviations
//! - The answer has four values. "Touching" and "undecided" are not hidden in a yes or a no.

use super::bound::Bound;
use super::cache::Cache;
use super::epa::{self, Expansion, Goal, expand};
use super::minkowski::{Interrupted, Minkowski, Point};
use super::mpr::{Discovery, Portal, discover_portal, is_clearly_negative};
use super::mpr::{Found, Search, Side, Until, refine_portal};
use super::status::Overlap;
use super::suspended::Suspended;
use crate::pose::Pose;
use crate::support::SupportMap;
use crate::support::simd::{Dispatch, Pass, Simd};
use crate::vector::unit;
use glam::DVec3;

/// Maximum number of EPA steps for a decision. Only touching pairs need EPA, usually about a dozen
/// steps.
const MAX_DECISION_STEPS: u32 = 250;

/// Answer of [`intersects`](crate::intersects()).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    /// Whether the shapes share a point.
    pub status: Overlap,
    /// Number of steps of all phases together.
    pub iterations: u32,
    /// Number of support calls. One call queries both shapes once.
    pub support_calls: u32,
}

impl Default for Intersection {
    /// An undecided answer, which claims nothing. It initialises the slices of a batch.
    fn default() -> Self {
        Self { status: Overlap::Undecided, iterations: 0, support_calls: 0 }
    }
}

impl Intersection {
    /// True unless the shapes are certainly separated.
    ///
    /// Touching and undecided pairs count as hits, so that numerical trouble never reads as "no
    /// collision".
    ///
    /// ```
    /// use hullmap::{Cache, Overlap, Pose, glam::DVec3, intersects, shapes::Cuboid};
    ///
    /// let cube = Cuboid::new(DVec3::ONE)?;
    /// let touching = Pose::from_translation(DVec3::X * 2.0)?;
    /// let answer = intersects(&cube, &cube, touching, &mut Cache::new());
    /// assert!(answer.status == Overlap::Touching && answer.is_hit());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn is_hit(&self) -> bool {
        self.status != Overlap::Separated
    }
}

/// Whether `a` and `b` share a point, without regard to convex radii.
///
/// See [`intersects`](crate::intersects()) for frames and cost. After a miss the cache holds the
/// separating axis and the points seen, from which [`distance`](crate::distance()) continues
/// (Kenwright, section 4.6).
pub(super) fn core_intersects<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    cache: &mut Cache,
) -> Intersection {
    let mut m = Minkowski::new(a, b, b_in_a);
    let (status, iterations) = decide(&mut m, cache);
    Intersection { status, iterations, support_calls: m.support_calls() }
}

/// The tests before any search: the outer balls, then the axis of the cache.
#[inline]
pub(super) fn separated_early<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    cache: &Cache,
) -> Early {
    if m.outer_balls_separated() {
        return unit(-m.center_point().w).map_or(Early::Unknown(None), Early::Separated);
    }
    let Some(axis) = cache.axis() else { return Early::Unknown(None) };
    let point = m.point(axis);
    if point.w.dot(axis) < -m.rounding_error() { Early::Separated(axis) } else { Early::Unknown(Some((axis, point))) }
}

/// What is known of a pair before the search.
pub(super) enum Early {
    /// This axis separates. It has unit length and points from A to B.
    Separated(DVec3),
    /// No axis is known to separate. The axis of the cache, if there is one, with its support
    /// point.
    Unknown(Option<(DVec3, Point)>),
}

fn decide<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    cache: &mut Cache,
) -> (Overlap, u32) {
    if m.inner_balls_overlap() {
        cache.forget_axis();
        return (Overlap::Overlapping, 0);
    }
    if let Early::Separated(axis) = separated_early(m, cache) {
        cache.set_axis(axis);
        return (Overlap::Separated, 0);
    }
    if cache.portal().is_some_and(|features| cached_portal_encloses(m, features)) {
        cache.forget_axis();
        return (Overlap::Overlapping, 0);
    }
    let mut search = SearchPass { m, portal: Portal::EMPTY, found: Found::Nothing, iterations: 0 };
    Dispatch::best().pass(&mut search);
    let SearchPass { m, portal, found, iterations } = search;
    conclude(m, cache, found, &portal, iterations)
}

/// Portal discovery and refinement until the answer is known, compiled for the processor's
/// instruction set.
struct SearchPass<'m, 's, A: ?Sized, B: ?Sized> {
    m: &'m mut Minkowski<'s, A, B>,
    /// The portal, or the points seen last if there is none.
    portal: Portal,
    found: Found,
    /// Number of steps.
    iterations: u32,
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> Pass for SearchPass<'_, '_, A, B> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, _: S) {
        let (found, steps) = discover_portal(self.m, &mut self.portal);
        self.iterations = steps;
        self.found = match found {
            Discovery::Separated { axis } => Found::Separated { axis },
            Discovery::Portal => {
                let refined = refine_portal(self.m, &mut self.portal, Until::Decided, &mut Bound::none());
                self.iterations += refined.iterations;
                match refined.side {
                    Side::Separated => Found::Separated { axis: refined.axis },
                    side => Found::Portal(side),
                }
            }
            Discovery::Flat | Discovery::Limit => Found::Nothing,
        };
    }
}

/// The answer that follows from what the search found, after `iterations` steps. EPA settles what
/// is open.
fn conclude<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    cache: &mut Cache,
    found: Found,
    portal: &Portal,
    iterations: u32,
) -> (Overlap, u32) {
    let start = match found {
        Found::Separated { axis } => {
            store_separation(cache, axis, &portal.vertices);
            return (Overlap::Separated, iterations);
        }
        Found::Portal(Side::Overlapping) if is_certainly_inside(m, portal) => {
            cache.forget_axis();
            cache.set_portal(&portal.vertices);
            return (Overlap::Overlapping, iterations);
        }
        Found::Portal(_) => Some(portal_tetrahedron(m, portal)),
        Found::Nothing => None,
    };
    let (status, Bound { normal, .. }, steps) = decide_by_expansion(m, start, cache);
    match status {
        Overlap::Separated => cache.set_axis(normal),
        _ => cache.forget_axis(),
    }
    (status, iterations + steps)
}

/// An intersection test that is suspended wherever it waits for memory, so that a batch can keep
/// several tests in flight. The answer has the bits of [`core_intersects`].
#[derive(Debug)]
pub(crate) struct SuspendedIntersection<'s, A: ?Sized, B: ?Sized> {
    m: Minkowski<'s, A, B>,
    /// `None` while the next support query tests the separating axis of the cache.
    search: Option<Search>,
    /// The support query that comes next.
    next: Interrupted,
}

impl<'s, A: SupportMap + ?Sized, B: SupportMap + ?Sized> Suspended<'s, A, B> for SuspendedIntersection<'s, A, B> {
    type Settings = ();
    type Answer = Intersection;
    type Room = ();

    fn start(
        (a, b, b_in_a): (&'s A, &'s B, Pose),
        (): &(),
        cache: &mut Cache,
        (): &mut (),
    ) -> Result<Self, Intersection> {
        let m = Minkowski::new(a, b, b_in_a);
        let mut test = Self { m, search: None, next: Interrupted::NOTHING };
        if test.m.inner_balls_overlap() {
            cache.forget_axis();
            return Err(test.answer(Overlap::Overlapping, 0));
        }
        let are_balls_separated = test.m.outer_balls_separated();
        if are_balls_separated && let Some(axis) = unit(-test.m.center_point().w) {
            cache.set_axis(axis);
            return Err(test.answer(Overlap::Separated, 0));
        }
        match cache.axis().filter(|_| !are_balls_separated) {
            Some(axis) => test.next = test.m.start(axis),
            None => test.start_search(cache).map_or(Ok(()), Err)?,
        }
        Ok(test)
    }

    fn step(&mut self, (): &(), cache: &mut Cache, (): &mut ()) -> Option<Intersection> {
        if !self.next.is_ready() {
            self.m.resume(&mut self.next);
            return None;
        }
        let dir = self.next.dir;
        let point = self.m.finish(&self.next);
        let Some(search) = &mut self.search else {
            if point.w.dot(dir) < -self.m.rounding_error() {
                cache.set_axis(dir);
                return Some(self.answer(Overlap::Separated, 0));
            }
            return self.start_search(cache);
        };
        let Some(found) = search.continue_with(point) else {
            self.next = self.m.start(search.direction());
            return None;
        };
        let (status, iterations) = conclude(&mut self.m, cache, found, search.portal(), search.iterations());
        Some(self.answer(status, iterations))
    }
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> SuspendedIntersection<'_, A, B> {
    /// Tests the portal of the cache, then starts the search.
    fn start_search(&mut self, cache: &mut Cache) -> Option<Intersection> {
        if cache.portal().is_some_and(|features| cached_portal_encloses(&self.m, features)) {
            cache.forget_axis();
            return Some(self.answer(Overlap::Overlapping, 0));
        }
        let search = Search::new(&self.m);
        self.next = self.m.start(search.direction());
        self.search = Some(search);
        None
    }

    fn answer(&self, status: Overlap, iterations: u32) -> Intersection {
        Intersection { status, iterations, support_calls: self.m.support_calls() }
    }
}

/// Stores what a miss found: the axis, for the next miss, and the points seen, for a distance
/// query.
pub(super) fn store_separation(cache: &mut Cache, axis: DVec3, seen: &[Point; 3]) {
    if let Some(axis) = unit(axis) {
        cache.set_axis(axis);
    }
    cache.set_simplex(seen.iter().map(|v| v.features));
}

/// Whether the origin is certainly in the tetrahedron of the centre and of the portal of these
/// features. No support call.
fn cached_portal_encloses<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    features: [[u32; 2]; 3],
) -> bool {
    let [Some(v1), Some(v2), Some(v3)] = features.map(|features| m.recall(features)) else { return false };
    let portal = Portal { vertices: [v1, v2, v3] };
    portal.normal().is_some_and(|n| is_clearly_negative(-n.dot(v1.w), n, m.rounding_error()))
        && portal.is_pierced(m.center_point().w)
        && is_certainly_inside(m, &portal)
}

/// Whether the origin, which is behind the portal, is certainly inside and not on the surface.
fn is_certainly_inside<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    portal: &Portal,
) -> bool {
    portal.holds_origin(m.center_point().w, m.inner_radius(), m.rounding_error())
}

/// The tetrahedron of the centre and the portal.
pub(super) fn portal_tetrahedron<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    portal: &Portal,
) -> [Point; 4] {
    let [v1, v2, v3] = portal.vertices;
    [m.center_point(), v1, v2, v3]
}

/// Decides by EPA whether the origin is inside.
///
/// The bound holds a separating axis if the origin is outside, and the witness points if the shapes
/// touch. The last value is the number of steps.
pub(super) fn decide_by_expansion<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    start: Option<[Point; 4]>,
    cache: &mut Cache,
) -> (Overlap, Bound, u32) {
    let Expansion { end, bound, iterations, .. } =
        expand(m, start, Goal::Decide, Bound::none(), MAX_DECISION_STEPS, cache);
    let status = match end {
        epa::End::Separated => Overlap::Separated,
        epa::End::Inside => Overlap::Overlapping,
        // The face may be far from the origin and still on the surface of a polytope that is too
        // thin to enclose the origin for certain.
        epa::End::Touching | epa::End::Converged if bound.upper <= epa::FLAT_ROUNDINGS * m.rounding_error() => {
            Overlap::Touching
        }
        _ => Overlap::Undecided,
    };
    (status, bound, iterations)
}
