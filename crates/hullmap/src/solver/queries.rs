//! Contact, distance and intersection of any two convex shapes. Rounded shapes are solved by their
//! cores.
//!
//! On the curved surface itself EPA would cut off one facet per step. On the cores the search ends
//! after as many steps as the cores have facets nearby. Shapes without a convex radius go straight
//! to `core_contact`, `core_distance` and `core_intersects`.
//!
//! # Reference
//! van den Bergen, "Collision Detection in Interactive 3D Environments", 4.3.3 and 4.5. Let C be
//! the Minkowski difference of the cores and r the sum of the convex radii. The Minkowski
//! difference of the shapes is C plus a ball of radius r. If the origin is at distance d from C,
//! the shapes are separated by d − r, or penetrate by r − d. If the origin is at depth t in C, the
//! shapes penetrate by t + r.
//!
//! # Steps
//! 1. Compute the distance of the cores within the tolerance. If its difference to r is not yet
//!    known within the tolerance, search once or twice more.
//! 2. If the cores overlap, compute their contact.
//!
//! # Deviations
//! - The depth follows from the distance for all pairs whose cores are separated, not only for
//!   shallow contacts. So the normal comes from the closest points and not from a nearest facet.

#![forbid(unsafe_code)]

use super::answer::Contact;
use super::bound::{Bound, FOOT_ROUNDINGS};
use super::cache::Cache;
use super::contact::core_contact;
use super::distance::{Distance, core_distance};
use super::intersection::{Intersection, core_intersects};
use super::minkowski::Minkowski;
use super::mpr::Portal;
use super::settings::Settings;
use super::status::{Overlap, Status};
use crate::pose::Pose;
use crate::support::{SupportMap, SupportPoint};
use crate::vector::unit;
use glam::DVec3;

/// Rounding error of the sum of the radii and of its difference to a distance, in units of
/// `f64::EPSILON` times the sum of both.
const ROUNDING_UNITS: f64 = 8.0;

/// An interval up to this many rounding errors wide may be reported as touching. The intervals of
/// the cores are about 16 of them wide.
const TOUCHING_ROUNDINGS: f64 = 64.0;

/// Limit for the support errors of the shapes: they widen an interval at both ends, twice each.
const TOUCHING_SHORTFALLS: f64 = 8.0;

pub(super) struct Core<'s, S: ?Sized>(pub(super) &'s S);

impl<S: SupportMap + ?Sized> SupportMap for Core<'_, S> {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        self.0.core_support_point(dir)
    }
    fn interior_point(&self) -> DVec3 {
        self.0.interior_point()
    }
    fn inner_radius(&self) -> f64 {
        self.0.core_radii()[0]
    }
    fn outer_radius(&self) -> f64 {
        self.0.core_radii()[1]
    }
    fn support_error(&self) -> f64 {
        self.0.support_error()
    }
    fn point(&self, feature: u32) -> Option<DVec3> {
        self.0.core_point(feature)
    }
}

/// Maximum number of searches for the distance of the cores.
///
/// Each narrows the difference to the radii, from which the tolerance of the next one follows.
const MAX_SEARCHES: usize = 3;

/// Distance of the cores, accurate enough that its difference to `radius` is within the tolerance;
/// and whether it proves them separated.
fn solve_cores<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    radius: f64,
    settings: &Settings,
    cache: &mut Cache,
) -> (Distance, bool) {
    let (a, b) = (Core(a), Core(b));
    let mut gap = core_distance(&a, &b, b_in_a, settings, cache);
    if matches!(gap.status, Status::Overlapping | Status::Touching) {
        return (gap, false);
    }
    for _ in 1..MAX_SEARCHES {
        let remaining = (gap.distance - radius).abs();
        // NaN takes the branch that searches again.
        if gap.upper - gap.lower <= settings.relative_tolerance() * remaining {
            break;
        }
        let settings =
            Settings { tolerance: settings.relative_tolerance() * (remaining / gap.distance).min(1.0), ..*settings };
        let (iterations, support_calls) = (gap.iterations, gap.support_calls);
        gap = core_distance(&a, &b, b_in_a, &settings, cache);
        gap.iterations += iterations;
        gap.support_calls += support_calls;
    }
    (gap, gap.lower > 0.0)
}

