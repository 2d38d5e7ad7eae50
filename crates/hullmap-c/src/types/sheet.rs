//! Triangles of meshes.

use super::geometry::Vec3;

/// What an edge of a triangle of a mesh is, seen from the front: HullmapMeshTriangle.edge_classes.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeClass {
    /// No other triangle has the edge.
    Border = 0,
    /// The neighbour continues in the same plane.
    Flat = 1,
    /// A ridge.
    Convex = 2,
    /// A valley.
    Concave = 3,
    /// More than two triangles have the edge.
    NonManifold = 4,
    /// The neighbour has the other side in front.
    Reversed = 5,
}

impl From<hullmap::EdgeClass> for EdgeClass {
    fn from(class: hullmap::EdgeClass) -> Self {
        match class {
            hullmap::EdgeClass::Border => Self::Border,
            hullmap::EdgeClass::Flat => Self::Flat,
            hullmap::EdgeClass::Convex => Self::Convex,
            hullmap::EdgeClass::Concave => Self::Concave,
            hullmap::EdgeClass::NonManifold => Self::NonManifold,
            hullmap::EdgeClass::Reversed => Self::Reversed,
        }
    }
}

/// A triangle of a mesh. Edge i goes from corner i to the next one.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshTriangle {
    /// Its corners, counter-clockwise seen from the front.
    pub corners: [Vec3; 3],
    /// Indices of the corners among the vertices of the mesh.
    pub vertices: [u32; 3],
    /// The triangles beyond its edges; UINT32_MAX where there is none, or more than one.
    pub neighbours: [u32; 3],
    /// Classes of its edges: a HullmapEdgeClass each.
    pub edge_classes: [u32; 3],
    /// Its index in the mesh that was baked.
    pub source_triangle: u32,
    /// Its material; 0 without one.
    pub material: u32,
}

impl MeshTriangle {
    pub(crate) fn of(mesh: &hullmap::TriangleMesh, index: usize) -> Option<Self> {
        Some(Self {
            corners: mesh.triangle(index)?.corners().map(Into::into),
            vertices: mesh.corners(index)?,
            neighbours: mesh.neighbours(index)?.map(|neighbour| neighbour.unwrap_or(u32::MAX)),
            edge_classes: mesh.edge_classes(index)?.map(|class| EdgeClass::from(class) as u32),
            source_triangle: mesh.source_triangle(index)?,
            material: u32::from(mesh.material(index)?),
        })
    }
}
