//! A pair of parry's shapes that hullmap solves, and the conversion of answers to parry's frames.

use hullmap::glam::DVec3;
use hullmap::shapes::HalfSpace;
use hullmap::{Distance, Pose, Status};

use super::super::convert::{narrow, real, wide, wide_pose};
use super::super::parry;
use super::super::parry::math::{Real, Vector};
use super::super::parry::query::ClosestPoints;
use super::super::parry::shape::Shape;
use super::BakedHull;
use super::primitive::Primitive;

/// A pair with a baked hull. A is always a hull.
pub(super) enum HullPair<'s> {
    Hulls(&'s BakedHull, &'s BakedHull),
    Primitive(&'s BakedHull, Primitive),
}

/// Evaluates `$answer` with the shapes of `$pair` as `$a` and `$b`. [`HullPair`] must be in scope.
macro_rules! on_pair {
    ($pair:expr, $a:ident, $b:ident => $answer:expr) => {
        match &$pair {
            HullPair::Hulls($a, $b) => {
                let ($a, $b) = (&**$a, &**$b);
                $answer
            }
            HullPair::Primitive($a, primitive) => {
                let ($a, $b) = (&**$a, primitive.shape());
                $answer
            }
        }
    };
}
pub(super) use on_pair;

#[derive(Clone, Copy)]
pub(super) struct Placement {
    /// B in A's frame.
    pub(super) b_in_a: Pose,
    /// A is parry's second shape.
    pub(super) flipped: bool,
}

/// Points and normals in the local frames of parry's two shapes.
pub(super) struct Local {
    pub(super) points: [Vector; 2],
    pub(super) normals: [Vector; 2],
}

/// The pair of two shapes at `pos12`, the pose of the second shape in the frame of the first.
/// `None` if hullmap does not solve it.
pub(super) fn pair<'s>(
    pos12: &parry::math::Pose,
    shape1: &'s dyn Shape,
    shape2: &'s dyn Shape,
) -> Option<(HullPair<'s>, Placement)> {
    let (pair, flipped) = match (shape1.as_shape::<BakedHull>(), shape2.as_shape::<BakedHull>()) {
        (Some(a), Some(b)) => (HullPair::Hulls(a, b), false),
        (Some(hull), None) => (HullPair::Primitive(hull, Primitive::from_shape(shape2)?), false),
        (None, Some(hull)) => (HullPair::Primitive(hull, Primitive::from_shape(shape1)?), true),
        (None, None) => return None,
    };
    Some((pair, placement(pos12, flipped)?))
}

/// A half-space and a hull at `pos12`. A is the half-space.
pub(super) fn plane<'s>(
    pos12: &parry::math::Pose,
    shape1: &'s dyn Shape,
    shape2: &'s dyn Shape,
) -> Option<(HalfSpace, &'s BakedHull, Placement)> {
    let plane = |shape: &dyn Shape| {
        let found = shape.as_shape::<parry::shape::HalfSpace>()?;
        HalfSpace::new(wide(found.normal), 0.0).ok()
    };
    let (a, b, flipped) = match (shape1.as_shape::<BakedHull>(), shape2.as_shape::<BakedHull>()) {
        (None, Some(hull)) => (plane(shape1)?, hull, false),
        (Some(hull), None) => (plane(shape2)?, hull, true),
        _ => return None,
    };
    Some((a, b, placement(pos12, flipped)?))
}

pub(super) fn placement(pos12: &parry::math::Pose, flipped: bool) -> Option<Placement> {
    let second_in_first = wide_pose(pos12)?;
    let b_in_a = if flipped { second_in_first.inverse() } else { second_in_first };
    Some(Placement { b_in_a, flipped })
}

pub(super) fn closest_points(found: &Distance, placement: &Placement, max_dist: Real) -> ClosestPoints {
    if matches!(found.status, Status::Overlapping | Status::Touching) {
        return ClosestPoints::Intersecting;
    }
    let Local { points: [p1, p2], .. } = placement.local(found.point_a, found.point_b, found.normal);
    if real(found.distance) <= max_dist { ClosestPoints::WithinMargin(p1, p2) } else { ClosestPoints::Disjoint }
}

impl Placement {
    /// Points of A and B and the normal from A to B, all in A's frame, for parry.
    pub(super) fn local(&self, point_a: DVec3, point_b: DVec3, normal: DVec3) -> Local {
        let point_b = self.b_in_a.inverse().transform_point(point_b);
        Local { points: self.order(point_a, point_b), normals: self.normals(normal) }
    }

    /// The normal from A to B for parry: outward of the first shape, and of the second.
    pub(super) fn normals(&self, normal: DVec3) -> [Vector; 2] {
        self.order(normal, self.b_in_a.inverse_transform_vector(-normal))
    }

    pub(super) fn order(&self, of_a: DVec3, of_b: DVec3) -> [Vector; 2] {
        if self.flipped { [narrow(of_b), narrow(of_a)] } else { [narrow(of_a), narrow(of_b)] }
    }

    /// The normal from A to B in A's frame, from parry's first normal in its first frame.
    pub(super) fn axis(&self, normal1: DVec3) -> DVec3 {
        if self.flipped { self.b_in_a.transform_vector(-normal1) } else { normal1 }
    }
}
