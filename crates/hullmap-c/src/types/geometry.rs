//! Points, rotations, poses and boxes.

use hullmap::glam::DVec3;

/// A point, a direction or a velocity.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3 {
    /// First coordinate.
    pub x: f64,
    /// Second coordinate.
    pub y: f64,
    /// Third coordinate.
    pub z: f64,
}

impl From<DVec3> for Vec3 {
    #[inline(always)]
    fn from(v: DVec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<Vec3> for DVec3 {
    #[inline(always)]
    fn from(v: Vec3) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

/// A rotation. Any length but zero: it is normalised by each query. The identity is (0, 0, 0, 1).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quat {
    /// Vector part.
    pub x: f64,
    /// Vector part.
    pub y: f64,
    /// Vector part.
    pub z: f64,
    /// Scalar part.
    pub w: f64,
}

/// A rigid motion: rotate, then translate. `b_in_a` maps points of B's frame into A's frame. From
/// the poses of both in a world, hullmap_pose_relative() computes it. A component of the
/// translation is at most 3.4e38.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Where B's origin is in A's frame.
    pub translation: Vec3,
    /// Rotation of B in A's frame.
    pub rotation: Quat,
}

/// An axis-aligned box.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    /// Minimum of each coordinate.
    pub min: Vec3,
    /// Maximum of each coordinate.
    pub max: Vec3,
}
