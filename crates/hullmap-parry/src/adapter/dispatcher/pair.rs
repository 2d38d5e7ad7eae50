//! A pair of parry's shapes that hullmap solves, and the conversion of answers to parry's frames.

use hullmap::glam::DVec3;
use hullmap::{Cache, Distance, Geometry, Pose, Settings, Status};

use super::super::convert::{narrow, real, wide_pose};
use super::super::parry;
use super::super::parry::math::{Real, Vector};
use super::super::parry::query::{ClosestPoints, Contact};
use super::super::parry::shape::Shape;
use super::BakedHull;
use super::pieces::Convex;

/// A baked hull, which is A, and a convex shape, which is B.
pub(super) struct HullPair<'s> {
    pub(super) a: &'s BakedHull,
    pub(super) b: Convex<'s>,
    pub(super) placement: Placement,
}

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
#[inline]
pub(super) fn hull_pair<'s>(
    pos12: &parry::math::Pose,
    shape1: &'s dyn Shape,
    shape2: &'s dyn Shape,
) -> Option<HullPair<'s>> {
    let (a, b, flipped) = match (shape1.as_shape::<BakedHull>(), shape2.as_shape::<BakedHull>()) {
        (Some(hull), _) => (hull, shape2, false),
        (None, Some(hull)) => (hull, shape1, true),
        (None, None) => return None,
    };
    Some(HullPair { a, b: Convex::from_shape(b)?, placement: placement(pos12, flipped)? })
}

impl HullPair<'_> {
    pub(super) fn intersects(&self) -> bool {
        hullmap::intersects(self.a, &self.b, self.placement.b_in_a, &mut Cache::new()).is_hit()
    }

    pub(super) fn distance(&self) -> Distance {
        hullmap::distance(self.a, &self.b, self.placement.b_in_a, &Settings::default(), &mut Cache::new())
    }

    pub(super) fn nearest(&self) -> Nearest {
        Nearest::find(self.a, &self.b, self.placement.b_in_a, &mut Cache::new())
    }
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

/// Deepest or closest points of a pair, in A's frame. The normal has unit length.
pub(super) struct Nearest {
    pub(super) point_a: DVec3,
    pub(super) point_b: DVec3,
    /// From A to B.
    pub(super) normal: DVec3,
    /// Negative if the shapes overlap.
    pub(super) dist: f64,
}

impl Nearest {
    pub(super) fn find<A: Geometry + ?Sized, B: Geometry + ?Sized>(
        a: &A,
        b: &B,
        b_in_a: Pose,
        cache: &mut Cache,
    ) -> Self {
        let settings = &Settings::default();
        let found = hullmap::contact(a, b, b_in_a, settings, cache);
        if found.hit {
            let (point_a, point_b) = (found.point_a, found.point_b);
            return Self { point_a, point_b, normal: found.normal, dist: -found.depth };
        }
        let gap = hullmap::distance(a, b, b_in_a, settings, cache);
        Self { point_a: gap.point_a, point_b: gap.point_b, normal: gap.normal, dist: gap.distance }
    }

    /// parry's contact, if the distance is at most `prediction`.
    pub(super) fn contact(&self, placement: &Placement, prediction: Real) -> Option<Contact> {
        let dist = real(self.dist);
        // NaN takes the failing branch.
        let near = dist <= prediction;
        let Local { points: [p1, p2], normals: [n1, n2] } = placement.local(self.point_a, self.point_b, self.normal);
        near.then(|| Contact::new(p1, p2, n1, n2, dist))
    }
}
