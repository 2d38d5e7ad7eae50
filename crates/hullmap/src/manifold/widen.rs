//! Points farther out, under a body that would tip on those that were found.

use glam::{DVec2, DVec3};

use super::clip::{FACE, Frame, Patch, PatchPoint};
use super::lengths::Lengths;
use super::select::{Choice, SAME_PLACE, Spot};
use super::surface::{nearest, settle_a, settle_b};
use crate::pose::Pose;
use crate::shapes::feature::tilted_toward;
use crate::shapes::{Feature, Shape, TILT};
use crate::support::SupportPoint;

/// Distance from the centre, relative to the smaller shape's outer radius, of a point on which a
/// body balances.
const BALANCED: f64 = 0.05;

/// Distance of a corner, relative to the outer radius, up to which a walk to a place from there is
/// short.
const NEAR: f64 = 0.2;

/// Tangent of the maximum angle between the normal and a direction in which a tipping body's far
/// side is searched for.
const STEEPEST: f64 = 1.0;

/// The centre of the smaller body, in the plane perpendicular to the normal of `frame`.
pub(super) fn center<A: Shape + ?Sized, B: Shape + ?Sized>((a, b, b_in_a): (&A, &B, Pose), frame: &Frame) -> DVec2 {
    let a_is_smaller = a.outer_radius() < b.outer_radius();
    frame.projected(if a_is_smaller { a.interior_point() } else { b_in_a.transform_point(b.interior_point()) })
}

/// Whether the smaller body tips on the chosen points: its centre is not over them, and not close
/// to one of them, as a ball's centre is.
pub(super) fn tips(choice: &Choice, spots: &[Spot], center: DVec2, lengths: &Lengths) -> bool {
    let is_close = |i: &usize| spots[*i].at.distance(center) <= BALANCED * lengths.reach;
    !choice.is_below(spots, center) && !choice.indices().iter().any(is_close)
}

/// The mean of the chosen points.
pub(super) fn middle(choice: &Choice, patch: &Patch) -> DVec2 {
    let indices = choice.indices();
    indices.iter().map(|i| patch.points()[*i].at).sum::<DVec2>() / indices.len().max(1) as f64
}

/// Adds vertices of the smaller body that are farther out and within the prediction of the other
/// one.
///
/// A body whose centre is not over its points tips, to where it has none. If the body is small or
/// deep in the other one, its far side is in there as well, or will be in the next frame.
pub(super) fn widen<A: Shape + ?Sized, B: Shape + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    patch: &mut Patch,
    [from, toward]: [DVec2; 2],
    (frame, features): (&Frame, &[Feature; 2]),
    lengths: &Lengths,
) {
    // A flat shape has no side that is farther out than its face.
    let a_is_smaller = a.outer_radius() < b.outer_radius();
    if !(if a_is_smaller { a.inner_radius() } else { b.inner_radius() } > 0.0) {
        return;
    }
    let (own, other) = if a_is_smaller { (&features[0], &features[1]) } else { (&features[1], &features[0]) };
    let mut last = None;
    let mut add = |point: DVec3, vertex: u32| {
        // Directions beside each other often have the same support point.
        if last.replace(vertex) == Some(vertex) {
            return;
        }
        let at = frame.projected(point);
        if (at - from).dot(toward) <= 0.0 {
            return;
        }
        let heights = [(point - frame.origin).dot(frame.normal); 2];
        // The other surface is at most half of the depth beyond the origin.
        let below = if a_is_smaller { -heights[0] } else { heights[1] };
        if 0.5 * lengths.depth - below - least_drop(other, frame, at) < -lengths.prediction {
            return;
        }
        let parts = if a_is_smaller { [[vertex; 2], FACE] } else { [FACE, [vertex; 2]] };
        let is_same = |known: &PatchPoint| known.parts == parts || known.at.distance(at) <= SAME_PLACE * lengths.reach;
        if patch.points().iter().any(is_same) {
            return;
        }
        let mut point = PatchPoint { at, heights, exact: [true; 2], is_moved: false, parts };
        let above = lengths.height_above();
        let until = above - below + lengths.prediction;
        let is_there = if a_is_smaller {
            let near = vertex_near((b, b_in_a), other, frame, at, -1.0);
            settle_b((b, b_in_a), frame, near, [above, until], &mut point)
        } else {
            let near = vertex_near((a, Pose::IDENTITY), other, frame, at, 1.0);
            settle_a(a, frame, near, [above, until], &mut point)
        };
        if is_there && point.depth() >= -lengths.prediction {
            patch.push(point);
        }
    };
    let toward = frame.vector(toward);
    if own.fall() > tilt(lengths) {
        own.corners().iter().for_each(|corner| add(corner.point, corner.vertex));
    } else if a_is_smaller {
        farther_out(a, frame.normal, toward, lengths).for_each(|support| add(support.point, support.feature));
    } else {
        let [dir, toward] = [-frame.normal, toward].map(|v| b_in_a.inverse_transform_vector(v));
        for support in farther_out(b, dir, toward, lengths) {
            add(b_in_a.transform_point(support.point), support.feature);
        }
    }
}

/// A vertex of a shape near the place `at`, on the side of `sign` times the normal of `frame`: a
/// corner of its feature, or the support point along the normal of a ball around the shape there.
fn vertex_near<S: Shape + ?Sized>(
    (shape, pose): (&S, Pose),
    feature: &Feature,
    frame: &Frame,
    at: DVec2,
    sign: f64,
) -> u32 {
    let (corner, distance) = nearest(feature, frame, at);
    if distance <= NEAR * shape.outer_radius() {
        return corner;
    }
    let side = (at - frame.projected(pose.transform_point(shape.interior_point()))) / shape.outer_radius();
    let normal = frame.vector(side) + frame.normal * (sign * (1.0 - side.length_squared()).max(0.0).sqrt());
    shape.support_point(pose.inverse_transform_vector(normal)).feature
}

/// The least distance of the surface of a shape from its support plane at the place `at`.
fn least_drop(feature: &Feature, frame: &Frame, at: DVec2) -> f64 {
    let beside = match *feature.corners() {
        [vertex] => frame.projected(vertex.point).distance(at),
        [start, end] => {
            let [start, end] = [start, end].map(|corner| frame.projected(corner.point));
            (end - start).perp_dot(at - start).abs() / start.distance(end)
        }
        _ => return 0.0,
    };
    feature.fall() * beside
}

/// Support points of `shape` in directions that are tilted from `dir` to the side of `toward`, both
/// in its frame, so far that the points are about as high above the support plane as the depth and
/// the prediction.
pub(super) fn farther_out<S: Shape + ?Sized>(
    shape: &S,
    dir: DVec3,
    toward: DVec3,
    lengths: &Lengths,
) -> impl Iterator<Item = SupportPoint> {
    tilted_toward(shape, dir, tilt(lengths), toward)
}

/// Tangent of the angle of these directions.
fn tilt(lengths: &Lengths) -> f64 {
    let Lengths { depth, prediction, reach, .. } = *lengths;
    // A support point at the distance l, in a direction that is tilted by the tangent t, is at most
    // t l above the support plane.
    #[expect(clippy::manual_clamp, reason = "NaN, of a point on a point, becomes the lower end")]
    ((depth.max(0.0) + prediction) / reach).max(TILT).min(STEEPEST)
}
