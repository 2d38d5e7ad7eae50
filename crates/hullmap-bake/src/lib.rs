//! Points → convex hull → direction index → the bytes of a `.hullmap` pack.

/// One named set of source points, of which one hull is built.
#[derive(Clone, Debug, Default)]
pub struct PointSet {
    /// Name of the hull: the OBJ object's, or the file's stem.
    pub name: String,
    /// Positions in source units, all finite.
    pub positions: Vec<[f32; 3]>,
    /// For each position the zero-based number of the vertex in the source file (the `v` lines of an OBJ).
    pub source_vertices: Vec<u32>,
}

/// Which direction index a bake builds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IndexKind {
    /// The adaptive binary tree over the six cube faces.
    Tree,
    /// A uniform cube map of `resolution` × `resolution` cells a face.
    CubeMap {
        /// Cells along one edge of a cube face.
        resolution: u32,
    },
    /// No index: every query scans all vertices.
    None,
}

/// What the source file was, as the pack records it.
#[derive(Clone, Debug, Default)]
pub struct SourceRecord {
    /// Path of the source relative to the pack's folder, with `/` separators.
    pub path: String,
    /// XXH3-128 of the source's bytes.
    pub hash: u128,
    /// XXH3-64 of the options that shape the bake.
    pub options_hash: u64,
}

/// Why a hull could not be baked.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// No points at all.
    #[error("no points")]
    Empty,
}

/// A hull with its index, ready to be written.
#[derive(Clone, Debug)]
pub struct BakedHull {
    /// Name of the hull.
    pub name: String,
    /// Dimension of the hull: 3 solid, 2 polygon, 1 segment, 0 point.
    pub rank: u32,
    /// Source points the hull was built of.
    pub point_count: usize,
    /// Vertices of the hull.
    pub vertex_count: usize,
}

/// Builds, certifies and indexes the hull of `points`.
pub fn bake_hull(points: &PointSet, index: IndexKind) -> Result<BakedHull, BakeError> {
    let _ = (points, index);
    unreachable!()
}

/// The bytes of a pack that holds `hulls`.
pub fn write_pack(hulls: &[BakedHull], source: &SourceRecord) -> Result<Vec<u8>, BakeError> {
    let _ = (hulls, source);
    unreachable!()
}