/// Rounding error of the sum `radius` of the radii and of its difference to `distance`: a length.
pub(super) fn rounding(radius: f64, distance: f64) -> f64 {
    ROUNDING_UNITS * f64::EPSILON * (radius + distance)
}

/// Length up to which an interval or a penetration counts as touching.
///
/// Proportional to the reach of the shapes, as the rounding error of the cores' intervals is.
fn touching_length<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(a: &A, b: &B, b_in_a: Pose) -> f64 {
    let [center_a, center_b] = [a.interior_point(), b.interior_point()].map(|p| p.length());
    let reach = a.outer_radius() + b.outer_radius() + center_a + center_b + b_in_a.translation().length();
    TOUCHING_ROUNDINGS * rounding(reach, 0.0) + TOUCHING_SHORTFALLS * (a.support_error() + b.support_error())
}

/// Unit direction from the witness point of core A to the one of core B.
///
/// Witness points moved along it have exactly the reported distance. `gap.normal`, which may differ
/// slightly from it, serves where they are too close for a direction.
pub(super) fn outward(gap: &Distance, touching_length: f64) -> DVec3 {
    unit(gap.point_b - gap.point_a)
        .filter(|_| gap.point_a.distance(gap.point_b) > touching_length)
        .unwrap_or(gap.normal)
}

/// Witness points of rounded shapes: the witness points of their cores, moved outward by the radii.
/// If the shapes overlap, they move by less and meet in a common point.
pub(super) fn rounded_points(gap: &Distance, radii: [f64; 2]) -> [DVec3; 2] {
    let radius = radii[0] + radii[1];
    let overlap = (radius - gap.point_a.distance(gap.point_b)).clamp(0.0, radius);
    let ([on_a, on_b], out) = (radii.map(|r| r - overlap * (r / radius)), outward(gap, 0.0));
    [gap.point_a + out * on_a, gap.point_b - out * on_b]
}

/// Status of the interval `[lower, upper]`, given the status of the cores.
fn interval_status(status: Status, [lower, upper]: [f64; 2], tolerance: f64, touching_length: f64) -> Status {
    let width = upper - lower;
    // NaN takes the last branch.
    match status {
        _ if width <= touching_length => Status::Exact,
        _ if width <= tolerance * upper + touching_length => Status::Within,
        Status::IterationLimit => Status::IterationLimit,
        _ => Status::Stalled,
    }
}

/// [`contact`](crate::contact()) of two convex shapes.
pub(crate) fn contact<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
) -> Contact {
    if let (Some(a), Some(b)) = (a.erased(), b.erased()) {
        return contact(a, b, b_in_a, settings, cache);
    }
    let radii = [a.convex_radius(), b.convex_radius()];
    let radius = radii[0] + radii[1];
    if !(radius > 0.0) {
        return core_contact(a, b, b_in_a, settings, cache);
    }
    let (gap, is_separated) = solve_cores((a, b, b_in_a), radius, settings, cache);
    let (tolerance, touching_length) = (settings.relative_tolerance(), touching_length(a, b, b_in_a));
    let mut found = if is_separated {
        let rounding = rounding(radius, gap.upper);
        let (lower, upper) = (radius - gap.upper - rounding, radius - gap.lower + rounding);
        let mut found = Contact {
            hit: true,
            status: Status::Touching,
            depth_upper: upper,
            normal: gap.normal,
            iterations: gap.iterations,
            support_calls: gap.support_calls,
            ..Contact::default()
        };
        let mut out = outward(&gap, touching_length);
        if upper < 0.0 {
            (found.hit, found.status, found.depth_upper) = (false, Status::Separated, 0.0);
        } else if lower > 0.0 {
            (found.depth, found.depth_lower) = (radius - gap.distance, lower);
            found.status = interval_status(gap.status, [lower, upper], tolerance, touching_length);
            if gap.distance < found.depth {
                // The direction of points so near to each other is less certain than the normal.
                out = gap.normal;
            }
        } else if upper > touching_length {
            // Neither certainly penetrating nor certainly touching.
            found.depth = (radius - gap.distance).max(0.0);
            found.status = interval_status(gap.status, [0.0, upper], tolerance, touching_length);
        } else if !(-lower <= touching_length) {
            // No plane separates the shapes, and no points are near enough to touch.
            found.status = Status::Stalled;
        }
        (found.point_a, found.point_b) = (gap.point_a + out * radii[0], gap.point_b - out * radii[1]);
        // The depth falls from the other normals to the normal of the closest points.
        found.with_others(upper + gap.lower, a.outer_radius() + b.outer_radius())
    } else {
        let core = overlapping_cores((&a, &b, b_in_a), settings, cache);
        let rounding = rounding(radius, core.depth_upper);
        // Cores that do not certainly penetrate may be separated, by at most the distance of their
        // witness points.
        let separation = if core.depth_lower > 0.0 { 0.0 } else { gap.upper };
        let lower = radius + core.depth_lower - rounding - separation;
        let upper = radius + core.depth_upper + rounding;
        Contact {
            hit: true,
            status: interval_status(core.status, [lower, upper], tolerance, touching_length),
            depth: radius + core.depth,
            depth_lower: lower.max(0.0),
            depth_upper: upper,
            point_a: core.point_a + core.normal * radii[0],
            point_b: core.point_b - core.normal * radii[1],
            iterations: gap.iterations + core.iterations,
            support_calls: gap.support_calls + core.support_calls,
            ..core
        }
    };
    settle((a, b, b_in_a), &mut found, [tolerance, touching_length]);
    found
}

