//! Rigid motion over the times 0 to 1: constant linear and angular velocity.

use glam::{DQuat, DVec3};

use crate::pose::Pose;
use crate::solver::VectorError;
use crate::solver::motion::checked;

/// Shortest vector part of a relative rotation that has an axis. Shorter ones turn no point of a
/// shape by more than a rounding error.
const SMALLEST_TURN: f64 = 1e-160;

/// A rigid motion of a shape over the times 0 to 1, in a common frame: a point moves at constant
/// velocity, and the shape turns about this point at constant angular velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMotion {
    rotation: DQuat,
    /// The point about which the shape turns, at time 0.
    center: DVec3,
    /// From the centre to the origin of the shape's frame, at time 0.
    arm: DVec3,
    velocity: DVec3,
    /// Unit vector.
    axis: DVec3,
    /// Angle of the whole motion in radians, at least 0.
    angle: f64,
}

impl RigidMotion {
    /// The motion that stays at `pose`.
    pub fn still(pose: Pose) -> Self {
        Self {
            rotation: pose.rotation(),
            center: pose.translation(),
            arm: DVec3::ZERO,
            velocity: DVec3::ZERO,
            axis: DVec3::X,
            angle: 0.0,
        }
    }

    /// The motion from `start` with these displacements until time 1: the point that is at `center`
    /// at time 0 moves by `linear`, and the shape turns about it by the rotation vector `angular`,
    /// whose length is the angle in radians. It may be more than a full turn.
    ///
    /// If `linear` is parallel to `angular`, this is a screw motion about the axis through
    /// `center`.
    ///
    /// # Errors
    /// A component is NaN or infinite, or the origin of the shape's frame may be beyond 3.4e38
    /// during the motion.
    pub fn screw(start: Pose, linear: DVec3, angular: DVec3, center: DVec3) -> Result<Self, VectorError> {
        checked("angular displacement", angular)?;
        checked("center", center)?;
        let arm = start.translation() - center;
        // Whatever the rotation is, the origin of the shape's frame is within the arm's length of
        // the centre, which is between these two. NaN is an error, too.
        for end in [center, center + linear] {
            checked("position of a motion", end.abs() + DVec3::splat(arm.length()))?;
        }
        let greatest = angular.abs().max_element();
        let (axis, angle) = if greatest > SMALLEST_TURN {
            let scaled = angular / greatest;
            (scaled.normalize(), scaled.length() * greatest)
        } else {
            (DVec3::X, 0.0)
        };
        Ok(Self { rotation: start.rotation(), center, arm, velocity: linear, axis, angle })
    }

    /// The motion from `start` to `end`: the origin of the shape's frame moves along a straight
    /// line, and the rotation is interpolated spherically (slerp), the shorter way.
    ///
    /// # Errors
    /// A position is beyond 3.4e38.
    pub fn between(start: Pose, end: Pose) -> Result<Self, VectorError> {
        let turn = end.rotation() * start.rotation().conjugate();
        let turn = if turn.w < 0.0 { -turn } else { turn };
        let sine = turn.xyz().length();
        let angle = 2.0 * libm::atan2(sine, turn.w);
        let angular = if sine > SMALLEST_TURN { turn.xyz() * (angle / sine) } else { DVec3::ZERO };
        Self::screw(start, end.translation() - start.translation(), angular, start.translation())
    }

    /// The pose at time `t`. Times before 0 and NaN count as 0, times after 1 as 1, so that every
    /// pose is in range.
    ///
    /// # Complexity
    /// One sine and one cosine, of `libm`, which has the same bits on all platforms.
    pub fn pose_at(&self, t: f64) -> Pose {
        let t = t.clamp(0.0, 1.0).max(0.0);
        let turn = if self.angle > 0.0 {
            let (sine, cosine) = libm::sincos(0.5 * self.angle * t);
            let axis = self.axis * sine;
            DQuat::from_xyzw(axis.x, axis.y, axis.z, cosine).normalize()
        } else {
            DQuat::IDENTITY
        };
        Pose::from_parts((turn * self.rotation).normalize(), self.center_at(t) + turn * self.arm)
    }

    /// Where the origin of the shape's frame is at the start.
    pub(crate) fn start(&self) -> DVec3 {
        self.center + self.arm
    }

    /// Where the point about which the shape turns is at time `t`.
    pub(super) fn center_at(&self, t: f64) -> DVec3 {
        self.center + self.velocity * t
    }

    /// The velocity of that point.
    pub(super) fn velocity(&self) -> DVec3 {
        self.velocity
    }

    pub(super) fn axis(&self) -> DVec3 {
        self.axis
    }

