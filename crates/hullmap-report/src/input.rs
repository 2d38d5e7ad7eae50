//! Input of the report: a pack, its source, the verification results, and remarks.

use std::path::Path;

use hullmap::{Hull, Pack};
use serde::Serialize;

use crate::DisplayMesh;

/// A pack and everything that was found out about it.
#[derive(Debug)]
pub struct Input<'a> {
    /// The pack's file, as the page names it.
    pub path: &'a Path,
    /// The pack, opened and checked.
    pub pack: &'a Pack,
    /// The source, if it was found and can be used.
    pub source: Option<Source>,
    /// Results of verification.
    pub verification: Verification,
    /// Faults, warnings and notes.
    pub remarks: Remarks,
    /// Vertex indices of each face of a hull. The faces of large hulls are not in lean packs.
    pub polygons: fn(&Hull<'_>) -> Vec<Vec<u32>>,
    /// Excess of a hull's volume over its mesh's, relative to the latter, if the hull fills hollows
    /// of the mesh that matter.
    pub excess: fn(&Hull<'_>) -> Option<f64>,
    /// Up axis and unit.
    pub frame: Frame,
}

/// How people read the coordinates of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Axis that points up in the pictures.
    pub up: Up,
    /// Unit of lengths, after a number.
    pub unit: &'static str,
}

/// The source of a pack.
#[derive(Debug)]
pub struct Source {
    /// Its name on the page.
    pub name: String,
    /// Number of points, over all hulls.
    pub point_count: usize,
    /// Its meshes: one for each hull, or one for each object if objects were cut into parts.
    pub meshes: Vec<DisplayMesh>,
}

/// Results of verifying a pack.
#[derive(Debug)]
pub struct Verification {
    /// Whether the hulls were compared with the source; otherwise with their own stored vertices.
    pub is_against_source: bool,
    /// Directions tested for each hull.
    pub directions: usize,
    /// One result for each hull; empty if the pack could not be compared with its source.
    pub hulls: Vec<VerifiedHull>,
}

/// Result of verifying one hull.
#[derive(Debug)]
pub struct VerifiedHull {
    /// Name of the hull.
    pub name: String,
    /// Whether it passed.
    pub passed: bool,
    /// Whether it is a simplified hull.
    pub is_simplified: bool,
    /// Whether it is a part that is not the solid itself: its fit is only known within bounds, or
    /// not at all.
    pub is_loose_part: bool,
    /// Whether its fit to the mesh was measured.
    pub is_measured: bool,
    /// Index among the parts of its object; 0 for a hull that is not a part.
    pub part: u32,
    /// Number of parts of its object; 0 for a hull that is not a part.
    pub part_count: u32,
    /// Thickness, of a plate with its volume and its surface area; 0 below rank 3.
    pub thickness: f64,
    /// Mean protrusion of its visible surface; `None` if it was not measured.
    pub mean_protrusion: Option<f64>,
    /// How the parts of its object fit together; `None` if they were not compared.
    pub estimates: Option<PartsEstimates>,
    /// Why an engine cannot use the part well, in one word each.
    pub flaws: Vec<&'static str>,
    /// Maximum regret, relative to the diameter.
    pub max_regret: f64,
    /// Number of directions with a wrong support point.
    pub mismatches: usize,
    /// Stored worst case: nodes read by one query.
    pub max_nodes: u32,
    /// Stored worst case: dot products of one query.
    pub max_dots: u32,
}

/// Estimates of how the parts of one object fit together; `None` for what was not measured.
#[derive(Clone, Debug, Default)]
pub struct PartsEstimates {
    /// Sum of the parts' volumes minus the volume of their union, relative to the latter.
    pub overlap: Option<f64>,
    /// Error of `overlap`.
    pub overlap_error: Option<f64>,
    /// Mean distance of the parts' visible surface from the mesh's solid, a length.
    pub mean_protrusion: Option<f64>,
    /// Maximum distance of a part from the mesh's convex hull, a length.
    pub outside_hull: Option<f64>,
    /// Share of the solid's volume that is in no part.
    pub voids: Option<f64>,
    /// Error of `voids`.
    pub voids_error: Option<f64>,
    /// Equation of the plane about which the parts are symmetric.
    pub symmetry: Option<String>,
}

/// Sentences for the reader of the page.
#[derive(Clone, Debug, Default)]
pub struct Remarks {
    /// Reasons why the pack is rejected.
    pub faults: Vec<String>,
    /// Findings to act on, each with its remedy.
    pub warnings: Vec<String>,
    /// Findings of interest.
    pub notes: Vec<String>,
}

/// An axis that points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Up {
    /// z, as in Blender and Unreal.
    Z,
    /// y, as in glTF, Unity and Godot.
    Y,
}
