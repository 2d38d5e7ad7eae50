//! Structs and enums of the header for shapes that move and turn.
//!
//! Documentation comments become comments of the header, so they speak of C names.

#![forbid(unsafe_code)]

use hullmap::glam::DVec3;

use super::geometry::Pose;

/// How a HullmapMotion moves a shape over the times 0 to 1.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionKind {
    /// It stays at the start.
    Still = 0,
    /// From the start to the end: the origin of its frame along a straight line, its rotation by
    /// spherical interpolation, the shorter way.
    Between = 1,
    /// The point that is at `center` at time 0 moves by `linear`, and the shape turns about it by
    /// the rotation vector `angular`, in radians. More than a full turn is allowed.
    Screw = 2,
}

/// A rigid motion of a shape over the times 0 to 1, in a frame that is common to both shapes.
///
/// Members that its kind does not name are not read.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// A HullmapMotionKind.
    pub kind: u32,
    /// Pose at time 0.
    pub start: Pose,
    /// Pose at time 1: HULLMAP_MOTION_KIND_BETWEEN.
    pub end: Pose,
    /// Displacement of the point at `center`: HULLMAP_MOTION_KIND_SCREW.
    pub linear: DVec3,
    /// Rotation vector: HULLMAP_MOTION_KIND_SCREW.
    pub angular: DVec3,
    /// The point about which the shape turns, at time 0: HULLMAP_MOTION_KIND_SCREW.
    pub center: DVec3,
}

/// Limits and accuracy of a motion. Start from HULLMAP_MOTION_SETTINGS_DEFAULT.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionSettings {
    /// sizeof(HullmapMotionSettings)
    pub struct_size: usize,
    /// The shapes meet when their distance is at most this. The default is 0. NaN and negative
    /// values count as 0.
    pub target_distance: f64,
    /// At the lower bound of the time of impact, the distance exceeds the target by at most this
    /// fraction of the sum of the outer radii. The default is 1e-6.
    pub tolerance: f64,
    /// Maximum number of distance and contact queries for each turn of 360 degrees, up to 100
    /// turns. Turns of both shapes are added and rounded up. The default is 200. All pairs of parts
    /// share it, so compounds on triangles may need 1,000 or more.
    pub max_iterations: u32,
}

/// Settings of hullmap_clear(). Start from HULLMAP_CLEAR_SETTINGS_DEFAULT.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearSettings {
    /// sizeof(HullmapClearSettings)
    pub struct_size: usize,
    /// Shapes that come within this distance hit each other. The default is 0.
    pub margin: f64,
    /// As in HullmapMotionSettings.
    pub tolerance: f64,
    /// The clearance of a free motion is at least this share of the least distance found, or the
    /// status is not HULLMAP_STATUS_WITHIN. The default is 0.5; 0 is the fastest.
    pub share: f64,
    /// As in HullmapMotionSettings.
    pub max_iterations: u32,
}
