//! The calls into the runtime crate, all of them.
//!
//! WIRE: this module stands in for `hullmap` until that exists. `Pack` and `Hull` cannot be made here (they hold an
//! `Infallible`), so that every function below compiles, and `Pack::open` and `read_header` say what is missing.

use std::convert::Infallible;
use std::path::Path;

use glam::Vec3;

use crate::args::Mode;
use crate::outcome::Failure;
use crate::pose::Pose;

/// What a pack says of itself before its hulls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PackHeader {
    /// Version of the file format.
    pub format_version: u32,
    /// XXH3-128 of the source's bytes.
    pub source_hash: u128,
    /// Hash of the options, see `BuildOptions::hash`.
    pub options_hash: u64,
}

/// The format version that a bake writes today.
pub fn current_format_version() -> u32 {
    // WIRE: hullmap_format's constant.
    0
}

/// Reads a pack's header alone. `None` where there is no file, or none with a header of this or an older format.
pub fn read_header(path: &Path) -> Option<PackHeader> {
    // WIRE: read 64 bytes, check magic, hand out the fields (hullmap_format).
    let _ = path;
    None
}

/// An opened, fully checked pack.
#[derive(Debug)]
pub struct Pack {
    unwired: Infallible,
}

impl Pack {
    /// Maps and checks a pack.
    ///
    /// # Errors
    /// `Exit::Usage` for a file that cannot be read, `Exit::Wanting` for one that is no valid pack. Both name it.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        // WIRE: hullmap::Pack::open(path); its I/O errors to Failure::usage, the others to Failure::wanting.
        Err(Failure::usage(format!(
            "{}: the runtime is not wired in yet",
            path.display()
        )))
    }

    /// The header's fields.
    pub fn header(&self) -> PackHeader {
        match self.unwired {}
    }

    /// Size of the file.
    pub fn byte_count(&self) -> u64 {
        match self.unwired {}
    }

    /// Recorded path of the source, relative to the pack's folder, with `/`; it may be empty.
    pub fn source_path(&self) -> &str {
        match self.unwired {}
    }

    /// Number of hulls, at least 1.
    pub fn hull_count(&self) -> usize {
        match self.unwired {}
    }

    /// Hull number `number`, which is below the count.
    pub fn hull(&self, number: usize) -> Hull<'_> {
        let _ = number;
        match self.unwired {}
    }
}

/// A hull in a pack. Lengths are in source units, points and directions in the hull's frame.
#[derive(Clone, Copy, Debug)]
pub struct Hull<'a> {
    pack: &'a Pack,
}

/// Answer of a support query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportPoint {
    /// The vertex.
    pub point: Vec3,
    /// Its number.
    pub index: u32,
}

/// What one or the worst support query takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct QueryCost {
    /// Nodes read.
    pub nodes: u32,
    /// Dot products taken.
    pub dots: u32,
}

/// The measures that a pack stores of a hull.
#[derive(Clone, Copy, Debug)]
pub struct Measures {
    /// Enclosed volume; 0 for flat hulls.
    pub volume: f64,
    /// Surface area.
    pub surface_area: f64,
    /// Centre of mass at uniform density.
    pub centroid: [f64; 3],
    /// Least and greatest corner of the bounding box.
    pub bounds: [[f32; 3]; 2],
    /// Greatest distance of two vertices.
    pub diameter: f64,
    /// Greatest distance of a source point outside the hull, relative to the diameter.
    pub containment_error: f64,
}

impl Hull<'_> {
    /// Name of the hull.
    pub fn name(&self) -> &str {
        match self.pack.unwired {}
    }

    /// 3 solid, 2 polygon, 1 segment, 0 point.
    pub fn rank(&self) -> u32 {
        match self.pack.unwired {}
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        match self.pack.unwired {}
    }

    /// Vertex number `index`, which is below the count.
    pub fn vertex(&self, index: usize) -> Vec3 {
        let _ = index;
        match self.pack.unwired {}
    }

    /// Zero-based number of that vertex among the source's `v` lines.
    pub fn source_vertex(&self, index: usize) -> u32 {
        let _ = index;
        match self.pack.unwired {}
    }

    /// Number of source points the hull was built of.
    pub fn point_count(&self) -> usize {
        match self.pack.unwired {}
    }

    /// Faces as polygons: vertex numbers, counter-clockwise seen from outside. A polygon of rank 2 has one or two.
    pub fn faces(&self) -> Vec<Vec<u32>> {
        match self.pack.unwired {}
    }

    /// The stored measures.
    pub fn measures(&self) -> Measures {
        match self.pack.unwired {}
    }

    /// `tree`, `cubemap` or `none`.
    pub fn index_kind(&self) -> &str {
        match self.pack.unwired {}
    }

    /// Bytes of the direction index.
    pub fn index_byte_count(&self) -> u64 {
        match self.pack.unwired {}
    }

    /// The stored worst case of a support query.
    pub fn worst_cost(&self) -> QueryCost {
        match self.pack.unwired {}
    }

    /// Support point in direction `dir`, whatever that is: zero and non-finite ones give any vertex.
    pub fn support(&self, dir: Vec3) -> SupportPoint {
        let _ = dir;
        match self.pack.unwired {}
    }

    /// What that query takes.
    pub fn support_cost(&self, dir: Vec3) -> QueryCost {
        let _ = dir;
        match self.pack.unwired {}
    }
}

/// Answer of a query between two hulls; points and normal in A's frame. `None` where the mode does not compute it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PairAnswer {
    /// Whether they overlap or touch; `None` where that was not decided.
    pub hit: Option<bool>,
    /// How the solver ended, in one word.
    pub status: String,
    /// Depth and its bounds.
    pub depth: Option<[f64; 3]>,
    /// Distance and its bounds.
    pub distance: Option<[f64; 3]>,
    /// Of unit length, from A to B.
    pub normal: Option<[f64; 3]>,
    /// On A.
    pub point_a: Option<[f64; 3]>,
    /// On B.
    pub point_b: Option<[f64; 3]>,
    /// Iterations of the solver.
    pub iterations: u32,
    /// Support queries, each on one of the two hulls.
    pub support_calls: u32,
}

/// A solver for one pair of hulls, with the cache that carries over from pose to pose.
#[derive(Debug)]
pub struct PairSolver<'a> {
    a: Hull<'a>,
    b: Hull<'a>,
}

impl<'a> PairSolver<'a> {
    /// A solver with an empty cache.
    pub fn new(a: Hull<'a>, b: Hull<'a>) -> Self {
        // WIRE: hullmap::Cache::default() and Settings::default() join the fields.
        Self { a, b }
    }

    /// Answers for one pose of B in A's frame.
    pub fn query(&mut self, b_in_a: &Pose, mode: Mode) -> PairAnswer {
        // WIRE: hullmap::{intersects, distance, contact}(&a, &b, pose, &settings, &mut cache).
        let _ = (b_in_a, mode, &self.b);
        match self.a.pack.unwired {}
    }
}
