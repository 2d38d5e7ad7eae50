//! Whether the witness points of an answer, and its normal, are the only ones within its interval.
//!
//! For hulls, the edges at the support vertex decide: none of them is level at a vertex, one at an
//! edge, and more in a face. Other shapes, and hulls with features that are too small, take the
//! steps below.
//!
//! # Steps
//! 1. Support points in directions that are tilted slightly from the normal. If they are at one
//!    place, the shape meets the other at a vertex, or at a curved place. Then there is only one
//!    pair of points.
//! 2. Do this for the other shape, too. If neither is at a vertex, the points of each are on an
//!    edge or a face. Support points across the longest chord distinguish them.
//! 3. Two edges that are not parallel have one pair of closest points. An edge and a face, or two
//!    faces, have many.
//! 4. The points stay on their features if no support point is elsewhere for these directions, and
//!    if they are inside an edge or a face of the difference. At a vertex, the support points are
//!    equal for all of them; on a curved surface they differ slightly.
//! 5. Where a line meets the Minkowski difference of two polytopes, and where this difference is
//!    closest to a point inside, a normal is the only one if the place is inside a face of the
//!    difference. The support points of the face, relative to the place, are a polygon around it:
//!    EPA in the plane, which ends as soon as the polygon contains a small disc.

use glam::{DMat3, DVec2, DVec3};

use super::pose_derivative::Differentiability;
use crate::polygon;
use crate::pose::Pose;
use crate::support::SupportMap;
use crate::vector::perpendicular;

/// Tangent of the least angle by which directions are tilted. Rounding errors move the witness
/// points of features at this angle by less than 1e-7 of their size.
const LEAST_TILT: f64 = 1e-7;

/// Greatest tilt, of answers with wide intervals.
pub(super) const GREATEST_TILT: f64 = 0.1;

/// Support points that are nearer to each other than this many tilts times the outer radius are at
/// one place: a curved surface has others for tilted directions.
const SAME_PLACE: f64 = 8.0;

/// Sine of the angle below which two edges count as parallel, in tilts.
const PARALLEL: f64 = 16.0;

/// Three directions at equal angles, up to rounding error.
pub(super) const THIRDS: [DVec2; 3] = [DVec2::X, DVec2::new(-0.5, 0.866), DVec2::new(-0.5, -0.866)];

/// Support points that are nearer to each other than this many tilts times the outer radius are at
/// a vertex, or on a straight edge. Rounding errors are less than a tenth of it, and a surface is
/// more curved unless its radius of curvature is a thousandth of the outer radius.
const STRAIGHT: f64 = 1e-3;

/// Features of points of which nothing is known.
pub(super) const UNKNOWN: [u32; 2] = [u32::MAX; 2];

/// Feature of a shape that faces a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Facing {
    Vertex,
    /// An edge, along this direction.
    Edge(DVec3),
    Face,
    /// A curved surface, or features that are too small to be distinguished from one. It may
    /// contain a line along this direction, as the side of a cylinder does.
    Curved(Option<DVec3>),
}

impl Facing {
    /// The direction of an edge, or of a line on a curved surface.
    fn line(self) -> Option<DVec3> {
        match self {
            Self::Edge(along) => Some(along),
            Self::Curved(along) => along,
            Self::Vertex | Self::Face => None,
        }
    }
}

/// A shape at a pose, of which only the core counts.
pub(super) struct Placed<'s, S: ?Sized> {
    pub(super) shape: &'s S,
    pub(super) pose: Pose,
    pub(super) rotation: DMat3,
    pub(super) tilt: f64,
}

impl<'s, S: SupportMap + ?Sized> Placed<'s, S> {
    pub(super) fn new(shape: &'s S, pose: Pose, tilt: f64) -> Self {
        Self { shape, pose, rotation: pose.rotation_matrix(), tilt }
    }

    pub(super) fn support(&self, dir: DVec3) -> DVec3 {
        self.rotation * self.shape.core_support_point(self.rotation.mul_transpose_vec3(dir)).point
            + self.pose.translation()
    }

    /// The longest chord of the support points around `normal`.
    fn chord(&self, normal: DVec3) -> DVec3 {
        let x = perpendicular(normal);
        let y = normal.cross(x);
        let [p, q, r] = THIRDS.map(|side| self.support(normal + (x * side.x + y * side.y) * self.tilt));
        let longer = |a: DVec3, b: DVec3| if b.length_squared() > a.length_squared() { b } else { a };
        longer(longer(q - p, r - q), p - r)
    }

