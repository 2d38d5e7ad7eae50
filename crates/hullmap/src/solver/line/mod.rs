//! Line against a convex set: where a ray enters it. Rays and shape casts are both this search.
//!
//! The set is the Minkowski difference C of two shapes, and the line starts at the origin. B moves
//! along the line; the shapes touch first where the line enters C. A ray is the motion of a point.
//!
//! # Reference
//! Snethen, "XenoCollide", Game Programming Gems 7 (portal refinement along a ray); van den Bergen,
//! "Ray casting against general convex objects with application to continuous collision detection",
//! 2004, for the shape cast as a ray cast of the Minkowski difference.
//! docs/contributors/intervals.md proves the interval.
//!
//! # Steps
//! 1. [`Clip`]: the ball around C, the limit of the ray. No support call.
//! 2. [`portal`]: across the line, find a triangle of points of C that the line pierces, or a plane
//!    that separates the line from C.
//! 3. Refine the triangle along the line to the surface. Each step adds a support plane, which
//!    bounds the entry from below. If the triangle moves to the origin's other side, the origin is
//!    inside.
//! 4. `clearance`: how far the line is inside C, seen along the line. It turns the pierced
//!    triangle, whose corners have rounding errors, into a certain upper bound.
//!
//! # Deviations
//! - XenoCollide's ray starts inside the set. Here the search is two-dimensional first, so that the
//!   origin may be anywhere.
//! - A ray that grazes C, so that rounding error decides between hit and miss, is neither. It has a
//!   status of its own.
//! - Van den Bergen's search (GJK) has lower bounds only. It is used for rounded shapes, see
//!   [`rounded`](super::rounded).

mod clearance;
mod clip;
mod portal;

use glam::DVec3;

use self::clip::Clip;
use self::portal::{End, LineSearch, Pierced, Portal, Sense};
use super::barycentric::blend;
use super::bound::Bound;
use super::minkowski::Minkowski;
use super::status::Status;
use crate::support::SupportMap;

/// Maximum number of steps, whatever the settings are. Polytopes need 5 to 30, smooth shapes at
/// zero tolerance about 100.
const MAX_STEPS: u32 = 500;

/// Share of the tolerance that the error of the upper bound may take before a better clearance is
/// searched.
const ERROR_SHARE: f64 = 0.25;

/// An interval up to this many errors wide, measured along the normal, is as narrow as rounding
/// error allows.
const EXACT_ERRORS: f64 = 64.0;

/// A ray or a cast to solve.
#[derive(Clone, Copy, Debug)]
pub(super) struct LineQuery {
    pub(super) direction: DVec3,
    pub(super) limit: f64,
    pub(super) tolerance: f64,
    /// Width of the interval at which the search ends before the surface: the tolerance, or −∞ if
    /// the normal must belong to a face.
    pub(super) gap: f64,
    /// Maximum number of steps.
    pub(super) max_iterations: u32,
}

/// Where a line enters a convex set. Lengths are along the line, from its origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// `Separated` for a certain miss, `Overlapping` if the origin is inside, `Touching` if neither
    /// hit nor miss is certain.
    pub(super) status: Status,
    pub(super) at: f64,
    pub(super) lower: f64,
    pub(super) upper: f64,
    /// Unit normal, from A to B, of the plane that bounds the entry from below, or proves a miss.
    pub(super) normal: DVec3,
    /// The points of A and of B, which has moved to the entry, in A's frame.
    pub(super) points: [DVec3; 2],
    pub(super) iterations: u32,
}

impl Entry {
    /// A certain miss, proved by a plane with this normal.
    pub(super) fn miss(normal: DVec3, iterations: u32) -> Self {
        Self {
            status: Status::Separated,
            at: f64::INFINITY,
            lower: f64::INFINITY,
            upper: f64::INFINITY,
            normal,
            points: [DVec3::ZERO; 2],
            iterations,
        }
    }
}

