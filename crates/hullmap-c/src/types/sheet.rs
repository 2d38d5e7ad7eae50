//! Triangles of meshes and of height fields, and the grid of a field.

use hullmap::EdgeClass;
use hullmap::glam::DVec3;
use hullmap::height_field::Diagonal;

/// A triangle of a mesh or of a height field. Edge i goes from corner i to the next one.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshTriangle {
    /// Its corners, counter-clockwise seen from the front, which is above for a field.
    pub corners: [DVec3; 3],
    /// Indices of the corners among the vertices of the mesh. In a height field: row times
    /// columns plus column.
    pub vertices: [u32; 3],
    /// The triangles beyond its edges; UINT32_MAX where there is none, or more than one.
    pub neighbours: [u32; 3],
    /// Classes of its edges.
    pub edge_classes: [EdgeClass; 3],
    /// Its index in the mesh that was baked; of a field, its own index.
    pub source_triangle: u32,
    /// Its material; 0 without one.
    pub material: u32,
}

impl MeshTriangle {
    pub(crate) fn from_mesh(mesh: &hullmap::TriangleMesh, index: usize) -> Option<Self> {
        Some(Self {
            corners: mesh.triangle(index)?.corners(),
            vertices: mesh.corners(index)?,
            neighbours: mesh.neighbours(index)?.map(|neighbour| neighbour.unwrap_or(u32::MAX)),
            edge_classes: mesh.edge_classes(index)?,
            source_triangle: mesh.source_triangle(index)?,
            material: u32::from(mesh.material(index)?),
        })
    }

    pub(crate) fn from_field(field: &hullmap::HeightField, index: usize) -> Option<Self> {
        let layout = field.layout();
        Some(Self {
            corners: field.triangle(index)?.corners(),
            vertices: layout.corners(index).map(|[column, row]| layout.vertex(column, row) as u32),
            neighbours: field.neighbours(index)?.map(|neighbour| neighbour.map_or(u32::MAX, |own| own as u32)),
            edge_classes: field.edge_classes(index)?,
            source_triangle: index as u32,
            material: u32::from(field.material(index)?),
        })
    }
}

/// The grid of a height field. Vertex (column, row) is at origin + column times spacing along x,
/// and origin + row times spacing along y; heights are along z. Cell (column, row) has the index
/// i = row times (columns - 1) + column, and the triangles 2 i and 2 i + 1.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldLayout {
    /// Number of vertices along x, at least 2.
    pub columns: usize,
    /// Number of vertices along y, at least 2.
    pub rows: usize,
    /// x and y of the first vertex.
    pub origin: [f64; 2],
    /// Distance of neighbouring vertices along x and along y.
    pub spacing: [f64; 2],
    /// The diagonal that divides each cell.
    pub diagonal: Diagonal,
    /// Number of cells that are holes. A hole has no triangles, but their indices are reserved.
    pub holes: usize,
}

impl FieldLayout {
    pub(crate) fn from_field(field: &hullmap::HeightField) -> Self {
        let hullmap::height_field::Layout { columns, rows, origin, spacing, diagonal } = *field.layout();
        Self { columns, rows, origin, spacing, diagonal, holes: field.hole_count() }
    }
}
