//! Contact, distance and intersection of any shapes: those with a rounded core by solving the cores and adding the radii.
//!
//! A sphere is a rounded point, a capsule a rounded segment, a [`Rounded`](crate::shapes::Rounded) hull a hull and a radius. On
//! the round shape itself the expansion cuts facets off a curved surface, one a step; on the core it ends after as many
//! steps as the core has facets nearby. For shapes without a core these are the functions of [`solver`].
//!
//! # Reference
//! van den Bergen, "Collision Detection in Interactive 3D Environments", 4.3.3 and 4.5; the identity: with C the cores'
//! Minkowski difference and r the sum of the radii, the shapes' difference is C plus a ball of radius r. If the origin is at
//! distance d from C, the shapes are d − r apart, or r − d deep; if it is t deep in C, they are t + r deep.
//!
//! # Steps
//! 1. distance of the cores, as exactly as is asked; if the difference to r is then not known as exactly, once or twice more;
//! 2. cores that overlap: their contact.
//!
//! # Deviations
//! - Depth from a distance is computed at all depths short of overlapping cores, so the normal is that of the closest points and not of a
//!   nearest facet: exact for shapes that touch at one point.

#![forbid(unsafe_code)]

use crate::minkowski::unit;
use crate::{Cache, Contact, Distance, Intersection, Overlap, Pose, Settings, Status, Support, SupportMap, solver};
use glam::DVec3;

/// Rounding of the radii's sum and of a difference, in units of rounding of the greatest length.
const ROUNDING_UNITS: f64 = 8.0;

/// Uncertainties up to this many roundings are called touching; the solver's own distances are uncertain by some 16 of them.
const TOUCHING_ROUNDINGS: f64 = 64.0;

/// The same for what support points are short of: on both ends of an interval, twice.
const TOUCHING_SHORTFALLS: f64 = 8.0;

/// A shape's core as a shape.
struct Core<'s, S: ?Sized>(&'s S);

impl<S: SupportMap + ?Sized> SupportMap for Core<'_, S> {
    fn support(&self, dir: DVec3) -> Support {
        self.0.core_support(dir)
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

/// How the cores lie.
enum Cores {
    /// Apart by `gap.distance`, proved.
    Apart(Distance),
    /// They share a point, or it cannot be told that they do not.
    Overlapping(Distance),
}

/// Most searches for the cores' distance. Each knows the difference to the radii better than the one before, and so how exact the next
/// has to be.
const MOST_SEARCHES: usize = 3;

/// Distance of the cores, exact enough for its difference to `radius` to be known within the tolerance.
fn cores<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    radius: f64,
    settings: &Settings,
    cache: &mut Cache,
) -> Cores {
    let (a, b) = (Core(a), Core(b));
    let mut gap = solver::distance(&a, &b, b_in_a, settings, cache);
    if matches!(gap.status, Status::Overlapping | Status::Touching) {
        return Cores::Overlapping(gap);
    }
    for _ in 1..MOST_SEARCHES {
        let left = (gap.distance - radius).abs();
        // NaN takes the branch that tries again.
        if gap.upper - gap.lower <= settings.relative_gap() * left {
            break;
        }
        let settings = Settings { tolerance: settings.relative_gap() * (left / gap.distance).min(1.0), ..*settings };
        let (iterations, support_calls) = (gap.iterations, gap.support_calls);
        gap = solver::distance(&a, &b, b_in_a, &settings, cache);
        gap.iterations += iterations;
        gap.support_calls += support_calls;
    }
    if gap.lower > 0.0 { Cores::Apart(gap) } else { Cores::Overlapping(gap) }
}

/// What the sum of radii and a difference to it may be wrong by.
fn rounding(radius: f64, distance: f64) -> f64 {
    ROUNDING_UNITS * f64::EPSILON * (radius + distance)
}

