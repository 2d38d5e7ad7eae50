//! Structs and enums of the header for shapes that move and turn, and for derivatives.
//!
//! Documentation comments become comments of the header, so they speak of C names.

#![forbid(unsafe_code)]

use super::{Pose, Status, Vec3};

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
    pub linear: Vec3,
    /// Rotation vector: HULLMAP_MOTION_KIND_SCREW.
    pub angular: Vec3,
    /// The point about which the shape turns, at time 0: HULLMAP_MOTION_KIND_SCREW.
    pub center: Vec3,
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
    /// turns. Turns of both shapes are added and rounded up. The default is 200.
    pub max_iterations: u32,
}

/// What hullmap_clear() proves. Start from HULLMAP_CLEAR_SETTINGS_DEFAULT.
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

/// When and where two moving shapes first meet. Points and normal are in the common frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeOfImpact {
    /// False only if the shapes certainly do not meet until time 1.
    pub hit: bool,
    /// How the query ended. HULLMAP_STATUS_OVERLAPPING: the shapes meet at the start.
    pub status: Status,
    /// For a compound, the hull that meets first; otherwise 0.
    pub hull_a: u32,
    /// For a compound, the hull that meets first; otherwise 0.
    pub hull_b: u32,
    /// Number of distance and contact queries.
    pub iterations: u32,
    /// Number of support calls.
    pub support_calls: u32,
    /// Time of impact; infinite if there is no hit.
    pub t: f64,
    /// Until this time, the shapes certainly are farther apart than the target distance.
    pub t_lower: f64,
    /// At this time, the shapes certainly are within the target distance. Infinite if no such time
    /// was found.
    pub t_upper: f64,
    /// Unit vector from A to B at t_lower.
    pub normal: Vec3,
    /// Point of A closest to B at t_lower.
    pub point_a: Vec3,
    /// Point of B closest to A at t_lower.
    pub point_b: Vec3,
}

impl From<hullmap::TimeOfImpact> for TimeOfImpact {
    #[inline(always)]
    fn from(found: hullmap::TimeOfImpact) -> Self {
        let [hull_a, hull_b] = found.parts;
        Self {
            hit: found.hit,
            status: found.status.into(),
            hull_a,
            hull_b,
            iterations: found.iterations,
            support_calls: found.support_calls,
            t: found.t,
            t_lower: found.t_lower,
            t_upper: found.t_upper,
            normal: found.normal.into(),
            point_a: found.point_a.into(),
            point_b: found.point_b.into(),
        }
    }
}

/// What is known about a motion.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The shapes certainly are farther apart than the margin at all times.
    Free = 0,
    /// They certainly are within the margin at some time.
    Hit = 1,
    /// Neither is known: they graze the margin within rounding error, or the limit of queries was
    /// reached.
    Open = 2,
}

/// Whether a motion is free, and with which clearance.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Whether the motion is free.
    pub verdict: Verdict,
    /// How the search ended. HULLMAP_STATUS_WITHIN: a hit, or a free motion with the requested
    /// clearance. HULLMAP_STATUS_OVERLAPPING: a hit at the start. Otherwise the limit of queries or
    /// rounding error stopped the search: the motion is open, or its clearance is smaller.
    pub status: Status,
    /// For a compound that hits, the hull that meets first; otherwise 0.
    pub hull_a: u32,
    /// For a compound that hits, the hull that meets first; otherwise 0.
    pub hull_b: u32,
    /// Number of distance and contact queries.
    pub iterations: u32,
    /// Number of support calls.
    pub support_calls: u32,
    /// Lower bound of the least distance during a free motion; 0 if it is not known to be free.
    pub clearance: f64,
    /// Upper bound of the least distance: the shapes are this near at some time that was tried.
    pub nearest: f64,
    /// Until this time, the shapes certainly are farther apart than the margin. Infinite if they
    /// are at all times.
    pub t_lower: f64,
    /// At this time, the shapes certainly are within the margin. Infinite if no such time is known.
    pub t_upper: f64,
}

impl From<hullmap::Clearance> for Clearance {
    #[inline(always)]
    fn from(found: hullmap::Clearance) -> Self {
        let [hull_a, hull_b] = found.parts;
        let verdict = match found.verdict {
            hullmap::Verdict::Free => Verdict::Free,
            hullmap::Verdict::Hit => Verdict::Hit,
            hullmap::Verdict::Open => Verdict::Open,
        };
        Self {
            verdict,
            status: found.status.into(),
            hull_a,
            hull_b,
            iterations: found.iterations,
            support_calls: found.support_calls,
            clearance: found.clearance,
            nearest: found.nearest,
            t_lower: found.t_lower,
            t_upper: found.t_upper,
        }
    }
}

