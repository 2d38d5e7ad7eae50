//! A set of source points: what readers of files make, and the baker and the judge take.

use std::sync::Arc;

use glam::DVec3;

use crate::triangle::Triangle;

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

    /// Position `v`, in f64.
    pub fn at(&self, v: u32) -> DVec3 {
        DVec3::from_array(self.positions[v as usize].map(f64::from))
    }

    /// All positions, in f64.
    pub fn points(&self) -> Vec<DVec3> {
        self.positions.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect()
    }

    /// Corners of a triangle of indices.
    pub fn corners(&self, triangle: &[u32; 3]) -> Triangle {
        triangle.map(|v| self.at(v))
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

/// The corners of the box around points; infinite without points.
pub fn bounds(points: impl IntoIterator<Item = DVec3>) -> [DVec3; 2] {
    let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    points.into_iter().fold(start, |[low, high], p| [low.min(p), high.max(p)])
}

/// A position as a key. −0 and 0 are equal.
pub fn bits(p: DVec3) -> [u64; 3] {
    (p + DVec3::ZERO).to_array().map(f64::to_bits)
}
