//! Intersection test: do two shapes share a point? MPR decides, EPA settles what MPR leaves open.
//!
//! # Reference
//! Kenwright, Algorithm 1 lines 1 to 9; section 4.1 for the order of the tests.
//!
//! # Steps
//! 1. Balls around and inside the shapes: no support call.
//! 2. The last separating axis: one support call. The last portal, if the origin is behind it: no
//!    support call.
//! 3. Portal discovery, then portal refinement until the answer is known.
//! 4. EPA, which needs no portal, settles the rest: flat shapes, touching shapes, reached limits.
//!
//! # Deviations
//! - The answer has four values. "Touching" and "undecided" are not hidden in a yes or a no.

use super::bound::Bound;
use super::cache::Cache;
use super::minkowski::{Minkowski, Point, Step};
use super::mpr::{Found, MprSearch, Portal, Until, is_clearly_negative};
use super::status::Overlap;
use super::steps::{Solver, SteppedQuery, at_once};
use crate::fields::fields;
use crate::pose::Pose;
use crate::support::SupportMap;
use glam::DVec3;

/// Answer of [`intersects`](crate::intersects()).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    /// Whether the shapes share a point.
    pub status: Overlap,
    /// Number of steps of all phases together.
    pub iterations: u32,
    /// Number of support calls. One call queries both shapes once.
    pub support_calls: u32,
    /// The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a
    /// mesh or a field. 0 for a shape without parts.
    pub parts: [u32; 2],
}

fields!(Intersection { status iterations support_calls parts } and { hit: is_hit });

impl Default for Intersection {
    /// An undecided answer, which claims nothing. It initialises the slices of a batch.
    fn default() -> Self {
        Self { status: Overlap::Undecided, iterations: 0, support_calls: 0, parts: [0; 2] }
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
    at_once::<A, B, IntersectionQuery>((a, b, b_in_a), &(), cache)
}

/// An intersection test in steps. It waits for a support point.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "a query is not moved, and the large variant is the usual one")]
pub(crate) enum IntersectionQuery {
    /// Along this separating axis of the cache.
    Axis(DVec3),
    /// For MPR.
    Portal(MprSearch),
}

impl SteppedQuery for IntersectionQuery {
    type Settings = ();
    type Answer = Intersection;
    type Workspace = ();

    fn new((): &()) -> Self {
        Self::Axis(DVec3::ZERO)
    }

    #[inline(always)]
    fn advance<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        solver: Solver<'_, '_, A, B, Self, ()>,
        point: Option<Point>,
    ) -> Step<Intersection> {
        let Some(point) = point else {
            if solver.m.inner_balls_overlap() {
                solver.cache.forget_axis();
                return solver.answer(Overlap::Overlapping, 0);
            }
            if let Some(axis) = solver.m.axis_of_balls() {
                solver.cache.set_axis(axis);
                return solver.answer(Overlap::Separated, 0);
            }
            let Some(axis) = solver.cache.axis() else { return solver.after_axis() };
            *solver.query = Self::Axis(axis);
            return Step::Ask(axis);
        };
        match &mut *solver.query {
            Self::Axis(axis) if solver.m.separates(*axis, &point) => solver.answer(Overlap::Separated, 0),
            Self::Axis(_) => solver.after_axis(),
            Self::Portal(search) => match search.continue_with(point) {
                None => Step::Ask(search.direction()),
                Some(found) => {
                    let (status, steps) = conclude(solver.m, solver.cache, found, search.portal());
                    let iterations = search.iterations() + steps;
                    solver.answer(status, iterations)
                }
            },
        }
    }
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> Solver<'_, '_, A, B, IntersectionQuery, ()> {
    #[inline(always)]
    fn answer(&self, status: Overlap, iterations: u32) -> Step<Intersection> {
        Step::Answer(Intersection { status, iterations, support_calls: self.m.support_calls(), parts: [0; 2] })
    }

    /// The portal of step 2, then step 3.
    #[inline(always)]
    fn after_axis(self) -> Step<Intersection> {
        if self.cache.portal().is_some_and(|features| cached_portal_encloses(self.m, features)) {
            self.cache.forget_axis();
            return self.answer(Overlap::Overlapping, 0);
        }
        let search = MprSearch::new(self.m, Until::Decided);
        let dir = search.direction();
        *self.query = IntersectionQuery::Portal(search);
        Step::Ask(dir)
    }
}

/// What follows from the outcome of MPR, and step 4: the status, and the number of steps of EPA.
fn conclude<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    cache: &mut Cache,
    found: Found,
    portal: &Portal,
) -> (Overlap, u32) {
    let start = match found {
        Found::Separated { axis } => {
            cache.set_separation(axis, &portal.vertices);
            return (Overlap::Separated, 0);
        }
        Found::Portal { is_behind: true }
            if portal.holds_origin(m.center_point().w, m.inner_radius(), m.rounding_error()) =>
        {
            cache.forget_axis();
            cache.set_portal(&portal.vertices);
            return (Overlap::Overlapping, 0);
        }
        Found::Portal { .. } => Some(portal.tetrahedron(m)),
        Found::Nothing => None,
    };
    let (status, Bound { normal, .. }, steps) = m.decide_by_expansion(start, cache);
    match status {
        Overlap::Separated => cache.set_axis(normal),
        _ => cache.forget_axis(),
    }
    (status, steps)
}

/// Whether the origin is certainly in the tetrahedron of the centre and of the portal of these
/// features. No support call.
fn cached_portal_encloses<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    features: [[u32; 2]; 3],
) -> bool {
    let Some(portal) = Portal::recall(m, features) else { return false };
    portal.normal().is_some_and(|n| is_clearly_negative(-n.dot(portal.vertices[0].w), n, m.rounding_error()))
        && portal.is_pierced(m.center_point().w)
        && portal.holds_origin(m.center_point().w, m.inner_radius(), m.rounding_error())
}