    pub(super) fn same_place(&self) -> f64 {
        SAME_PLACE * self.tilt * self.shape.core_radii()[1]
    }

    fn straight(&self) -> f64 {
        STRAIGHT * self.tilt * self.shape.core_radii()[1]
    }

    /// Feature that faces `normal`, if its support points have this chord.
    fn facing(&self, normal: DVec3, chord: DVec3) -> Facing {
        let length = chord.length();
        // NaN takes the failing branch.
        if !(length > self.same_place()) {
            return if length <= self.straight() { Facing::Vertex } else { Facing::Curved(None) };
        }
        let along = chord / length;
        let across = normal.cross(along);
        let [p, q] = [across, -across].map(|side| self.support(normal + side * self.tilt));
        let width = (p - q).dot(across);
        if width > self.same_place() {
            Facing::Face
        } else if width <= self.straight() {
            Facing::Edge(along)
        } else {
            Facing::Curved(Some(along))
        }
    }

    /// Feature that faces `normal`, by the edges at the support vertex, which may be `feature`.
    /// `None` if they are not known, or too short.
    fn facing_by_edges(&self, normal: DVec3, feature: u32) -> Option<Facing> {
        // The features of a rounded shape are not vertices.
        if self.shape.convex_radius() > 0.0 {
            return None;
        }
        let dir = self.rotation.mul_transpose_vec3(normal);
        let level = |feature: u32| self.shape.level_edges(feature, dir, 2.0 * self.tilt);
        let level = level(feature).or_else(|| level(self.shape.support_point(dir).feature))?;
        match level.count {
            0 => Some(Facing::Vertex),
            _ if level.shortest <= 2.0 * self.same_place() => None,
            1 => Some(Facing::Edge(self.rotation * level.longest)),
            _ => Some(Facing::Face),
        }
    }

    /// Feature that faces `normal`, maybe at `feature`.
    fn facing_feature(&self, normal: DVec3, feature: u32) -> Facing {
        self.facing_by_edges(normal, feature).unwrap_or_else(|| self.facing(normal, self.chord(normal)))
    }

    /// Whether the shape is known to be a polytope: it has faces, or features identify its
    /// vertices.
    fn is_polytope(&self, normal: DVec3) -> bool {
        let feature = || self.shape.support_point(self.rotation.mul_transpose_vec3(normal)).feature;
        let has_corners = self.shape.facets().is_some() || self.shape.point(feature()).is_some();
        has_corners && !(self.shape.convex_radius() > 0.0)
    }
}

pub(super) fn tilt(error: f64) -> f64 {
    (2.0 * error).clamp(LEAST_TILT, GREATEST_TILT)
}

/// The shapes at their poses, for a normal whose error is at most `error`.
fn placed<'s, A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    (a, b, b_in_a): (&'s A, &'s B, Pose),
    error: f64,
) -> (Placed<'s, A>, Placed<'s, B>) {
    let tilt = tilt(error);
    (Placed::new(a, Pose::IDENTITY, tilt), Placed::new(b, b_in_a, tilt))
}

/// Upper bound of the length of the difference of the normal and the true direction, for a distance
/// between `lower` and `upper`.
///
/// The nearest point of the difference of the shapes is within √(u² − l²) of the point found.
pub(super) fn normal_error([lower, upper]: [f64; 2]) -> f64 {
    ((upper - lower) * (upper + lower)).max(0.0).sqrt() * lower.recip()
}

/// Whether there is one pair of closest points along `normal`, from A to B, in A's frame. `error`
/// is an upper bound of the error of the normal. The points may be at these `features`.
pub(super) fn closest_points<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    normal: DVec3,
    error: f64,
    features: [u32; 2],
) -> Differentiability {
    let tilt = tilt(error);
    if a.convex_radius() + b.convex_radius() == 0.0 && is_only_pair((a, b, b_in_a), normal, tilt, features) {
        return Differentiability::Unique;
    }
    let is_point = |facing| matches!(facing, Facing::Vertex | Facing::Curved(None));
    let of_a = Placed::new(a, Pose::IDENTITY, tilt).facing_feature(normal, features[0]);
    if is_point(of_a) {
        return Differentiability::Unique;
    }
    let of_b = Placed::new(b, b_in_a, tilt).facing_feature(-normal, features[1]);
    if is_point(of_b) {
        return Differentiability::Unique;
    }
    match (of_a.line(), of_b.line()) {
        (Some(a), Some(b)) if !are_parallel(a, b, PARALLEL * tilt) => Differentiability::Unique,
        _ => Differentiability::Parallel,
    }
}

