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

/// An intersection test in steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IntersectionQuery(MprSearch);

impl SteppedQuery for IntersectionQuery {
    type Settings = ();
    type Answer = Intersection;
    type Workspace = ();

    #[inline(always)]
    fn glance<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        cache: &mut Cache,
    ) -> Option<Step<Intersection>> {
        if m.inner_balls_overlap() {
            cache.forget_axis();
            return Some(Step::Answer(answer(m, Overlap::Overlapping, 0)));
        }
        if let Some(axis) = m.axis_of_balls() {
            cache.set_axis(axis);
            return Some(Step::Answer(answer(m, Overlap::Separated, 0)));
        }
        cache.axis().map(Step::Ask)
    }

    #[inline(always)]
    fn separated<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        _cache: &mut Cache,
        axis: DVec3,
        point: &Point,
    ) -> Option<Intersection> {
        m.separates(axis, point).then(|| answer(m, Overlap::Separated, 0))
    }

    /// The portal of step 2.
    #[inline(always)]
    fn shortcut<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &mut Minkowski<'_, A, B>,
        (): &(),
        cache: &mut Cache,
    ) -> Option<Intersection> {
        let features = cache.portal()?;
        cached_portal_encloses(m, features).then(|| {
            cache.forget_axis();
            answer(m, Overlap::Overlapping, 0)
        })
    }

    /// Step 3.
    #[inline(always)]
    fn start<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        solver: Solver<'_, '_, A, B, (), ()>,
        (): &(),
    ) -> Result<(Self, DVec3), Intersection> {
        let search = MprSearch::new(solver.m, Until::Decided);
        let dir = search.direction();
        Ok((Self(search), dir))
    }

    #[inline(always)]
    fn advance<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        solver: Solver<'_, '_, A, B, Self, ()>,
        point: Point,
    ) -> Step<Intersection> {
        let Solver { query: Self(search), m, cache, .. } = solver;
        let Some(found) = search.continue_with(point) else { return Step::Ask(search.direction()) };
        let (status, steps) = conclude(m, cache, found, search.portal());
        Step::Answer(answer(m, status, search.iterations() + steps))
    }
}

#[inline(always)]
fn answer<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    status: Overlap,
    iterations: u32,
) -> Intersection {
    Intersection { status, iterations, support_calls: m.support_calls(), parts: [0; 2] }
}

/// Conclusion from the outcome of MPR, and step 4: the status, and the number of steps of EPA.
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
