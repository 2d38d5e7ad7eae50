//! Input of the page of a robot: its links, joints and meshes, and the pairs of links that touch.

use serde::Serialize;

use crate::DisplayMesh;
use crate::input::Remarks;

/// A robot before and after editing. Lengths are in metres, angles in radians.
#[derive(Debug, Default)]
pub struct Robot {
    /// The description.
    pub file: String,
    /// The edited description.
    pub output: String,
    /// Format of the description.
    pub format: String,
    /// Meshes that shapes refer to.
    pub meshes: Vec<DisplayMesh>,
    /// Its links.
    pub links: Vec<Link>,
    /// Its joints, except fixed ones. Joints of one link are in the order in which they move it.
    pub joints: Vec<Joint>,
    /// Pairs of links that touch in the neutral pose, before or after.
    pub touching: Vec<Touching>,
    /// Pairs of links whose collisions should be excluded.
    pub excluded: Vec<Excluded>,
    /// How the pairs to exclude were found.
    pub exclusion: String,
    /// Faults, warnings and notes.
    pub remarks: Remarks,
}

/// A rigid placement: a rotation as a quaternion x, y, z, w, then a translation.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Placement {
    /// The rotation, of unit length.
    #[serde(rename = "q")]
    pub rotation: [f64; 4],
    /// The translation.
    #[serde(rename = "t")]
    pub translation: [f64; 3],
}

/// A link.
#[derive(Clone, Debug)]
pub struct Link {
    /// Its name.
    pub name: String,
    /// Index of the link that it is placed in.
    pub parent: Option<usize>,
    /// Its placement there, while every joint is at its reference.
    pub rest: Placement,
    /// Its placement in the world in the neutral pose.
    pub neutral: Placement,
    /// Its drawn meshes.
    pub shapes: Vec<Shape>,
    /// The treatment of its collision geometry, in words.
    pub becomes: String,
    /// Number of convex pieces before and after.
    pub pieces: [usize; 2],
    /// Number of vertices of its new collision meshes.
    pub vertices: Option<usize>,
    /// Bounds on how far collisions extend beyond the link's meshes, before and after, in
    /// millimetres.
    pub protrusion_mm: [Option<f64>; 2],
    /// Bound on how far the surface lies outside of the new collisions, in millimetres.
    pub uncovered_mm: Option<f64>,
}

/// A mesh in a link.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Role of the mesh in the link.
    pub layer: Layer,
    /// Index of the mesh.
    pub mesh: usize,
    /// Columns of the affine map from the mesh's frame to the link's: three axes, then the origin.
    pub in_link: [[f64; 3]; 4],
}

/// Role of a mesh in its link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Layer {
    /// Drawn by programs.
    Visual,
    /// A collision of the description.
    Before,
    /// A collision of the edited description.
    After,
}

/// How a joint moves its link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Motion {
    /// About its axis.
    Hinge,
    /// Along its axis.
    Slide,
    /// A ball joint or a free joint: it has no slider.
    Other,
}

/// A joint.
#[derive(Clone, Debug, Serialize)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// Index of the link that it moves.
    pub link: usize,
    /// How it moves the link.
    pub motion: Motion,
    /// Its axis in the frame of the link, of unit length.
    pub axis: [f64; 3],
    /// A point of the axis.
    pub anchor: [f64; 3],
    /// Minimum and maximum of its position.
    pub limits: Option<[f64; 2]>,
    /// Its position at rest.
    pub reference: f64,
    /// Its position in the neutral pose.
    pub neutral: f64,
    /// Coefficients of the polynomial from the leader's displacement to its own, lowest first;
    /// empty if it follows none.
    pub coefficients: Vec<f64>,
    /// The joint that it follows.
    pub leader: Option<usize>,
}

/// A pair of links that touch in the neutral pose.
#[derive(Clone, Copy, Debug)]
pub struct Touching {
    /// Indices of the links.
    pub links: [usize; 2],
    /// Whether they touch before, and after.
    pub touches: [bool; 2],
    /// Whether engines do not test them: neighbours in the chain, and pairs excluded already.
    pub is_untested: bool,
}

/// A pair of links to exclude.
#[derive(Clone, Copy, Debug)]
pub struct Excluded {
    /// Indices of the links.
    pub links: [usize; 2],
    /// Why they should be excluded, in one word.
    pub reason: &'static str,
}
