//! Distance of two shapes with their witness points. GJK finds it; EPA settles a distance of zero.
//!
//! # Reference
//! Kenwright, section 3 ("closest points between pairs of convex polytopes") and section 4.6 (the
//! search for the closest features serves the next frame).
//!
//! # Steps
//! 1. If the balls inside the shapes overlap, the distance is 0. No support call.
//! 2. Start from the last simplex under the new pose, from the points of an intersection test that
//!    missed, from the axis of [`Cache::from_axis`], or from the centre.
//! 3. Search the point closest to the origin (GJK).
//! 4. If it is the origin within rounding error, decide by EPA whether the shapes overlap or touch.

use super::bound::Bound;
use super::cache::Cache;
use super::epa::FLAT_ROUNDINGS;
use super::gjk::{self, Closest, GjkSearch, Simplex};
use super::minkowski::{Minkowski, Point, Step};
use super::settings::Settings;
use super::status::{Overlap, Status};
use super::steps::{Solver, SteppedQuery, at_once};
use crate::fields::fields;
use crate::pose::Pose;
use crate::support::SupportMap;
use crate::vector::unit;
use glam::DVec3;

/// Answer of [`distance`](crate::distance()): the distance of a pair and the witness points that
/// realise it.
///
/// Lengths are in the shapes' unit, points and directions in A's frame. The interval from `lower`
/// to `upper` always contains the distance.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// How the query ended, and thus how narrow the interval is.
    pub status: Status,
    /// Length of the segment from `point_a` to `point_b`; 0 if the shapes overlap or touch.
    pub distance: f64,
    /// Lower bound of the distance, at least 0, with allowance for rounding error.
    pub lower: f64,
    /// Upper bound of the distance, with allowance for rounding error.
    pub upper: f64,
    /// Unit vector from A to B: the normal of the planes that prove `lower`. It is the direction of
    /// the shortest segment within the tolerance.
    ///
    /// If the shapes touch, it is the normal of a plane between them. If they overlap, it is any
    /// unit vector.
    pub normal: DVec3,
    /// Witness point: the point of A closest to B. If the shapes overlap, a common point.
    pub point_a: DVec3,
    /// Witness point: the point of B closest to A. If the shapes overlap, a common point.
    pub point_b: DVec3,
    /// Number of steps of the search.
    pub iterations: u32,
    /// Number of support calls. One call queries both shapes once.
    pub support_calls: u32,
    /// The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a
    /// mesh or a field. 0 for a shape without parts.
    pub parts: [u32; 2],
    /// Features of a point of A and of a point of B in their support planes along the normal; the
    /// greatest number if they are not known. For the derivatives.
    #[doc(hidden)]
    pub features: [u32; 2],
}

fields!(
    Distance { status distance lower upper normal point_a point_b iterations support_calls parts } but { features }
);

impl Distance {
    /// The same distance with A and B exchanged.
    pub(crate) fn exchanged(self, b_in_a: Pose) -> Self {
        let ([of_a, of_b], [vertex_a, vertex_b]) = (self.parts, self.features);
        Self {
            normal: b_in_a.transform_vector(-self.normal),
            point_a: b_in_a.transform_point(self.point_b),
            point_b: b_in_a.transform_point(self.point_a),
            parts: [of_b, of_a],
            features: [vertex_b, vertex_a],
            ..self
        }
    }
}

impl Default for Distance {
    /// A distance that claims nothing: the interval [0, ∞) contains every distance. It initialises
    /// the slices of a batch.
    fn default() -> Self {
        Self {
            status: Status::IterationLimit,
            distance: 0.0,
            lower: 0.0,
            upper: f64::INFINITY,
            normal: DVec3::X,
            point_a: DVec3::ZERO,
            point_b: DVec3::ZERO,
            iterations: 0,
            support_calls: 0,
            parts: [0; 2],
            features: [u32::MAX; 2],
        }
    }
}

/// Distance of `a` and `b` without regard to convex radii.
///
/// See [`distance`](crate::distance()) for frames, units and cost.
pub(super) fn core_distance<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
) -> Distance {
    at_once::<A, B, DistanceQuery>((a, b, b_in_a), settings, cache)
}

/// A distance query in steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DistanceQuery {
    settings: Settings,
    simplex: Simplex,
    /// `None` while the support point is the first vertex of the simplex.
    search: Option<GjkSearch>,
}

impl SteppedQuery for DistanceQuery {
    type Settings = Settings;
    type Answer = Distance;
    type Workspace = ();

    #[inline(always)]
    fn glance<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        cache: &mut Cache,
    ) -> Option<Step<Distance>> {
        if !m.inner_balls_overlap() {
            return None;
        }
        cache.forget_axis();
        let common = m.point_in_both_balls();
        Some(Step::Answer(Distance { point_a: common, point_b: common, ..overlapping(m) }))
    }

    /// Step 2.
    #[inline(always)]
    fn start<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        solver: Solver<'_, '_, A, B, (), ()>,
        settings: &Settings,
    ) -> Result<(Self, DVec3), Distance> {
        let Solver { m, cache, workspace, .. } = solver;
        let mut query = Self { settings: *settings, simplex: Simplex::empty(), search: None };
        for vertex in cache.simplex().iter().filter_map(|features| m.recall(*features)) {
            if !query.simplex.contains(vertex.w) {
                query.simplex.push(vertex);
            }
        }
        if query.simplex.is_empty() {
            match cache.start() {
                Some(axis) => return Ok((query, axis)),
                None => _ = query.simplex.push(m.center_point()),
            }
        }
        match (Solver { query: &mut query, m, cache, workspace }).continue_with(None) {
            Step::Ask(dir) => Ok((query, dir)),
            Step::Answer(found) => Err(found),
        }
    }

    #[inline(always)]
    fn advance<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        solver: Solver<'_, '_, A, B, Self, ()>,
        point: Point,
    ) -> Step<Distance> {
        if solver.query.search.is_some() {
            return solver.continue_with(Some(point));
        }
        solver.query.simplex.push(point);
        solver.continue_with(None)
    }
}