/// The contact of cores that overlap, which is rare. It is compiled once, without the types of the
/// shapes, and not for each pair of types: that takes 2 to 5 % longer.
#[cold]
#[inline(never)]
fn overlapping_cores(
    (a, b, b_in_a): (&dyn SupportMap, &dyn SupportMap, Pose),
    settings: &Settings,
    cache: &mut Cache,
) -> Contact {
    core_contact(&Core(a), &Core(b), b_in_a, settings, cache)
}

/// Settles a contact of rounded shapes whose witness points are not opposite each other along the
/// normal: the normal may belong to a plane other than the closest points', or the cores may have
/// left the points unsettled. `tolerance` and `touching_length` are the same as for the status.
fn settle<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    found: &mut Contact,
    [tolerance, touching_length]: [f64; 2],
) {
    let Contact { depth_lower: lower, depth_upper: upper, normal, point_a, point_b, .. } = *found;
    let mut bound = Bound { upper, normal, point_a, point_b };
    // NaN takes the search.
    if !found.hit || bound.off() <= upper - lower {
        return;
    }
    let mut m = Minkowski::new(a, b, b_in_a);
    let slack = FOOT_ROUNDINGS * m.rounding_error();
    let status = |lower: f64, upper: f64| {
        let status = interval_status(found.status, [lower, upper], tolerance, touching_length);
        Some(status).filter(|status| matches!(status, Status::Exact | Status::Within))
    };
    if matches!(found.status, Status::Exact | Status::Within) {
        // The direction from one point to the other may be as good a normal.
        let between = point_a - point_b;
        if let Some(out) = unit(between)
            && between.dot(normal) >= lower
            && let upper = m.point(out).w.dot(out) + m.rounding_error()
            && let Some(status) = status(lower, upper)
        {
            (found.status, found.normal, found.depth_upper) = (status, out, upper);
            found.depth = found.depth.min(upper);
            found.support_calls += m.support_calls();
            return;
        }
        found.iterations += bound.search(&mut m, &[], upper - lower);
        // The interval is as wide as the points are off. NaN takes the last branch.
        let off = bound.off();
        match status(upper - off, upper) {
            _ if off <= upper - lower + slack => {}
            Some(status) if off <= upper + slack => {
                (found.status, found.depth_lower) = (status, (upper - off).max(0.0));
            }
            // The points are farther from each other than the shapes are deep.
            _ if lower == 0.0 && off <= touching_length => (found.status, found.depth) = (Status::Touching, 0.0),
            _ => found.status = Status::Stalled,
        }
    }
    if found.depth_lower > 0.0 {
        bound.deepen(found.depth_lower - slack, |normal| m.point(normal));
    }
    found.support_calls += m.support_calls();
    (found.point_a, found.point_b) = (bound.point_a, bound.point_b);
}