/// Where the ray from the origin enters the Minkowski difference.
///
/// `axis` is a direction that separated the shapes before, if there is one.
#[inline]
pub(super) fn enter<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    query: &LineQuery,
    axis: Option<DVec3>,
) -> Entry {
    let mut clip = Clip::new(m, query.direction, query.limit);
    if let Some(axis) = axis.filter(|_| !clip.is_empty()) {
        clip.cut(axis, m.point(axis).w);
    }
    if clip.is_empty() {
        return Entry::miss(clip.last, 0);
    }
    let mut search = LineSearch::new(m, clip);
    let mut entry = search.find(query);
    // The last plane proves a miss, whatever the search found before it.
    if search.clip.is_empty() {
        entry = Entry::miss(search.clip.last, search.steps);
    }
    Entry { iterations: search.steps, ..entry }
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> LineSearch<'_, '_, A, B> {
    /// Steps 2 to 4. The result is meaningless if the clip is empty.
    fn find(&mut self, query: &LineQuery) -> Entry {
        let Some(start) = self.discover() else { return Entry::miss(self.clip.last, 0) };
        let limit = query.max_iterations.min(MAX_STEPS);
        let (origin, middle) = (self.clip.origin, start.pierced());
        let known = self.first_clearance(&start, &middle);
        let error = self.error(middle.residual, known);
        // The line pierces the first triangle somewhere in the set: certainly ahead of the origin,
        // certainly behind it, or neither.
        let is_ahead = middle.at - error >= origin;
        let is_behind = middle.at + error <= origin;
        let mut is_past = is_ahead;
        // The portal that is farthest along the line.
        let mut exit = start;
        if !is_ahead && middle.at < origin || is_behind {
            match self.refine(&mut exit, Sense::Exit, known, (0.0, limit)) {
                End::Missed => return Entry::miss(self.clip.last, 0),
                End::Passed if is_behind => return self.inside([&start, &exit]),
                _ if is_behind => return self.leaving(&exit),
                end => is_past = end == End::Passed,
            }
        }
        let mut entry = start;
        let end = self.refine(&mut entry, Sense::Entry, known, (query.gap, limit));
        match end {
            End::Missed => Entry::miss(self.clip.last, 0),
            End::Passed if is_ahead => self.inside([&entry, &start]),
            End::Passed => {
                exit = start;
                match self.refine(&mut exit, Sense::Exit, known, (0.0, limit)) {
                    End::Passed => self.inside([&entry, &exit]),
                    _ => self.leaving(&exit),
                }
            }
            End::OnSurface | End::Narrow | End::Limit => {
                let pierced = entry.pierced();
                let error = self.least_error(query, known, (&entry, &pierced));
                // A set that may contain the origin is ahead of it only if a point of it is.
                is_past |= self.clip.entry > origin || pierced.at - error >= origin;
                let is_certain = error < f64::INFINITY && is_past;
                // NaN takes the failing branch.
                if is_certain && pierced.at + error <= origin {
                    // The line certainly enters the set before its origin, and leaves it later.
                    self.inside([&entry, &exit])
                } else if is_certain {
                    self.enclose(query, end, Some(error), (&entry, pierced.at), &exit)
                } else {
                    let (entry, pierced) = self.safer([(entry, pierced), (start, middle)]);
                    self.enclose(query, end, None, (&entry, pierced.at), &exit)
                }
            }
        }
    }

    /// Step 4: error of the parameter at which the line pierces the entry, as small as the
    /// tolerance requires. `known` is a clearance.
    fn least_error(&mut self, query: &LineQuery, known: f64, (entry, pierced): (&Portal, &Pierced)) -> f64 {
        let mut error = self.error(pierced.residual, known);
        if error > ERROR_SHARE * query.tolerance {
            error = error.min(self.error_in(entry, pierced));
        }
        if error > ERROR_SHARE * query.tolerance {
            // A clearance with which the error is small enough.
            let enough = 2.0 * self.clip.reach * (pierced.residual + self.clip.noise) / (ERROR_SHARE * query.tolerance);
            let known = known.max(self.clearance(entry, enough));
            error = error.min(self.error(pierced.residual, known));
        }
        error
    }

    /// The portal to report for a line that may miss the set: the last one, or the first one if
    /// refinement lost the part of the set that the line grazes.
    fn safer(&mut self, [last, first]: [(Portal, Pierced); 2]) -> (Portal, Pierced) {
        // The line leaves the set before this plane, if it hits it at all.
        self.probe(DVec3::Z);
        let end = self.clip.upper;
        let off = |found: &Pierced| found.residual + (found.at - end).max(0.0);
        if off(&last.1) > off(&first.1) + self.clip.noise { first } else { last }
    }

    /// The answer from the portal where the line enters the set, at parameter `at`. `error` is the
    /// error of `at` if the hit is certain.
    fn enclose(
        &mut self,
        query: &LineQuery,
        end: End,
        error: Option<f64>,
        (entry, at): (&Portal, f64),
        exit: &Portal,
    ) -> Entry {
        let (open, moved) = (self.clip.lower - self.clip.entry, self.clip.error);
        let is_same = open <= EXACT_ERRORS * moved && open * self.clip.normal.dot(self.clip.direction).abs() <= moved;
        if !is_same {
            // The ball around the set is no plane, and it is farther out than this one, which is
            // moved outward by the error.
            self.probe(DVec3::NEG_Z);
        }
        let clip = &self.clip;
        // The upper bound may be beyond the limit of the ray: then the hit may be as well.
        let upper = error.map_or(clip.upper, |error| (at + error).max(clip.lower));
        let width = upper - clip.lower;
        let exact = EXACT_ERRORS * clip.error / clip.normal.dot(clip.direction).abs();
        // NaN takes the last branch.
        let status = match end {
            _ if error.is_none() => Status::Touching,
            End::OnSurface if width <= exact => Status::Exact,
            _ if width <= query.tolerance => Status::Within,
            End::Limit => Status::IterationLimit,
            _ => Status::Stalled,
        };
        let mut found = answer(clip, status, [clip.lower, at, upper], [entry, exit]);
        if found.upper == 0.0 {
            found.points = self.common_point(found.points);
        }
        found
    }

    /// The origin is certainly inside, between two portals.
    fn inside(&mut self, portals: [&Portal; 2]) -> Entry {
        let (status, normal) = (Status::Overlapping, -self.clip.direction);
        let points = points_at(&self.clip, self.clip.origin, portals);
        let points = self.common_point(points);
        Entry { status, at: 0.0, lower: 0.0, upper: 0.0, normal, points, iterations: 0 }
    }

    /// The common point of these two, if the line starts inside the set.
    fn common_point(&mut self, points: [DVec3; 2]) -> [DVec3; 2] {
        let (points, steps) = Bound::common_point(self.m, points, -self.clip.direction);
        self.steps += steps;
        points
    }

    /// The line leaves the set at its origin, within rounding error.
    fn leaving(&self, exit: &Portal) -> Entry {
        let clip = &self.clip;
        let found = answer(clip, Status::Touching, [clip.lower, clip.origin, clip.upper], [exit; 2]);
        Entry { normal: -clip.direction, ..found }
    }
}

/// The answer for an interval of the clip's parameter, from the portals where the line enters the
/// set and where it is farther along it.
fn answer(clip: &Clip, status: Status, [lower, at, upper]: [f64; 3], [entry, ahead]: [&Portal; 2]) -> Entry {
    let along = |parameter: f64, roundings: f64| {
        parameter - clip.origin + roundings * f64::EPSILON * (parameter.abs() + clip.origin.abs())
    };
    let (lower, upper) = (along(lower, -4.0).max(0.0), along(upper, 4.0).max(0.0));
    let at = along(at, 0.0);
    // NaN becomes the lower bound.
    let at = if at >= lower { at.min(upper) } else { lower };
    let normal = if clip.normal == DVec3::ZERO { -clip.direction } else { clip.normal };
    let points = points_at(clip, clip.origin + at, [entry, ahead]);
    Entry { status, at, lower, upper, normal, points, iterations: 0 }
}

/// The points of A, and of B after its motion, at a parameter of the line: the points of the entry,
/// or, if it is behind, points between it and the portal ahead.
fn points_at(clip: &Clip, parameter: f64, [entry, ahead]: [&Portal; 2]) -> [DVec3; 2] {
    let points = |portal: &Portal| {
        let (pierced, corners) = (portal.pierced(), portal.corners.map(|corner| corner.point));
        let on_b = blend(&pierced.weights, corners.map(|point| point.b()));
        (pierced.at, blend(&pierced.weights, corners.map(|point| point.a)), on_b)
    };
    let (from, mut on_a, mut on_b) = points(entry);
    if parameter - from > clip.noise {
        let (to, far_a, far_b) = points(ahead);
        // NaN, from a portal that is not ahead, takes the failing branch.
        if to > from {
            let share = ((parameter - from) / (to - from)).min(1.0);
            (on_a, on_b) = (on_a.lerp(far_a, share), on_b.lerp(far_b, share));
        }
    }
    [on_a, on_b + clip.direction * (parameter - clip.origin)]
}
