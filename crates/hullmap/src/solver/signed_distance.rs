//! Signed distance of a point from a shape, with the closest point of the surface.
//!
//! # Steps
//! 1. Compute the distance between the shape and the point (GJK).
//! 2. If the point is not certainly outside, compute its penetration depth (EPA).

use glam::DVec3;

use super::cache::Cache;
use super::gjk::{self, Simplex};
use super::minkowski::Minkowski;
use super::motion::{VectorError, checked};
use super::queries::{contact, distance};
use super::ray::Dot;
use super::settings::Settings;
use super::status::Status;
use crate::fields::fields;
use crate::pose::Pose;
use crate::support::SupportMap;

/// Answer of [`signed_distance`](crate::signed_distance()).
///
/// Lengths are in the shape's unit, points and directions in its frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignedDistance {
    /// How the query ended. [`Separated`](Status::Separated) and
    /// [`Overlapping`](Status::Overlapping) do not occur: the sign of the distance gives that
    /// information.
    pub status: Status,
    /// Distance from the surface: positive outside, negative inside.
    pub distance: f64,
    /// Lower bound of the distance, with allowance for rounding error. Positive only if the point
    /// is certainly outside.
    pub lower: f64,
    /// Upper bound of the distance, with allowance for rounding error. Negative only if the point
    /// is certainly inside.
    pub upper: f64,
    /// The point of the surface that is closest to the query point.
    pub point: DVec3,
    /// Unit outward normal of the surface at `point`: the gradient of the distance.
    pub normal: DVec3,
    /// Number of steps of all phases together.
    pub iterations: u32,
    /// Number of support calls.
    pub support_calls: u32,
    /// Index of the part that decided the answer: the hull of a pack, the triangle of a mesh or a
    /// field. 0 for a shape without parts.
    pub part: u32,
}

fields!(SignedDistance { status distance lower upper point normal iterations support_calls part });

impl Default for SignedDistance {
    /// An answer that claims nothing.
    fn default() -> Self {
        Self {
            status: Status::Stalled,
            distance: 0.0,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            point: DVec3::ZERO,
            normal: DVec3::X,
            iterations: 0,
            support_calls: 0,
            part: 0,
        }
    }
}

/// [`signed_distance`](crate::signed_distance()) from a convex shape.
pub(crate) fn signed_distance<S: SupportMap + ?Sized>(
    shape: &S,
    point: DVec3,
    settings: &Settings,
    cache: &mut Cache,
) -> Result<SignedDistance, VectorError> {
    let place = Pose::from_checked(checked("point", point)?);
    let outside = distance(shape, &Dot, place, settings, cache);
    let mut found = SignedDistance {
        status: outside.status,
        distance: outside.distance,
        lower: outside.lower,
        upper: outside.upper,
        point: outside.point_a,
        normal: outside.normal,
        iterations: outside.iterations,
        support_calls: outside.support_calls,
        part: 0,
    };
    if outside.lower > 0.0 {
        return Ok(found);
    }
    let inside = contact(shape, &Dot, place, settings, cache);
    found.iterations += inside.iterations;
    found.support_calls += inside.support_calls;
    if !inside.hit {
        return Ok(found);
    }
    found.lower = -inside.depth_upper;
    if inside.depth_lower > 0.0 {
        found.upper = -inside.depth_lower;
    }
    if inside.depth > 0.0 || outside.status == Status::Overlapping {
        found.status = inside.status;
        found.distance = -inside.depth;
        (found.point, found.normal) = (inside.point_a, inside.normal);
    }
    Ok(found)
}

/// Whether `point` is in `shape`, or not certainly farther than `radius` from it. Both are in the
/// shape's frame. GJK alone decides it, on a small stack; at the surface of thin shapes, EPA would
/// distinguish inside from outside, which does not matter here.
pub(crate) fn is_near<S: SupportMap + ?Sized>(shape: &S, point: DVec3, radius: f64) -> bool {
    let Ok(place) = Pose::from_translation(point) else { return false };
    let mut m = Minkowski::new(shape, &Dot, place);
    if m.inner_balls_overlap() {
        return true;
    }
    let (mut simplex, radius) = (Simplex::new(m.center_point()), shape.convex_radius() + radius);
    let Settings { tolerance, max_iterations } = Settings::default();
    let found = m.closest_within(&mut simplex, radius, tolerance, max_iterations);
    found.end == gjk::End::Inside || found.lower <= radius + m.rounding_error()
}