/// [`distance`](crate::distance()) of two convex shapes.
pub(crate) fn distance<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
) -> Distance {
    if let (Some(a), Some(b)) = (a.erased(), b.erased()) {
        return distance(a, b, b_in_a, settings, cache);
    }
    let radii = [a.convex_radius(), b.convex_radius()];
    let radius = radii[0] + radii[1];
    if !(radius > 0.0) {
        return core_distance(a, b, b_in_a, settings, cache);
    }
    let (gap, _) = solve_cores((a, b, b_in_a), radius, settings, cache);
    let mut found = gap;
    let (rounding, touching_length) = (rounding(radius, gap.upper), touching_length(a, b, b_in_a));
    let (lower, upper) = (gap.lower - radius - rounding, gap.upper - radius + rounding);
    [found.point_a, found.point_b] = rounded_points(&gap, radii);
    (found.lower, found.upper) = (lower.max(0.0), upper.max(0.0));
    found.distance = (gap.distance - radius).max(0.0);
    if upper < 0.0 || gap.status == Status::Overlapping {
        (found.status, found.distance, found.upper) = (Status::Overlapping, 0.0, 0.0);
    } else if lower <= 0.0 && upper <= touching_length && (gap.lower > 0.0 || gap.status == Status::Touching) {
        (found.status, found.distance) = (Status::Touching, 0.0);
    } else {
        // A lower bound of 0 is neither certainly separated nor certainly touching: cores that are
        // not certainly separated may penetrate.
        found.status =
            interval_status(gap.status, [found.lower, upper], settings.relative_tolerance(), touching_length);
    }
    found
}

/// [`intersects`](crate::intersects()) of two convex shapes.
pub(crate) fn intersects<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    cache: &mut Cache,
) -> Intersection {
    if let (Some(a), Some(b)) = (a.erased(), b.erased()) {
        return intersects(a, b, b_in_a, cache);
    }
    if !(a.convex_radius() + b.convex_radius() > 0.0) {
        return core_intersects(a, b, b_in_a, cache);
    }
    let Distance { status, lower, iterations, support_calls, .. } = distance(a, b, b_in_a, &Settings::default(), cache);
    let status = match status {
        Status::Overlapping => Overlap::Overlapping,
        Status::Touching => Overlap::Touching,
        _ if lower > 0.0 => Overlap::Separated,
        _ => {
            let mut found = intersects_by_depth(&a, &b, b_in_a, cache);
            found.iterations += iterations;
            found.support_calls += support_calls;
            return found;
        }
    };
    Intersection { status, iterations, support_calls, parts: [0; 2] }
}

/// The same from the depth, for cores so thin that the distance cannot decide.
#[cold]
#[inline(never)]
fn intersects_by_depth(a: &dyn SupportMap, b: &dyn SupportMap, b_in_a: Pose, cache: &mut Cache) -> Intersection {
    let Contact { hit, status, depth_lower, iterations, support_calls, .. } =
        contact(a, b, b_in_a, &Settings::default(), cache);
    let status = match status {
        _ if !hit => Overlap::Separated,
        _ if depth_lower > 0.0 => Overlap::Overlapping,
        Status::Touching => Overlap::Touching,
        _ => Overlap::Undecided,
    };
    Intersection { status, iterations, support_calls, parts: [0; 2] }
}

/// Whether the points closest to the origin that the last [`distance`] query found prove under this
/// pose that `a` and `b` overlap by more than `depth`, a length of at least 0.
///
/// It is for a pose nearby, in which the shapes have just met. Rounded shapes are not proven.
///
/// # Complexity
/// No support query.
pub(crate) fn overlap_by_simplex<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    depth: f64,
    cache: &Cache,
) -> bool {
    let &[first, second, third] = cache.simplex() else { return false };
    if a.convex_radius() + b.convex_radius() > 0.0 {
        return false;
    }
    let m = Minkowski::new(a, b, b_in_a);
    let Some(mut portal) = Portal::recall(&m, [first, second, third]) else { return false };
    let v0 = m.center_point().w;
    if !portal.faces_away(v0) {
        portal.vertices.swap(1, 2);
    }
    portal.holds_origin(v0, m.inner_radius(), m.rounding_error() + depth)
}