/// Width of an interval, and length of a touch, that is rounding alone: a length. The cores' own is in units of what the shapes reach.
fn hair<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(a: &A, b: &B, b_in_a: Pose) -> f64 {
    let [center_a, center_b] = [a.interior_point(), b.interior_point()].map(|p| p.length());
    let reach = a.outer_radius() + b.outer_radius() + center_a + center_b + b_in_a.translation().length();
    TOUCHING_ROUNDINGS * rounding(reach, 0.0) + TOUCHING_SHORTFALLS * (a.support_error() + b.support_error())
}

/// The way out of the cores between their nearest points, of unit length: with it the rounded shapes' points are as far apart as the
/// distance says. The normal is that of the planes which prove the lower bound, and a little another.
fn outward(gap: &Distance, hair: f64) -> DVec3 {
    unit(gap.point_b - gap.point_a).filter(|_| gap.point_a.distance(gap.point_b) > hair).unwrap_or(gap.normal)
}

/// The status of an interval that follows from that of the cores' `status`.
fn status_of(status: Status, [lower, upper]: [f64; 2], tolerance: f64, hair: f64) -> Status {
    let width = upper - lower;
    // NaN takes the last branch.
    match status {
        _ if width <= hair => Status::Exact,
        _ if width <= tolerance * upper + hair => Status::Within,
        Status::IterationLimit => Status::IterationLimit,
        _ => Status::Stalled,
    }
}

/// Contact of `a` and of `b` placed at `b_in_a`: the shortest way to push B out of A; by their cores where they have any.
///
/// `cache` belongs to this ordered pair; it is read and brought up to date. See [`solver::contact`] for what is returned of
/// shapes without cores.
///
/// # Complexity
/// That of the distance of the cores, three times at most; if the cores overlap, their contact too. No allocation.
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::{Capsule, Sphere};
/// use hullmap::{Cache, Pose, Settings, contact};
///
/// let (capsule, ball) = (Capsule::new(1.0, 0.5)?, Sphere::new(0.25)?);
/// let b_in_a = Pose::from_translation(DVec3::new(0.6, 0.0, 0.3))?;
/// let c = contact(&capsule, &ball, b_in_a, &Settings::default(), &mut Cache::new());
/// assert!(c.hit && (c.depth - 0.15).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn contact<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
) -> Contact {
    let radii = [a.rounding_radius(), b.rounding_radius()];
    let radius = radii[0] + radii[1];
    if !(radius > 0.0) {
        return solver::contact(a, b, b_in_a, settings, cache);
    }
    let tolerance = settings.relative_gap();
    match cores((a, b, b_in_a), radius, settings, cache) {
        Cores::Apart(gap) => {
            let (rounding, hair) = (rounding(radius, gap.upper), hair(a, b, b_in_a));
            let (lower, upper) = (radius - gap.upper - rounding, radius - gap.lower + rounding);
            let out = outward(&gap, hair);
            let mut found = Contact {
                hit: true,
                status: Status::Touching,
                depth: 0.0,
                depth_lower: 0.0,
                depth_upper: upper,
                normal: gap.normal,
                point_a: gap.point_a + out * radii[0],
                point_b: gap.point_b - out * radii[1],
                iterations: gap.iterations,
                support_calls: gap.support_calls,
            };
            if upper < 0.0 {
                (found.hit, found.status, found.depth_upper) = (false, Status::Separated, 0.0);
            } else if lower > 0.0 {
                (found.depth, found.depth_lower) = (radius - gap.distance, lower);
                found.status = status_of(gap.status, [lower, upper], tolerance, hair);
            } else if upper > hair {
                // Neither certainly deep nor only touching.
                found.depth = (radius - gap.distance).max(0.0);
                found.status = status_of(gap.status, [0.0, upper], tolerance, hair);
            }
            found
        }
        Cores::Overlapping(gap) => {
            let core = solver::contact(&Core(a), &Core(b), b_in_a, settings, cache);
            let rounding = rounding(radius, core.depth_upper);
            // Cores that are not certainly deep may be apart, by no more than their points are.
            let apart = if core.depth_lower > 0.0 { 0.0 } else { gap.upper };
            let lower = radius + core.depth_lower - rounding - apart;
            let upper = radius + core.depth_upper + rounding;
            Contact {
                hit: true,
                status: status_of(core.status, [lower, upper], tolerance, hair(a, b, b_in_a)),
                depth: radius + core.depth,
                depth_lower: lower.max(0.0),
                depth_upper: upper,
                normal: core.normal,
                point_a: core.point_a + core.normal * radii[0],
                point_b: core.point_b - core.normal * radii[1],
                iterations: gap.iterations + core.iterations,
                support_calls: gap.support_calls + core.support_calls,
            }
        }
    }
}

