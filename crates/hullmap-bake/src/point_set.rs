//! Input of the baker: a set of source points.

use std::sync::Arc;

/// Maximum number of points of one hull. Upper values of the 32-bit indices are reserved.
pub const MAX_POINTS: usize = 1 << 30;

/// A named set of source points, from which one hull is built.
#[derive(Clone, Debug, Default)]
pub struct PointSet {
    /// Name of the hull: the name of the OBJ object, or the stem of the file name.
    pub name: String,
    /// Positions in source units.
    pub positions: Vec<[f32; 3]>,
    /// For each position, the zero-based index of its vertex in the source file (the `v` lines of
    /// an OBJ), or [`NO_SOURCE_VERTEX`](crate::NO_SOURCE_VERTEX).
    pub source_vertices: Vec<u32>,
    /// Origin of the positions' frame in the source's frame, already subtracted.
    pub origin: [f64; 3],
    /// Triangles of the mesh, as indices of positions; empty for a point cloud. Only
    /// [`decompose`](crate::decompose) and [`parts`](crate::fit) read them.
    pub triangles: Vec<[u32; 3]>,
    /// The mesh that this collision part stands for, in the same frame and shared by all its parts.
    pub stands_for: Option<Arc<PointSet>>,
}
