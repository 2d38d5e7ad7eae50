//! Whether the witness points of an answer, and its normal, are the only ones within its interval.
//!
//! # Steps
//! 1. Support points in directions that are tilted slightly from the normal. If they are at one
//!    place, the shape meets the other at a vertex, or at a curved place. Then there is only one
//!    pair of points.
//! 2. The same for the other shape. If neither is at a vertex, the points of each are on an edge or
//!    a face. Support points across the longest chord distinguish them.
//! 3. Two edges that are not parallel have one pair of closest points. An edge and a face, or two
//!    faces, have many.
//! 4. Where a line meets the Minkowski difference of two polytopes, and where this difference is
//!    closest to a point inside, a normal is the only one if it is that of a face of the
//!    difference: of a face and a vertex, or of two edges.

use glam::DVec3;

use super::pose_derivative::Differentiability;
use crate::pose::Pose;
use crate::support::SupportMap;
use crate::vector::perpendicular;

/// Tangent of the least angle by which directions are tilted. Rounding errors move the witness
/// points of features at this angle by less than 1e-7 of their size.
const LEAST_TILT: f64 = 1e-7;

/// Greatest tilt, of answers with wide intervals.
const GREATEST_TILT: f64 = 0.1;

/// Support points that are nearer to each other than this many tilts times the outer radius are at
/// one place: a curved surface has others for tilted directions.
const SAME_PLACE: f64 = 8.0;

/// Sine of the angle below which two edges count as parallel, in tilts.
const PARALLEL: f64 = 16.0;

/// What faces a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Facing {
    /// A vertex, or one place of a curved surface.
    Point,
    /// An edge, along this unit direction.
    Edge(DVec3),
    Face,
}

/// A shape at a pose, of which only the core counts.
struct Placed<'s, S: ?Sized> {
    shape: &'s S,
    pose: Pose,
    tilt: f64,
}

impl<S: SupportMap + ?Sized> Placed<'_, S> {
    fn support(&self, dir: DVec3) -> DVec3 {
        self.pose.transform_point(self.shape.core_support_point(self.pose.inverse_transform_vector(dir)).point)
    }

    /// The longest chord of the support points around `normal`; `None` at a vertex.
    fn chord(&self, normal: DVec3) -> Option<DVec3> {
        let x = perpendicular(normal);
        let y = normal.cross(x);
        let tilted = [x, -0.5 * x + 0.75_f64.sqrt() * y, -0.5 * x - 0.75_f64.sqrt() * y];
        let [p, q, r] = tilted.map(|side| self.support(normal + side * self.tilt));
        let longest =
            [q - p, r - q, p - r].into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        longest.filter(|chord| chord.length() > self.same_place())
    }

    fn same_place(&self) -> f64 {
        SAME_PLACE * self.tilt * self.shape.core_radii()[1]
    }

    /// What faces `normal`, if its support points have this chord.
    fn along(&self, normal: DVec3, chord: DVec3) -> Facing {
        let along = chord.normalize();
        let across = normal.cross(along);
        let [p, q] = [across, -across].map(|side| self.support(normal + side * self.tilt));
        if (p - q).dot(across) > self.same_place() { Facing::Face } else { Facing::Edge(along) }
    }

    fn facing(&self, normal: DVec3) -> Facing {
        self.chord(normal).map_or(Facing::Point, |chord| self.along(normal, chord))
    }

    /// Whether the shape is a polytope whose support mapping knows its vertices.
    fn is_polytope(&self, normal: DVec3) -> bool {
        let feature = self.shape.support_point(self.pose.inverse_transform_vector(normal)).feature;
        !(self.shape.convex_radius() > 0.0) && self.shape.point(feature).is_some()
    }
}

/// The shapes at their poses, for a normal whose error is at most `error`.
fn placed<'s, A: ?Sized, B: ?Sized>(
    (a, b, b_in_a): (&'s A, &'s B, Pose),
    error: f64,
) -> (Placed<'s, A>, Placed<'s, B>) {
    let tilt = (2.0 * error).clamp(LEAST_TILT, GREATEST_TILT);
    (Placed { shape: a, pose: Pose::IDENTITY, tilt }, Placed { shape: b, pose: b_in_a, tilt })
}

/// Whether there is one pair of closest points along `normal`, from A to B, in A's frame. `error`
/// is an upper bound of the error of the normal.
pub(super) fn closest_points<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    shapes: (&A, &B, Pose),
    normal: DVec3,
    error: f64,
) -> Differentiability {
    let (a, b) = placed(shapes, error);
    let Some(chord_a) = a.chord(normal) else { return Differentiability::Unique };
    let Some(chord_b) = b.chord(-normal) else { return Differentiability::Unique };
    of_features([a.along(normal, chord_a), b.along(-normal, chord_b)], a.tilt)
}

/// Whether there is one pair of points that meet along `normal`, and no other normal there.
pub(super) fn meeting_points<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    shapes: (&A, &B, Pose),
    normal: DVec3,
) -> Differentiability {
    let (a, b) = placed(shapes, 0.0);
    let features = [a.facing(normal), b.facing(-normal)];
    let is_low =
        matches!(features, [Facing::Point, Facing::Point | Facing::Edge(_)] | [Facing::Edge(_), Facing::Point]);
    if is_low && a.is_polytope(normal) && b.is_polytope(-normal) {
        return Differentiability::Normals;
    }
    of_features(features, a.tilt)
}

fn of_features(features: [Facing; 2], tilt: f64) -> Differentiability {
    let is_unique = match features {
        [Facing::Point, _] | [_, Facing::Point] => true,
        [Facing::Edge(a), Facing::Edge(b)] => a.cross(b).length() > PARALLEL * tilt,
        [Facing::Face, _] | [_, Facing::Face] => false,
    };
    if is_unique { Differentiability::Unique } else { Differentiability::Parallel }
}
