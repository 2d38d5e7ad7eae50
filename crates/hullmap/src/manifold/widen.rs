//! Points farther out, under a body that would tip on those that were found.

use glam::{DVec2, DVec3};

use super::clip::{FACE, Frame, Part, Patch, PatchPoint};
use super::lengths::Lengths;
use super::select::{Choice, SAME_PLACE, Spot};
use super::surface::settle;
use crate::pose::Pose;
use crate::shapes::feature::tilted_toward;
use crate::shapes::{Feature, Shape, TILT};
use crate::support::SupportPoint;

/// Distance from the centre, relative to the smaller shape's outer radius, of a point on which a
/// body balances.
const BALANCED: f64 = 0.05;

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
    let mut add = |point: DVec3, exact: [bool; 2], parts: [Part; 2]| {
        let heights = [(point - frame.origin).dot(frame.normal); 2];
        // The other surface is at most half of the depth beyond the origin.
        let [on_a, on_b] = [0.5 * lengths.depth, -0.5 * lengths.depth];
        let most = if exact[1] { on_a - heights[1] } else { heights[0] - on_b };
        let at = frame.projected(point);
        if (at - from).dot(toward) <= 0.0 {
            return;
        }
        let is_same = |known: &PatchPoint| known.parts == parts || known.at.distance(at) <= SAME_PLACE * lengths.reach;
        if most < -lengths.prediction || patch.points().iter().any(is_same) {
            return;
        }
        let mut point = PatchPoint { at, heights, exact, is_moved: false, parts };
        if settle((a, b, b_in_a), frame, features, lengths.height_above(), &mut point)
            && point.depth() >= -lengths.prediction
        {
            patch.push(point);
        }
    };
    // A flat shape has no side that is farther out than its face.
    if a.outer_radius() < b.outer_radius() {
        if a.inner_radius() > 0.0 {
            for SupportPoint { point, feature } in farther_out(a, frame.normal, frame.vector(toward), lengths) {
                add(point, [true, false], [[feature; 2], FACE]);
            }
        }
    } else if b.inner_radius() > 0.0 {
        let [dir, toward] = [-frame.normal, frame.vector(toward)].map(|v| b_in_a.inverse_transform_vector(v));
        for SupportPoint { point, feature } in farther_out(b, dir, toward, lengths) {
            add(b_in_a.transform_point(point), [false, true], [FACE, [feature; 2]]);
        }
    }
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
    let Lengths { depth, prediction, reach, .. } = *lengths;
    // A support point at the distance l, in a direction that is tilted by the tangent t, is at most
    // t l above the support plane.
    #[expect(clippy::manual_clamp, reason = "NaN, of a point on a point, becomes the lower end")]
    let tilt = ((depth.max(0.0) + prediction) / reach).max(TILT).min(STEEPEST);
    tilted_toward(shape, dir, tilt, toward)
}
