//! Derivatives of the t of rays, and of times of impact.
//!
//! The shapes meet when their distance is the target distance. If a displacement adds δ to the
//! distance at the time of impact, and the shapes approach each other there at the speed s, they
//! meet later by δ/s.

use glam::DVec3;

use super::pose_derivative::{Derivatives, Differentiability, PoseDerivative};
use super::witness::{UNKNOWN, closest_points, meeting_points};
use crate::continuous::{RigidMotion, TimeOfImpact};
use crate::pose::Pose;
use crate::solver::ray::Dot;
use crate::solver::{Impact, Motion, Ray, RayHit, Status};
use crate::support::SupportMap;

/// The surface is parallel to the motion if the speed at which the shapes approach each other is
/// less than this fraction of the speed: derivatives grow with the inverse.
const GRAZING: f64 = 1e-6;

/// Derivatives of the time at which two bodies meet, one at a point of A and one of B, whose frames
/// have these origins.
fn of_time(
    status: Status,
    normal: DVec3,
    [point_a, point_b]: [DVec3; 2],
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
        of_a: PoseDerivative::of_height(-normal, point_a, origin_a).times(1.0 / speed),
        of_b: PoseDerivative::of_height(normal, point_b, origin_b).times(1.0 / speed),
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
    ///
    /// # Examples
    /// ```
    /// use hullmap::glam::DVec3;
    /// use hullmap::shapes::Cuboid;
    /// use hullmap::{CastSettings, Differentiability, Ray, ray};
    ///
    /// let cube = Cuboid::new(DVec3::ONE)?;
    /// let down = Ray::new(DVec3::new(0.2, 0.3, 5.0), DVec3::new(0.0, 0.0, -2.0))?;
    /// let by = ray(&cube, &down, &CastSettings::default()).derivatives(&cube, &down);
    /// assert_eq!(by.status, Differentiability::Unique);
    /// // If the ray starts higher by δ, t is greater by δ/2.
    /// assert!(by.of_b.linear.distance(DVec3::Z * 0.5) < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn derivatives<S: SupportMap + ?Sized>(&self, shape: &S, ray: &Ray) -> Derivatives {
        let direction = ray.direction();
        let speeds = [-self.normal.dot(direction), direction.length()];
        let points = [self.point, ray.point_at(self.t)];
        of_time(self.status, self.normal, points, [DVec3::ZERO, ray.origin()], speeds, || {
            meeting_points((shape, &Dot, Pose::from_checked(self.point)), self.normal, points)
        })
    }
}

impl Impact {
    /// Derivatives of the time of impact by the poses of `a` and of `b`, which starts at `b_in_a`
    /// and moves by `motion`: of the shapes of this answer. In A's frame.
    ///
    /// # Complexity
    /// 6 to 20 support queries of each shape. No allocation.
    ///
    /// # Examples
    /// ```
    /// use hullmap::glam::DVec3;
    /// use hullmap::shapes::{Cuboid, Sphere};
    /// use hullmap::{Cache, CastSettings, Motion, Pose, cast};
    ///
    /// let (wall, ball) = (Cuboid::new(DVec3::new(1.0, 5.0, 5.0))?, Sphere::new(0.5)?);
    /// let start = Pose::from_translation(DVec3::new(-4.0, 0.5, 0.0))?;
    /// let right = Motion::new(DVec3::new(4.0, 0.0, 0.0))?;
    /// let found = cast(&wall, &ball, start, right, &CastSettings::default(), &mut Cache::new());
    /// let by = found.derivatives(&wall, &ball, start, right);
    /// // If the ball starts farther to the left, it comes later.
    /// assert!(by.of_b.linear.distance(DVec3::NEG_X * 0.25) < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn derivatives<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &self,
        a: &A,
        b: &B,
        b_in_a: Pose,
        motion: Motion,
    ) -> Derivatives {
        let velocity = motion.velocity();
        let speeds = [-self.normal.dot(velocity), velocity.length()];
        if !self.hit {
            return Derivatives::none(Differentiability::Missing);
        }
        let at_impact = b_in_a.moved(velocity * self.t);
        let origins = [DVec3::ZERO, at_impact.translation()];
        of_time(self.status, self.normal, [self.point_a, self.point_b], origins, speeds, || {
            meeting_points((a, b, at_impact), self.normal, [self.point_a, self.point_b])
        })
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
    ///
    /// # Examples
    /// ```
    /// use hullmap::glam::DVec3;
    /// use hullmap::shapes::{Cuboid, Sphere};
    /// use hullmap::{Cache, MotionSettings, Pose, RigidMotion, cast_motion};
    ///
    /// // A rod of length 2 turns about its centre, towards a ball.
    /// let (rod, ball) = (Cuboid::new(DVec3::new(1.0, 0.01, 0.01))?, Sphere::new(0.1)?);
    /// let turning = RigidMotion::screw(Pose::IDENTITY, DVec3::ZERO, DVec3::Z * 2.0, DVec3::ZERO)?;
    /// let still = RigidMotion::still(Pose::from_translation(DVec3::new(0.0, 0.8, 0.0))?);
    /// let settings = MotionSettings { tolerance: 0.0, ..MotionSettings::default() };
    /// let found = cast_motion(&rod, &turning, &ball, &still, &settings, &mut Cache::new());
    /// let by = found.derivatives(&rod, &turning, &ball, &still);
    /// // A rod that is ahead by an angle meets the ball earlier by half of it.
    /// assert!((by.of_a.angular.z + 0.5).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
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
        let (poses, normal) = ([motion_a.pose_at(self.t_lower), motion_b.pose_at(self.t_lower)], self.normal);
        let velocity_a = motion_a.velocity_at(self.t_lower, self.point_a);
        let velocity_b = motion_b.velocity_at(self.t_lower, self.point_b);
        let speeds = [(velocity_a - velocity_b).dot(normal), velocity_a.length() + velocity_b.length()];
        let Ok(b_in_a) = Pose::relative(poses[0], poses[1]) else {
            return Derivatives::none(Differentiability::Inaccurate);
        };
        let origins = poses.map(|pose| pose.translation());
        of_time(self.status, normal, [self.point_a, self.point_b], origins, speeds, || {
            closest_points((a, b, b_in_a), poses[0].inverse_transform_vector(normal), 0.0, UNKNOWN)
        })
    }
}