/// Whether edges at these features show at once that there is one pair of points: all edges at one
/// of them fall, or all but one at each, and these two are not parallel.
fn is_only_pair<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    normal: DVec3,
    tilt: f64,
    features: [u32; 2],
) -> bool {
    let on_a = a.only_level_edge(features[0], normal, 2.0 * tilt);
    if on_a == Some(DVec3::ZERO) {
        return true;
    }
    match (on_a, b.only_level_edge(features[1], b_in_a.inverse_transform_vector(-normal), 2.0 * tilt)) {
        (_, Some(DVec3::ZERO)) => true,
        (Some(on_a), Some(on_b)) => {
            let is_long = |edge: DVec3, radius: f64| edge.length() > 2.0 * SAME_PLACE * tilt * radius;
            is_long(on_a, a.outer_radius())
                && is_long(on_b, b.outer_radius())
                && !are_parallel(on_a, b_in_a.transform_vector(on_b), PARALLEL * tilt)
        }
        _ => false,
    }
}

/// Whether the sine of the angle between two directions is at most `sine`.
fn are_parallel(a: DVec3, b: DVec3, sine: f64) -> bool {
    a.cross(b).length_squared() <= sine * sine * a.length_squared() * b.length_squared()
}

/// The features of A and of B that face each other along `normal`, or why the points, which are the
/// only pair, do not stay on them: `Curved`, or a change of feature.
pub(super) fn facing_features<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    shapes: (&A, &B, Pose),
    normal: DVec3,
    points: [DVec3; 2],
    error: f64,
) -> Result<[Facing; 2], Differentiability> {
    let (a, b) = placed(shapes, error);
    let facing = [a.facing_feature(normal, UNKNOWN[0]), b.facing_feature(-normal, UNKNOWN[1])];
    let is_inside = match facing {
        [Facing::Curved(_), _] | [_, Facing::Curved(_)] => return Err(Differentiability::Curved),
        [Facing::Vertex, Facing::Vertex] => true,
        [Facing::Edge(along), Facing::Vertex] | [Facing::Vertex, Facing::Edge(along)] => {
            is_inside_edge(&a, &b, (normal, along.normalize()), points)
        }
        _ => is_inside_face(&a, &b, normal, points),
    };
    if is_inside { Ok(facing) } else { Err(Differentiability::Feature) }
}

/// Whether the difference of the points is inside the edge of A − B that faces `normal`, and is
/// along `along`, a unit vector.
fn is_inside_edge<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &Placed<'_, A>,
    b: &Placed<'_, B>,
    (normal, along): (DVec3, DVec3),
    [point_a, point_b]: [DVec3; 2],
) -> bool {
    let reach = a.same_place() + b.same_place();
    [along, -along].into_iter().all(|side| {
        let dir = normal + side * a.tilt;
        ((a.support(dir) - point_a) - (b.support(-dir) - point_b)).dot(side) > reach
    })
}

/// Whether there is one pair of points that meet along `normal`, and no other normal there.
/// `points` are the points of A and of B.
pub(super) fn meeting_points<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    shapes: (&A, &B, Pose),
    normal: DVec3,
    points: [DVec3; 2],
) -> Differentiability {
    let (a, b) = placed(shapes, 0.0);
    if a.is_polytope(normal) && b.is_polytope(-normal) && !is_inside_face(&a, &b, normal, points) {
        return Differentiability::Normals;
    }
    closest_points(shapes, normal, 0.0, UNKNOWN)
}

/// Whether the difference of the points is certainly inside the face of A − B that faces `normal`.
pub(super) fn is_inside_face<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &Placed<'_, A>,
    b: &Placed<'_, B>,
    normal: DVec3,
    [point_a, point_b]: [DVec3; 2],
) -> bool {
    let (x, y) = (perpendicular(normal), normal.cross(perpendicular(normal)));
    let reach = a.same_place() + b.same_place();
    let corner = |side: DVec2| {
        let dir = normal + (x * side.x + y * side.y) * a.tilt;
        let corner = (a.support(dir) - point_a) - (b.support(-dir) - point_b);
        DVec2::new(corner.dot(x), corner.dot(y))
    };
    let mut is_inside = false;
    polygon::expand(THIRDS.map(corner), |side| {
        is_inside = side.distance > reach;
        let outward = side.outward.try_normalize().filter(|_| !is_inside)?;
        let found = corner(outward);
        // NaN takes the failing branch.
        (found.dot(outward) > side.distance + reach).then_some(found)
    });
    is_inside
}
