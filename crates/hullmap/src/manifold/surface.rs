//! Points of a patch on the surfaces of both shapes.
//!
//! Clipping takes heights from features. A feature that is flat lies on the surface. Others do not:
//! faces that were merged, or corners of a curved surface. There, a ray along the normal finds the
//! surface.

#![forbid(unsafe_code)]

use super::clip::{Body, Frame, PatchPoint, nearest_on};
use crate::pose::Pose;
use crate::shapes::{Corner, Feature, Shape};
use crate::solver::Ray;
use glam::{DVec2, DVec3};

/// Distance by which a point moves inward if a ray misses the surface there, relative to the
/// smaller shape's outer radius: ten times the slack of clipping. Rays miss at the corners of discs
/// that lie on each other, and a stack falls if these have no points.
pub(super) const INWARD: f64 = 1e-5;

/// Moves a point of the patch to the surfaces of A and B along the normal of `frame`, from `above`
/// both surfaces: a length. Returns false if a surface is not there. `features` are the features of
/// A and of B, in A's frame.
pub(super) fn settle<A: Shape + ?Sized, B: Shape + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    frame: &Frame,
    features: &[Feature; 2],
    above: f64,
    point: &mut PatchPoint,
) -> bool {
    let [on_a, on_b] = point.exact;
    let lengths = [above, f64::INFINITY];
    if !on_a && !settle_a(a, frame, nearest(&features[0], frame, point.at).0, lengths, point) {
        return false;
    }
    if !on_b && !settle_b((b, b_in_a), frame, nearest(&features[1], frame, point.at).0, lengths, point) {
        return false;
    }
    point.exact = [true; 2];
    true
}

/// The contact's own point, between its points on A and on B, on both surfaces, from `above` them;
/// `None` if a surface is not there. `reach` is the smaller outer radius.
///
/// If the contact has stalled, or a curved shape meets an edge, its two points are not on a line
/// along the normal. Then one of them is taken that is on its surface: on a polytope, or on any
/// shape if the interval is narrow. Otherwise the support point of one shape is taken, and the
/// place on the other one's face that is nearest to it, or on the line through it.
pub(super) fn witness<A: Shape + ?Sized, B: Shape + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    (frame, features): (&Frame, &[Feature; 2]),
    [above, reach]: [f64; 2],
    (point, points, are_on_surface): (PatchPoint, [DVec3; 2], bool),
) -> Option<PatchPoint> {
    let settled = |mut point: PatchPoint| settle((a, b, b_in_a), frame, features, above, &mut point).then_some(point);
    if let Some(found) = settled(point) {
        return Some(found);
    }
    let through = |on: DVec3, exact| {
        let heights = [(on - frame.origin).dot(frame.normal); 2];
        settled(PatchPoint { at: frame.projected(on), heights, exact, ..point })
    };
    let is_on = [a.polytope_vertex(0), b.polytope_vertex(0)].map(|vertex| vertex.is_some() || are_on_surface);
    let own = is_on[0].then(|| through(points[0], [true, false])).flatten();
    let own = own.or_else(|| is_on[1].then(|| through(points[1], [false, true])).flatten());
    if let Some(found) = own
        .or_else(|| inward((a, b, b_in_a), frame, point.at, reach).find_map(|at| settled(PatchPoint { at, ..point })))
    {
        return Some(found);
    }
    let (on_a, on_b) = (a.support_point(frame.normal), b.support_point(b_in_a.inverse_transform_vector(-frame.normal)));
    let on_a = Corner { point: on_a.point, vertex: on_a.feature };
    let on_b = Corner { point: b_in_a.transform_point(on_b.point), vertex: on_b.feature };
    let [face_a, face_b] = features;
    let over = |face, corner, body| nearest_on(face, (corner, body), frame, reach).and_then(settled);
    over(face_a, &on_b, Body::B)
        .or_else(|| over(face_b, &on_a, Body::A))
        .or_else(|| through(on_b.point, [false, true]))
        .or_else(|| through(on_a.point, [true, false]))
}

/// Places beside `at` that are farther inside of A, of B, or of both, seen along the normal. Where
/// two edges cross, a ray through their common point misses one of them by rounding error.
fn inward<A: Shape + ?Sized, B: Shape + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    frame: &Frame,
    at: DVec2,
    reach: f64,
) -> impl Iterator<Item = DVec2> {
    let towards = |middle: DVec3| (frame.projected(middle) - at).normalize_or_zero();
    let [to_a, to_b] = [towards(a.interior_point()), towards(b_in_a.transform_point(b.interior_point()))];
    [(to_a + to_b).normalize_or_zero(), to_a, to_b].into_iter().map(move |way| at + way * (INWARD * reach))
}

/// [`settle`] for the surface of A alone, up to the length `until` from there. `near` is a vertex
/// of A close to the point.
pub(super) fn settle_a<A: Shape + ?Sized>(
    a: &A,
    frame: &Frame,
    near: u32,
    [above, until]: [f64; 2],
    point: &mut PatchPoint,
) -> bool {
    let Some(t) = entry(a, frame.point(point.at, above), -frame.normal, near, until) else { return false };
    point.heights[0] = above - t;
    true
}

/// As [`settle_a`], for B.
pub(super) fn settle_b<B: Shape + ?Sized>(
    (b, b_in_a): (&B, Pose),
    frame: &Frame,
    near: u32,
    [above, until]: [f64; 2],
    point: &mut PatchPoint,
) -> bool {
    let inverse = b_in_a.inverse();
    let from = inverse.transform_point(frame.point(point.at, -above));
    let Some(t) = entry(b, from, inverse.transform_vector(frame.normal), near, until) else { return false };
    point.heights[1] = t - above;
    true
}

/// How far a ray from outside of the shape goes until it enters.
fn entry<S: Shape + ?Sized>(shape: &S, from: DVec3, direction: DVec3, near: u32, until: f64) -> Option<f64> {
    shape.entry(&Ray::new(from, direction).ok()?, near, until)
}

/// The vertex of a corner of `feature` that is nearest to the place `at`, and how far it is.
pub(super) fn nearest(feature: &Feature, frame: &Frame, at: DVec2) -> (u32, f64) {
    let distance = |corner: DVec3| frame.projected(corner).distance_squared(at);
    let corners = feature.corners().iter().map(|corner| (distance(corner.point), corner.vertex));
    corners.min_by(|p, q| p.0.total_cmp(&q.0)).map_or((0, f64::INFINITY), |(square, vertex)| (vertex, square.sqrt()))
}