/// Distance of `a` and of `b` placed at `b_in_a`, with their nearest points; by their cores where they have any.
///
/// `cache` belongs to this ordered pair; it is read and brought up to date. See [`solver::distance`].
///
/// # Complexity
/// That of the distance of the cores, three times at most. No allocation.
pub fn distance<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
) -> Distance {
    let radii = [a.rounding_radius(), b.rounding_radius()];
    let radius = radii[0] + radii[1];
    if !(radius > 0.0) {
        return solver::distance(a, b, b_in_a, settings, cache);
    }
    let (Cores::Apart(gap) | Cores::Overlapping(gap)) = &mut cores((a, b, b_in_a), radius, settings, cache);
    let mut found = *gap;
    let (rounding, hair) = (rounding(radius, gap.upper), hair(a, b, b_in_a));
    let (lower, upper) = (gap.lower - radius - rounding, gap.upper - radius + rounding);
    // The nearest points move out by the radii; in an overlap that leaves points of both shapes between them.
    let overlap = (radius - gap.point_a.distance(gap.point_b)).clamp(0.0, radius);
    let (shares, out) = (radii.map(|r| r - overlap * (r / radius)), outward(gap, 0.0));
    found.point_a += out * shares[0];
    found.point_b -= out * shares[1];
    (found.lower, found.upper) = (lower.max(0.0), upper.max(0.0));
    found.distance = (gap.distance - radius).max(0.0);
    if upper < 0.0 || gap.status == Status::Overlapping {
        (found.status, found.distance, found.upper) = (Status::Overlapping, 0.0, 0.0);
    } else if lower <= 0.0 && upper <= hair && (gap.lower > 0.0 || gap.status == Status::Touching) {
        (found.status, found.distance) = (Status::Touching, 0.0);
    } else {
        // With a lower end of 0, neither certainly apart nor only touching: cores that are not proved to be apart may be deep.
        found.status = status_of(gap.status, [found.lower, upper], settings.relative_gap(), hair);
    }
    found
}

/// Whether `a` and `b`, placed at `b_in_a`, share a point; by their cores where they have any.
///
/// `cache` belongs to this ordered pair; it is read and brought up to date. See [`solver::intersects`].
///
/// # Complexity
/// That of the distance of the cores, three times at most. No allocation.
pub fn intersects<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    cache: &mut Cache,
) -> Intersection {
    if !(a.rounding_radius() + b.rounding_radius() > 0.0) {
        return solver::intersects(a, b, b_in_a, cache);
    }
    let Distance { status, lower, iterations, support_calls, .. } = distance(a, b, b_in_a, &Settings::default(), cache);
    let status = match status {
        Status::Overlapping => Overlap::Overlapping,
        Status::Touching => Overlap::Touching,
        _ if lower > 0.0 => Overlap::Separated,
        _ => {
            let mut found = intersects_by_depth(a, b, b_in_a, cache);
            found.iterations += iterations;
            found.support_calls += support_calls;
            return found;
        }
    };
    Intersection { status, iterations, support_calls }
}

/// The same from the depth, for cores so thin that no distance tells whether they are a hair apart or deep.
#[cold]
#[inline(never)]
fn intersects_by_depth<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    cache: &mut Cache,
) -> Intersection {
    let Contact { hit, status, depth_lower, iterations, support_calls, .. } =
        contact(a, b, b_in_a, &Settings::default(), cache);
    let status = match status {
        _ if !hit => Overlap::Separated,
        _ if depth_lower > 0.0 => Overlap::Overlapping,
        Status::Touching => Overlap::Touching,
        _ => Overlap::Undecided,
    };
    Intersection { status, iterations, support_calls }
}
