//! Poses.

use hullmap::glam::{DQuat, DVec3};

/// A rigid motion: rotate, then translate. `b_in_a` maps points of B's frame into A's frame. From
/// the poses of both in a world, hullmap_pose_relative() computes it. A component of the
/// translation is at most 3.4e38.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Where B's origin is in A's frame.
    pub translation: DVec3,
    /// Rotation of B in A's frame.
    pub rotation: DQuat,
}
