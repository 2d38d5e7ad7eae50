//! A set of source points: what readers of files make, and the baker and the judge take.

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
    /// an OBJ), or `u32::MAX` for a point that is not a vertex.
    pub source_vertices: Vec<u32>,
    /// Origin of the positions' frame in the source's frame, already subtracted.
    pub origin: [f64; 3],
    /// Triangles of the mesh, as indices of positions; empty for a point cloud.
    pub triangles: Vec<[u32; 3]>,
    /// The mesh that this collision part stands for, in the same frame and shared by all its parts.
    pub stands_for: Option<Arc<PointSet>>,
}

impl PointSet {
    /// Points that are the vertices of a source, in its order.
    pub fn of_positions(positions: Vec<[f32; 3]>) -> Self {
        let source_vertices = (0..positions.len() as u32).collect();
        Self { positions, source_vertices, ..Self::default() }
    }

    /// Diagonal of the box around the points.
    pub fn diagonal(&self) -> f64 {
        diagonal(&self.positions)
    }
}

/// Diagonal of the box around points; not finite without points.
pub fn diagonal(points: &[[f32; 3]]) -> f64 {
    let sides = [0, 1, 2].map(|axis| {
        let along = || points.iter().map(|p| f64::from(p[axis]));
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    });
    sides.iter().map(|side| side * side).sum::<f64>().sqrt()
}