/// The answer if the search proves nothing else: shapes that overlap.
#[inline(always)]
fn overlapping<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(m: &Minkowski<'_, A, B>) -> Distance {
    let center = m.center_point();
    Distance {
        status: Status::Overlapping,
        upper: 0.0,
        normal: unit(-center.w).unwrap_or(DVec3::X),
        point_a: center.a,
        point_b: center.b(),
        ..Distance::default()
    }
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> Solver<'_, '_, A, B, DistanceQuery, ()> {
    /// Step 3, up to the next support query.
    #[inline(always)]
    fn continue_with(self, point: Option<Point>) -> Step<Distance> {
        let DistanceQuery { settings, simplex, search } = &mut *self.query;
        let search = search.get_or_insert_with(|| {
            let (rounding, tolerance) = (self.m.rounding_error(), settings.relative_tolerance());
            GjkSearch::new(simplex, rounding, rounding, tolerance, settings.max_iterations)
        });
        match search.advance(simplex, point) {
            Step::Ask(dir) => Step::Ask(dir),
            Step::Answer(found) => Step::Answer(self.conclude(&found)),
        }
    }

    #[inline(always)]
    fn conclude(mut self, found: &Closest) -> Distance {
        let (rounding, center, simplex) = (self.m.rounding_error(), self.m.center_point().w, &self.query.simplex);
        let (mut out, tolerance) = (overlapping(self.m), self.query.settings.relative_tolerance());
        self.cache.set_simplex(simplex.features());
        out.features = Point::first_features(simplex.features());
        let (point_a, point_b, between) = simplex.witnesses(found.upper, self.m.noise());
        (out.point_a, out.point_b) = (point_a, point_b);
        out.iterations = found.iterations;
        if found.normal != DVec3::ZERO {
            out.normal = found.normal;
        }
        let separated = found.lower > rounding;
        if separated {
            self.cache.set_axis(out.normal);
        } else {
            self.cache.forget_axis();
        }
        if found.end == gjk::End::Inside && !separated {
            out.support_calls = self.m.support_calls();
            return out;
        }
        // The distance of the returned witness points, not of the search's last plane: rounding
        // error in the search cannot make it wrong.
        out.distance = between.length();
        let by_balls = center.length() - self.m.outer_radius();
        if by_balls > found.lower {
            // The planes that prove it are perpendicular to the line of centres.
            out.normal = unit(-center).unwrap_or(out.normal);
        }
        let lower = found.lower.max(by_balls);
        (out.lower, out.upper) = ((lower - rounding).max(0.0), out.distance + self.m.noise());
        out.status = match found.end {
            gjk::End::Converged if out.distance - lower <= rounding => Status::Exact,
            gjk::End::Converged if out.distance - lower <= tolerance * out.distance + 2.0 * rounding => Status::Within,
            gjk::End::Limit => Status::IterationLimit,
            _ => Status::Stalled,
        };
        if found.upper <= 2.0 * rounding && !separated {
            self.settle_at_origin(&mut out);
        }
        out.support_calls = self.m.support_calls();
        out
    }

    /// The origin is on the simplex, within rounding error. Decides by EPA whether it is inside the
    /// Minkowski difference or on its surface.
    #[inline(always)]
    fn settle_at_origin(&mut self, out: &mut Distance) {
        let (overlap, bound, steps) = self.m.decide_by_expansion(None, self.cache);
        out.iterations += steps;
        // Witness points that nearly coincide give no direction. The face that the origin is on
        // does.
        if overlap != Overlap::Overlapping && bound.normal != DVec3::ZERO {
            out.normal = bound.normal;
            let length = bound.point_a.distance(bound.point_b);
            if length < out.distance {
                (out.point_a, out.point_b, out.upper) = (bound.point_a, bound.point_b, length + self.m.noise());
            }
        }
        out.lower = 0.0;
        match overlap {
            Overlap::Overlapping => {
                let (points, steps) = Bound::common_point(self.m, [out.point_a, out.point_b], out.normal);
                [out.point_a, out.point_b] = points;
                out.iterations += steps;
                (out.status, out.distance, out.upper) = (Status::Overlapping, 0.0, 0.0);
            }
            Overlap::Touching | Overlap::Separated if out.upper <= FLAT_ROUNDINGS * self.m.rounding_error() => {
                (out.status, out.distance) = (Status::Touching, 0.0);
            }
            // The shapes may penetrate, or the simplex is a sliver: then the origin may be farther
            // from it than it seems.
            _ => self.settle_beside(out),
        }
    }

    /// The answer for witness points that are too far apart to touch: the plane of EPA bounds their
    /// distance from below.
    #[cold]
    fn settle_beside(&mut self, out: &mut Distance) {
        let (rounding, tolerance) = (self.m.rounding_error(), self.query.settings.relative_tolerance());
        let lower = -self.m.point(out.normal).w.dot(out.normal);
        (out.lower, out.distance) = ((lower - rounding).max(0.0), out.point_a.distance(out.point_b));
        out.status = Status::Stalled;
        // NaN takes the failing branch.
        if out.lower > 0.0 && out.distance - lower <= tolerance * out.distance + 2.0 * rounding {
            out.status = if out.distance - lower <= rounding { Status::Exact } else { Status::Within };
        }
    }
}
