//! Derivatives of the t of rays, and of times of impact.
//!
//! The shapes meet when their distance is the target distance. If a displacement adds δ to the
//! distance at the time of impact, and the shapes approach each other there at the speed s, they
//! meet later by δ/s.

use glam::DVec3;

use super::newton::{Condition, Refined, are_described, are_polytopes, if_accurate, is_accurate, refined};
use super::pose_derivative::{Derivatives, Differentiability, PoseDerivative};
use super::witness::{UNKNOWN, closest_points, meeting_points};
use crate::continuous::{RigidMotion, TimeOfImpact};
use crate::pose::Pose;
use crate::solver::ray::Dot;
use crate::solver::{Impact, Motion, Ray, RayHit, Status};
use crate::support::SupportMap;
use crate::vector::unit;

/// The surface is parallel to the motion if the speed at which the shapes approach each other is
/// less than this fraction of the speed: derivatives grow with the inverse.
const GRAZING: f64 = 1e-6;

/// Normal and points of an answer as accurate as rounding error allows, and true; or the answer's
/// own, and whether no more is known about the shapes.
fn accurate<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    shapes: (&A, &B, Pose),
    near: Refined,
    condition: Condition,
    status: Status,
) -> (Refined, bool) {
    let (is_hit, is_along) = (is_accurate(status), matches!(condition, Condition::Along(_)));
    // A line enters polytopes through a face.
    let is_exact = is_along || shapes.0.convex_radius() + shapes.1.convex_radius() == 0.0;
    if !is_hit || (is_exact && are_polytopes(shapes.0, shapes.1)) {
        return (near, true);
    }
    let found = refined(shapes, near, 0.0, condition);
    found.map_or_else(|| (near, !are_described(shapes, near.normal)), |found| (found, true))
}

/// Derivatives of the time at which A and B, which moves by `velocity`, meet, in their poses then.
/// `origins` are the origins of their frames, for these points of A and B.
fn of_translation<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    status: Status,
    shapes: (&A, &B, Pose),
    answer: Refined,
    origins: impl FnOnce([DVec3; 2]) -> [DVec3; 2],
    velocity: DVec3,
) -> Derivatives {
    let (found, is_refined) = accurate(shapes, answer, Condition::Meeting(unit(velocity).unwrap_or(velocity)), status);
    let speeds = [-found.normal.dot(velocity), velocity.length()];
    of_time(status, found, origins(found.points), speeds, || {
        if_accurate(meeting_points(shapes, found.normal, found.points), is_refined)
    })
}

/// Derivatives of the time at which two bodies meet, one at a point of A and one of B, whose frames
/// have these origins.
fn of_time(
    status: Status,
    Refined { normal, points: [point_a, point_b] }: Refined,
    [origin_a, origin_b]: [DVec3; 2],
    [speed, greatest]: [f64; 2],
    uniqueness: impl FnOnce() -> Differentiability,
) -> Derivatives {
    let status = match status {
        Status::Separated | Status::Overlapping => return Derivatives::none(Differentiability::Missing),
        // NaN takes the failing branch.
        _ if !(speed > GRAZING * greatest) => return Derivatives::none(Differentiability::Grazing),
        Status::Touching => Differentiability::Grazing,
        Status::Exact | Status::Within => uniqueness(),
        Status::IterationLimit | Status::Stalled => Differentiability::Inaccurate,
    };
    Derivatives {
        status,
        by_a: PoseDerivative::of_height(-normal, point_a, origin_a).times(1.0 / speed),
        by_b: PoseDerivative::of_height(normal, point_b, origin_b).times(1.0 / speed),
    }
}

impl RayHit {
    /// Derivatives of t by the pose of `shape`, and by the pose of `ray`: of the shape and the ray
    /// of this answer. The frame of the ray has its origin at the ray's origin, and turns with its
    /// direction. Derivatives are in the shape's frame.
    ///
    /// A ray that meets an edge or a vertex of a polytope has no derivative.
    ///
    /// # Complexity
    /// 6 to 12 support queries. No allocation.
    pub fn derivatives<S: SupportMap + ?Sized>(&self, shape: &S, ray: &Ray) -> Derivatives {
        let direction = ray.direction();
        let answer = Refined { normal: self.normal, points: [self.point, ray.point_at(self.t)] };
        let shapes = (shape, &Dot, Pose::from_checked(self.point));
        // The ray reaches the surface at the refined point of the shape.
        let origins = |[on_shape, on_ray]: [DVec3; 2]| [DVec3::ZERO, ray.origin() + (on_ray - on_shape)];
        of_translation(self.status, shapes, answer, origins, direction)
    }
}

impl Impact {
    /// Derivatives of the time of impact by the poses of `a` and of `b`, which starts at `b_in_a`
    /// and moves by `motion`: of the shapes of this answer. In A's frame.
    ///
    /// # Complexity
    /// 6 to 20 support queries of each shape. No allocation.
    pub fn derivatives<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &self,
        a: &A,
        b: &B,
        b_in_a: Pose,
        motion: Motion,
    ) -> Derivatives {
        if !self.hit {
            return Derivatives::none(Differentiability::Missing);
        }
        let velocity = motion.velocity();
        let at_impact = b_in_a.moved(velocity * self.t);
        let answer = Refined { normal: self.normal, points: [self.point_a, self.point_b] };
        let origins = |_: [DVec3; 2]| [DVec3::ZERO, at_impact.translation()];
        of_translation(self.status, (a, b, at_impact), answer, origins, velocity)
    }
}

impl TimeOfImpact {
    /// Derivatives of the time of impact by the poses of `a` and of `b`, which move by `motion_a`
    /// and `motion_b`: of the shapes of this answer. In the common frame of the motions.
    ///
    /// A twist displaces the whole motion: it moves it, and turns it about where the origin of the
    /// shape's frame is at the time of impact.
    ///
    /// Normal and points are those at the lower bound. With a tolerance of ε, the derivatives are
    /// off by as much as the shapes turn from there to the impact.
    ///
    /// # Complexity
    /// 3 to 10 support queries. No allocation.
    pub fn derivatives<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &self,
        a: &A,
        motion_a: &RigidMotion,
        b: &B,
        motion_b: &RigidMotion,
    ) -> Derivatives {
        if !self.hit {
            return Derivatives::none(Differentiability::Missing);
        }
        let poses = [motion_a.pose_at(self.t_lower), motion_b.pose_at(self.t_lower)];
        let Ok(b_in_a) = Pose::relative(poses[0], poses[1]) else {
            return Derivatives::none(Differentiability::Inaccurate);
        };
        let own =
            [self.point_a, self.point_b].map(|point| poses[0].inverse_transform_vector(point - poses[0].translation()));
        let answer = Refined { normal: poses[0].inverse_transform_vector(self.normal), points: own };
        let any = Condition::Along([f64::NEG_INFINITY, f64::INFINITY]);
        let (found, is_refined) = accurate((a, b, b_in_a), answer, any, self.status);
        let placed = Refined {
            normal: poses[0].transform_vector(found.normal),
            points: found.points.map(|point| poses[0].transform_point(point)),
        };
        let [point_a, point_b] = placed.points;
        let velocities = [motion_a.velocity_at(self.t_lower, point_a), motion_b.velocity_at(self.t_lower, point_b)];
        let speeds =
            [(velocities[0] - velocities[1]).dot(placed.normal), velocities[0].length() + velocities[1].length()];
        of_time(self.status, placed, poses.map(|pose| pose.translation()), speeds, || {
            let status = closest_points((a, b, b_in_a), found.normal, 0.0, UNKNOWN);
            if_accurate(status, is_refined)
        })
    }
}