/// Whether a value has a derivative, or the reason why it has none.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Differentiability {
    /// There is one pair of points and one normal: the numbers are derivatives.
    Unique = 0,
    /// The shapes touch: distance and depth have a kink at 0.
    Touching = 1,
    /// Faces or edges are parallel, so several pairs of points have the same distance.
    Parallel = 2,
    /// Several normals have the same depth, or a line meets a vertex or an edge.
    Normals = 3,
    /// A motion is parallel to the surface where it meets it.
    Grazing = 4,
    /// There is nothing to differentiate: no hit, an overlap at the start of a motion, or a
    /// separated pair whose depth is requested. The numbers are 0.
    Missing = 5,
    /// The answer is less accurate than its settings require.
    Inaccurate = 6,
    /// Only of normals and points: other vertices, edges or faces are nearest for poses nearby.
    Feature = 7,
    /// Only of normals and points: the shape is curved there.
    Curved = 8,
}

impl From<hullmap::Differentiability> for Differentiability {
    fn from(found: hullmap::Differentiability) -> Self {
        match found {
            hullmap::Differentiability::Unique => Self::Unique,
            hullmap::Differentiability::Touching => Self::Touching,
            hullmap::Differentiability::Parallel => Self::Parallel,
            hullmap::Differentiability::Normals => Self::Normals,
            hullmap::Differentiability::Grazing => Self::Grazing,
            hullmap::Differentiability::Missing => Self::Missing,
            hullmap::Differentiability::Inaccurate => Self::Inaccurate,
            hullmap::Differentiability::Feature => Self::Feature,
            hullmap::Differentiability::Curved => Self::Curved,
        }
    }
}

/// Derivatives of a length or a time by the poses of both shapes.
///
/// A twist moves a shape by a vector and turns it by a rotation vector about the origin of its own
/// frame; both are in the frame of the answer. Numbers 0 to 2 are by the vector, 3 to 5 by the
/// rotation vector. Unless the differentiability is HULLMAP_DIFFERENTIABILITY_UNIQUE, the numbers
/// are a direction for an optimiser, and no derivative.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Derivatives {
    /// Whether these are derivatives.
    pub differentiability: Differentiability,
    /// By a twist of A.
    pub by_a: [f64; 6],
    /// By a twist of B.
    pub by_b: [f64; 6],
}

impl From<hullmap::Derivatives> for Derivatives {
    fn from(found: hullmap::Derivatives) -> Self {
        Self { differentiability: found.status.into(), by_a: found.of_a.to_array(), by_b: found.of_b.to_array() }
    }
}

/// Derivatives of the normal and the witness points of an answer by the poses of both shapes.
///
/// Rows are the coordinates x, y, z. Columns are the numbers of a twist, as in HullmapDerivatives.
/// All numbers are 0 unless the differentiability is HULLMAP_DIFFERENTIABILITY_UNIQUE.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WitnessDerivatives {
    /// Whether these are derivatives.
    pub differentiability: Differentiability,
    /// Of the normal, by a twist of A.
    pub normal_by_a: [[f64; 6]; 3],
    /// Of the normal, by a twist of B.
    pub normal_by_b: [[f64; 6]; 3],
    /// Of the point of A, by a twist of A.
    pub point_a_by_a: [[f64; 6]; 3],
    /// Of the point of A, by a twist of B.
    pub point_a_by_b: [[f64; 6]; 3],
    /// Of the point of B, by a twist of A.
    pub point_b_by_a: [[f64; 6]; 3],
    /// Of the point of B, by a twist of B.
    pub point_b_by_b: [[f64; 6]; 3],
}

impl From<hullmap::WitnessDerivatives> for WitnessDerivatives {
    fn from(found: hullmap::WitnessDerivatives) -> Self {
        let (by_a, by_b) = (found.of_a, found.of_b);
        Self {
            differentiability: found.status.into(),
            normal_by_a: by_a.normal,
            normal_by_b: by_b.normal,
            point_a_by_a: by_a.point_a,
            point_a_by_b: by_b.point_a,
            point_b_by_a: by_a.point_b,
            point_b_by_b: by_b.point_b,
        }
    }
}