    /// The angle in radians by which the shape turns from time 0 to time 1: more than a turn if it
    /// turns several times.
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// The velocity of the point of the shape that is at `point` at time `t`.
    pub(crate) fn velocity_at(&self, t: f64, point: DVec3) -> DVec3 {
        self.velocity + (self.axis * self.angle).cross(point - self.center_at(t))
    }

    /// The motion in a frame whose origin is at `origin`.
    pub(crate) fn relative_to(&self, origin: DVec3) -> Self {
        Self { center: self.center - origin, ..*self }
    }

    /// Upper bound of the magnitude of all lengths from which positions are computed.
    pub(super) fn extent(&self) -> f64 {
        self.center.length() + self.velocity.length() + self.arm.length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn pose(translation: [f64; 3], rotation: [f64; 4]) -> Pose {
        Pose::new(DVec3::from_array(translation), DQuat::from_array(rotation)).unwrap()
    }

    #[test]
    fn interpolation_ends_at_both_poses_and_takes_the_shorter_way() {
        let start = pose([1.0, 2.0, -3.0], [0.1, 0.7, 0.2, 0.5]);
        for end in
            [pose([0.0, 1.0, 5.0], [-0.3, 0.2, 0.1, -0.9]), start, pose([1.0, 2.0, -3.0], [0.1, 0.7, 0.2, 0.4999])]
        {
            let motion = RigidMotion::between(start, end).unwrap();
            for (t, expected) in [(0.0, start), (1.0, end)] {
                let found = motion.pose_at(t);
                assert!(found.translation().distance(expected.translation()) < 1e-15);
                assert!(found.rotation().dot(expected.rotation()).abs() > 1.0 - 1e-15);
            }
            let slerp = start.rotation().slerp(end.rotation(), 0.3);
            assert!(motion.pose_at(0.3).rotation().dot(slerp).abs() > 1.0 - 1e-14);
            assert!(motion.angle() <= PI);
        }
    }

    #[test]
    fn screws_keep_the_distance_from_their_axis() {
        let start = pose([3.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]);
        let motion = RigidMotion::screw(start, DVec3::Z * 2.0, DVec3::Z * (5.0 * PI), DVec3::X).unwrap();
        for step in 0..=50 {
            let t = f64::from(step) / 50.0;
            let place = motion.pose_at(t).translation();
            assert!((place.truncate().distance(glam::DVec2::X) - 2.0).abs() < 1e-14);
            assert!((place.z - 1.0 - 2.0 * t).abs() < 1e-15);
            // Difference quotient, towards the middle of the motion.
            let step = if t < 0.5 { 1e-6 } else { -1e-6 };
            let beside = motion.pose_at(t + step).translation();
            assert!((beside - place).distance(motion.velocity_at(t, place) * step) < 1e-9);
        }
    }

    #[test]
    fn numbers_out_of_range_are_errors() {
        let far = pose([3e38, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]);
        for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e39] {
            for wrong in [DVec3::X, DVec3::Y, DVec3::Z]
                .map(|axis| DVec3::select(axis.cmpgt(DVec3::ZERO), axis * wrong, DVec3::ZERO))
            {
                let screw = |linear, angular, center| RigidMotion::screw(Pose::IDENTITY, linear, angular, center);
                assert!(screw(wrong, DVec3::X, DVec3::ZERO).is_err(), "{wrong}");
                assert!(screw(DVec3::X, wrong, DVec3::ZERO).is_err(), "{wrong}");
                assert!(screw(DVec3::X, DVec3::X, wrong).is_err(), "{wrong}");
            }
        }
        // It turns about a point that is 3e38 away, so it may come to 6e38.
        assert!(RigidMotion::screw(far, DVec3::ZERO, DVec3::Z, far.translation() * 0.5).is_ok());
        assert!(RigidMotion::screw(far, DVec3::ZERO, DVec3::Z, -far.translation()).is_err());
        let across = RigidMotion::between(far, pose([-3e38, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0])).unwrap();
        assert!((across.pose_at(1.0).translation().x / -3e38 - 1.0).abs() < 1e-15);
        let tiny = RigidMotion::screw(Pose::IDENTITY, DVec3::ZERO, DVec3::splat(1e-300), DVec3::ZERO).unwrap();
        assert_eq!(tiny.pose_at(0.7), Pose::IDENTITY);
        // Times out of range give no pose out of range.
        assert_eq!(
            [-1.0, f64::NAN, 2.0, f64::INFINITY].map(|t| across.pose_at(t)),
            [0.0, 0.0, 1.0, 1.0].map(|t| across.pose_at(t))
        );
    }
}
