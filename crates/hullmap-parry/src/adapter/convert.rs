//! Vectors and numbers in parry's precision and in f64, in which hullmap computes.

// One of the two precisions makes each cast a no-op.
#![allow(clippy::unnecessary_cast)]

use hullmap::glam::{DQuat, DVec3};

use super::parry::math::{Pose, Real, Rotation, Vector};

/// A vector in f64. Exact.
#[inline]
pub(super) fn wide(v: Vector) -> DVec3 {
    DVec3::new(v.x as f64, v.y as f64, v.z as f64)
}

/// A vector in parry's precision, rounded.
#[inline]
pub(super) fn narrow(v: DVec3) -> Vector {
    Vector::new(v.x as Real, v.y as Real, v.z as Real)
}

#[inline]
pub(super) fn real(x: f64) -> Real {
    x as Real
}

/// A number in f64. Exact.
#[inline]
pub(super) fn double(x: Real) -> f64 {
    x as f64
}

/// A pose in f64; `None` if it is not finite, or too far away.
pub(super) fn wide_pose(pose: &Pose) -> Option<hullmap::Pose> {
    let rotation = DQuat::from_array(pose.rotation.to_array().map(double));
    hullmap::Pose::new(wide(pose.translation), rotation).ok()
}

pub(super) fn narrow_pose(pose: &hullmap::Pose) -> Pose {
    let rotation = Rotation::from_array(pose.rotation().to_array().map(real));
    Pose::from_parts(narrow(pose.translation()), rotation)
}
