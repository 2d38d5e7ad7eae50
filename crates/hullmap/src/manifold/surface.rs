//! Points of a patch on the surfaces of both shapes.
//!
//! Clipping takes heights from features. A feature that is flat lies on the surface. Others do not:
//! faces that were merged, or corners of a curved surface. There, a ray along the normal finds the
//! surface.

#![forbid(unsafe_code)]

use super::clip::{Frame, PatchPoint};
use crate::pose::Pose;
use crate::shapes::Shape;
use crate::solver::ray::ray;
use crate::solver::{CastSettings, Ray, Status};
use glam::DVec3;

/// Tolerance of a height, relative to the shape's outer radius: ten times the rounding error of
/// f32 vertices. Polytopes are exact in a few steps whatever it is.
const TOLERANCE: f64 = 1e-6;

/// Moves a point of the patch to the surfaces of A and B along the normal of `frame`, from `above`
/// both surfaces: a length. Returns false if a surface is not there.
pub(super) fn settle<A: Shape + ?Sized, B: Shape + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    frame: &Frame,
    above: f64,
    point: &mut PatchPoint,
) -> bool {
    let [on_a, on_b] = point.exact;
    if !on_a {
        let Some(t) = entry(a, frame.point(point.at, above), -frame.normal) else { return false };
        point.heights[0] = above - t;
    }
    if !on_b && !settle_b((b, b_in_a), frame, above, point) {
        return false;
    }
    point.exact = [true; 2];
    true
}

/// The same for the surface of B alone.
pub(super) fn settle_b<B: Shape + ?Sized>(
    (b, b_in_a): (&B, Pose),
    frame: &Frame,
    above: f64,
    point: &mut PatchPoint,
) -> bool {
    let inverse = b_in_a.inverse();
    let from = inverse.transform_point(frame.point(point.at, -above));
    let Some(t) = entry(b, from, inverse.transform_vector(frame.normal)) else { return false };
    point.heights[1] = t - above;
    true
}

/// How far a ray from outside of the shape goes until it enters.
fn entry<S: Shape + ?Sized>(shape: &S, from: DVec3, direction: DVec3) -> Option<f64> {
    let settings = CastSettings { tolerance: TOLERANCE, ..CastSettings::default() };
    let hit = ray(shape, &Ray::new(from, direction).ok()?, &settings);
    matches!(hit.status, Status::Exact | Status::Within).then_some(hit.t)
}
