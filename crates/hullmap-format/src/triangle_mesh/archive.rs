//! The rkyv archive of a triangle mesh: vectors of plain numbers, for which every bit pattern is
//! valid, as in packs.

use bytemuck::{Pod, Zeroable};
use rkyv::{Archive, Serialize};

/// Entry of [`TriangleMesh::neighbours`] for an edge without a neighbour.
pub const NO_NEIGHBOUR: u32 = u32::MAX;

/// Everything in the file of a triangle mesh. Lengths are in source units.
#[derive(Archive, Serialize, Clone, Debug, Default)]
pub struct TriangleMesh {
    /// One record.
    pub records: Vec<Record>,
    /// Path of the source relative to the file's folder, UTF-8, with `/`; empty if not recorded.
    pub source_path: Vec<u8>,
    /// The options that shaped the bake, then a line for each warning; UTF-8.
    pub options: Vec<u8>,
    /// Vertices, each once, in the order of first use, with −0 as +0.
    pub vertices: Vec<[f32; 3]>,
    /// Vertices of each triangle, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// For each edge of each triangle, from corner i to the next one, the triangle on its other
    /// side. [`NO_NEIGHBOUR`] if no triangle or several are there.
    pub neighbours: Vec<[u32; 3]>,
    /// For each triangle, its index in the source.
    pub source_triangles: Vec<u32>,
    /// For each triangle, the material that the source states, or 0.
    pub materials: Vec<u16>,
    /// For each triangle, the classes of its three edges, four bits each, the first one lowest: see
    /// [`EdgeClass`](super::class::EdgeClass).
    pub edge_classes: Vec<u16>,
    /// Boxes of the nodes of the tree: see [`tree`](super::tree).
    pub boxes: Vec<[u16; 6]>,
    /// For each vertex, its class: see [`VertexClass`](super::class::VertexClass).
    pub vertex_classes: Vec<u8>,
}

/// Facts about the mesh.
#[derive(Archive, Serialize, Clone, Copy, Debug, Default, PartialEq)]
#[rkyv(derive(Clone, Copy, Debug, Pod, Zeroable))]
pub struct Record {
    /// Minimum coordinates of the vertices.
    pub bounds_min: [f32; 3],
    /// Maximum coordinates of the vertices.
    pub bounds_max: [f32; 3],
    /// Number of triangles with corners on a line, or equal: they collide as segments and points.
    pub degenerate: u32,
    /// Number of triangles with the same three vertices as an earlier one.
    pub duplicate: u32,
    /// Number of vertices of the source that equal an earlier one and were merged with it.
    pub merged: u32,
}
