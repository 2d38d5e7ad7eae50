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
use super::epa::{self, Expansion};
use super::minkowski::{Minkowski, Point, Step};
use super::mpr::{self, Found, Portal, Until, is_clearly_negative};
use super::status::Overlap;
use super::steps::{SteppedQuery, at_once};
use crate::pose::Pose;
use crate::support::SupportMap;
use glam::DVec3;

/// Maximum number of EPA steps for a decision. Touching pairs need about a dozen.
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
    at_once::<A, B, IntersectionQuery>(&mut Minkowski::new(a, b, b_in_a), &(), cache)
}

/// An intersection test in steps. It waits for a support point.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "a query is not moved, and the large variant is the usual one")]
pub(crate) enum IntersectionQuery {
    /// Along this separating axis of the cache.
    Axis(DVec3),
    /// For MPR.
    Portal(mpr::MprSearch),
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> SteppedQuery<A, B> for IntersectionQuery {
    type Settings = ();
    type Answer = Intersection;
    type Workspace = ();

    fn new() -> Self {
        Self::Axis(DVec3::ZERO)
    }

    #[inline(always)]
    fn advance(
        &mut self,
        point: Option<Point>,
        m: &mut Minkowski<'_, A, B>,
        (): &(),
        cache: &mut Cache,
        (): &mut (),
    ) -> Step<Intersection> {
        let Some(point) = point else {
            if m.inner_balls_overlap() {
                cache.forget_axis();
                return answer(m, Overlap::Overlapping, 0);
            }
            if let Some(axis) = m.axis_of_balls() {
                cache.set_axis(axis);
                return answer(m, Overlap::Separated, 0);
            }
            if let Some(axis) = cache.axis() {
                *self = Self::Axis(axis);
                return Step::Ask(axis);
            }
            return self.after_axis(m, cache);
        };
        match self {
            Self::Axis(axis) if m.separates(*axis, &point) => answer(m, Overlap::Separated, 0),
            Self::Axis(_) => self.after_axis(m, cache),
            Self::Portal(search) => match search.continue_with(point) {
                None => Step::Ask(search.direction()),
                Some(found) => {
                    let (status, iterations) = conclude(m, cache, found, search.portal(), search.iterations());
                    answer(m, status, iterations)
                }
            },
        }
    }
}

impl IntersectionQuery {
    /// The portal of step 2, then step 3.
    #[inline(always)]
    fn after_axis<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &mut self,
        m: &Minkowski<'_, A, B>,
        cache: &mut Cache,
    ) -> Step<Intersection> {
        if cache.portal().is_some_and(|features| cached_portal_encloses(m, features)) {
            cache.forget_axis();
            return answer(m, Overlap::Overlapping, 0);
        }
        let search = mpr::MprSearch::new(m, Until::Decided);
        let dir = search.direction();
        *self = Self::Portal(search);
        Step::Ask(dir)
    }
}

fn answer<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    status: Overlap,
    iterations: u32,
) -> Step<Intersection> {
    Step::Answer(Intersection { status, iterations, support_calls: m.support_calls() })
}

fn conclude<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    cache: &mut Cache,
    found: Found,
    portal: &Portal,
    iterations: u32,
) -> (Overlap, u32) {
    let start = match found {
        Found::Separated { axis } => {
            cache.set_separation(axis, &portal.vertices);
            return (Overlap::Separated, iterations);
        }
        Found::Portal { is_behind: true }
            if portal.holds_origin(m.center_point().w, m.inner_radius(), m.rounding_error()) =>
        {
            cache.forget_axis();
            cache.set_portal(&portal.vertices);
            return (Overlap::Overlapping, iterations);
        }
        Found::Portal { .. } => Some(portal.tetrahedron(m)),
        Found::Nothing => None,
    };
    let (status, Bound { normal, .. }, steps) = decide_by_expansion(m, start, cache);
    match status {
        Overlap::Separated => cache.set_axis(normal),
        _ => cache.forget_axis(),
    }
    (status, iterations + steps)
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

/// Decides by EPA whether the origin is inside.
///
/// The bound holds a separating axis if the origin is outside, and the witness points if the shapes
/// touch. The last value is the number of steps.
pub(super) fn decide_by_expansion<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    start: Option<[Point; 4]>,
    cache: &mut Cache,
) -> (Overlap, Bound, u32) {
    let Expansion { end, bound, iterations, .. } = epa::decide(m, start, MAX_DECISION_STEPS, cache);
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
