//! Input of the baker: a set of source points.

use std::sync::Arc;

/// Maximum number of points of one hull. Point indices have 32 bits, and the upper values are
/// reserved.
pub const MAX_POINTS: usize = 1 << 30;

/// A named set of source points, from which one hull is built.
#[derive(Clone, Debug, Default)]
pub struct PointSet {
    /// Name of the hull: the name of the OBJ object, or the stem of the file name.
    pub name: String,
    /// Positions in source units.
    pub positions: Vec<[f32; 3]>,
    /// For each position, the zero-based index of its vertex in the source file (the `v` lines of
    /// an OBJ); [`NO_SOURCE_VERTEX`](crate::NO_SOURCE_VERTEX) for a point that is not a source
    /// vertex.
    pub source_vertices: Vec<u32>,
    /// Origin of the positions' frame in the source's frame. It has been subtracted from the
    /// source's coordinates.
    pub origin: [f64; 3],
    /// Triangles of the mesh, as indices of positions; empty for a point cloud. Only
    /// [`decompose`](crate::decompose) and [`parts`](crate::fit) read them.
    pub triangles: Vec<[u32; 3]>,
    /// The mesh that this set stands for as a collision part, in the same frame; `None` for a set
    /// that stands for itself. The parts of one mesh share it.
    pub stands_for: Option<Arc<PointSet>>,
}
