//! Input of the report: a pack, its source, the verification results, and remarks.

use std::path::Path;
use std::time::Duration;

use hullmap::{Hull, Pack};
use serde::Serialize;

use crate::DisplayMesh;

/// A pack and everything that was found out about it.
#[derive(Debug)]
pub struct Input<'a> {
    /// The pack's file. Its bytes are read again for the words of its direction indices.
    pub path: &'a Path,
    /// The pack, opened and checked.
    pub pack: &'a Pack,
    /// Time to open and check the pack.
    pub open_time: Duration,
    /// The source, if it was found and can be used.
    pub source: Option<Source>,
    /// Results of verification.
    pub verification: Verification,
    /// Faults, warnings and notes.
    pub remarks: Remarks,
    /// Vertex indices of each face of a hull. The faces of large hulls are not in lean packs.
    pub polygons: fn(&Hull<'_>) -> Vec<Vec<u32>>,
    /// Axis that points up in the pictures.
    pub up: Up,
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
    /// Time taken by all hulls.
    pub time: Duration,
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
    /// Maximum regret, relative to the diameter.
    pub max_regret: f64,
    /// Number of directions with a wrong support point.
    pub mismatches: usize,
    /// Stored worst case: nodes read by one query.
    pub max_nodes: u32,
    /// Stored worst case: dot products of one query.
    pub max_dots: u32,
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
