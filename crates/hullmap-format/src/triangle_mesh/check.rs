//! Checks of a triangle mesh: every index is in range, the tree's boxes hold their triangles, and
//! edges agree with them. A query then visits each node at most once, and misses none.

use rkyv::rend::{f32_le, u16_le, u32_le};

use super::{
    MAX_TRIANGLES,
    archive::NO_NEIGHBOUR,
    class::{EdgeClass, VertexClass},
    sections::Sections,
    tree::{self, Grid},
};
use crate::{check_error::CheckError, cutter::ROOT_ALIGNMENT};

/// Why the archive of a triangle mesh is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum MeshError {
    /// The archive's sections.
    #[error(transparent)]
    Archive(#[from] CheckError),
    /// The file has no triangles, or more than node numbers can address.
    #[error("the mesh has {found} triangles (expected 1 to {MAX_TRIANGLES}); bake the source again")]
    TriangleCount { found: usize },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} is not finite; bake the source again")]
    NotFinite { vertex: usize },
    /// A corner is not a vertex of the mesh.
    #[error("triangle {triangle} has the vertex {found}, but the mesh has {vertex_count}; bake the source again")]
    Corner { triangle: usize, found: u32, vertex_count: usize },
    /// The bounds do not match the vertices.
    #[error("the bounds of the mesh do not match its vertices; bake the source again")]
    Bounds,
    /// A box is not the tightest one around its triangles.
    #[error("the box of node {node} is not the tightest one around its triangles; bake the source again")]
    Box { node: usize },
    /// The code of a class is unknown, or contradicts the neighbour.
    #[error("edge {edge} of triangle {triangle} has no valid class; bake the source again")]
    EdgeClass { triangle: usize, edge: usize },
    /// A neighbour does not have the edge, or does not name this triangle as its own neighbour.
    #[error("triangle {neighbour} is not beyond edge {edge} of triangle {triangle}; bake the source again")]
    Neighbour { triangle: usize, edge: usize, neighbour: u32 },
    /// The code of a vertex's class is unknown.
    #[error("vertex {vertex} has no valid class; bake the source again")]
    VertexClass { vertex: usize },
}

/// Checks everything in a triangle mesh that a query could follow or return, in O(file).
///
/// # Errors
/// The first requirement that is violated: see [`MeshError`].
pub fn check(mesh: &Sections<'_>, payload: &[u8]) -> Result<(), MeshError> {
    gaps(mesh, payload)?;
    counts(mesh)?;
    vertices(mesh)?;
    corners(mesh)?;
    boxes(mesh)?;
    for (triangle, classes) in mesh.edge_classes.iter().enumerate() {
        edges(mesh, triangle, classes.to_native())?;
    }
    match mesh.vertex_classes.iter().position(|class| VertexClass::from_code(*class).is_none()) {
        Some(vertex) => Err(MeshError::VertexClass { vertex }),
        None => Ok(()),
    }
}

fn gaps(mesh: &Sections<'_>, payload: &[u8]) -> Result<(), MeshError> {
    fn extent<T>(name: &'static str, section: &[T]) -> (&'static str, usize, usize) {
        (name, size_of_val(section), align_of::<T>())
    }
    crate::check::zeros_between(
        payload,
        [
            extent("records", mesh.records),
            extent("source_path", mesh.source_path),
            extent("options", mesh.options),
            extent("vertices", mesh.vertices),
            extent("triangles", mesh.triangles),
            extent("neighbours", mesh.neighbours),
            extent("source_triangles", mesh.source_triangles),
            extent("materials", mesh.materials),
            extent("edge_classes", mesh.edge_classes),
            extent("boxes", mesh.boxes),
            extent("vertex_classes", mesh.vertex_classes),
            ("root", 0, ROOT_ALIGNMENT),
        ],
    )?;
    Ok(())
}

fn counts(mesh: &Sections<'_>) -> Result<(), MeshError> {
    let count = mesh.triangle_count();
    if !(1..=MAX_TRIANGLES).contains(&count) {
        return Err(MeshError::TriangleCount { found: count });
    }
    let counts = [
        ("records", mesh.records.len(), 1),
        ("neighbours", mesh.neighbours.len(), count),
        ("source_triangles", mesh.source_triangles.len(), count),
        ("materials", mesh.materials.len(), count),
        ("edge_classes", mesh.edge_classes.len(), count),
        ("boxes", mesh.boxes.len(), tree::stored_boxes(count)),
        ("vertex_classes", mesh.vertex_classes.len(), mesh.vertices.len()),
    ];
    for (section, found, expected) in counts {
        if found != expected {
            return Err(CheckError::SectionCount { section, found, expected }.into());
        }
    }
    for (section, text) in [("source_path", mesh.source_path), ("options", mesh.options)] {
        if let Err(error) = std::str::from_utf8(text) {
            return Err(CheckError::Text { section, at: error.valid_up_to() }.into());
        }
    }
    Ok(())
}

fn vertices(mesh: &Sections<'_>) -> Result<(), MeshError> {
    let is_finite = |vertex: &[f32_le; 3]| vertex.iter().all(|c| c.to_native().is_finite());
    if let Some(vertex) = mesh.vertices.iter().position(|vertex| !is_finite(vertex)) {
        return Err(MeshError::NotFinite { vertex });
    }
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for vertex in mesh.vertices {
        for ((low, high), c) in low.iter_mut().zip(&mut high).zip(vertex) {
            *low = low.min(c.to_native());
            *high = high.max(c.to_native());
        }
    }
    let stated = mesh.records.first().map(|r| [r.bounds_min, r.bounds_max].map(|c| c.map(f32_le::to_native)));
    if stated == Some([low, high]) { Ok(()) } else { Err(MeshError::Bounds) }
}

fn corners(mesh: &Sections<'_>) -> Result<(), MeshError> {
    let vertex_count = mesh.vertices.len();
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        for found in corners.map(u32_le::to_native) {
            if found as usize >= vertex_count {
                return Err(MeshError::Corner { triangle, found, vertex_count });
            }
        }
    }
    Ok(())
}

fn boxes(mesh: &Sections<'_>) -> Result<(), MeshError> {
    let Some(record) = mesh.records.first() else { return Err(MeshError::Bounds) };
    let [low, high] = [record.bounds_min, record.bounds_max].map(|corner| corner.map(f32_le::to_native));
    let grid = Grid::new(low, high);
    let expected = tree::boxes(mesh.triangle_count(), |triangle| {
        let boxes = mesh.corners(triangle).unwrap_or_default().map(|corner| grid.of_vertex(corner));
        boxes.into_iter().reduce(tree::around).unwrap_or_default()
    });
    let is_equal = |(found, expected): (&[u16_le; 6], &[u16; 6])| found.map(u16_le::to_native) == *expected;
    match mesh.boxes.iter().zip(&expected).position(|pair| !is_equal(pair)) {
        Some(node) => Err(MeshError::Box { node }),
        None => Ok(()),
    }
}

fn edges(mesh: &Sections<'_>, triangle: usize, classes: u16) -> Result<(), MeshError> {
    let neighbours = mesh.neighbours.get(triangle).map_or([NO_NEIGHBOUR; 3], |n| n.map(u32_le::to_native));
    for (edge, neighbour) in neighbours.into_iter().enumerate() {
        let class = EdgeClass::unpack(classes, edge).ok_or(MeshError::EdgeClass { triangle, edge })?;
        if class.has_neighbour() != (neighbour != NO_NEIGHBOUR) || classes >> 12 != 0 {
            return Err(MeshError::EdgeClass { triangle, edge });
        }
        if class.has_neighbour() && !is_mutual(mesh, triangle, edge, neighbour as usize) {
            return Err(MeshError::Neighbour { triangle, edge, neighbour });
        }
    }
    Ok(())
}

/// Whether the neighbour has the edge, with the same class, and names this triangle there.
fn is_mutual(mesh: &Sections<'_>, triangle: usize, edge: usize, neighbour: usize) -> bool {
    let Some([from, to]) = ends(mesh, triangle, edge) else { return false };
    let class = |of: usize, edge: usize| mesh.edge_classes.get(of).and_then(|c| EdgeClass::unpack(c.to_native(), edge));
    let expected = if class(triangle, edge) == Some(EdgeClass::Reversed) { [from, to] } else { [to, from] };
    let back = mesh.neighbours.get(neighbour).map_or([NO_NEIGHBOUR; 3], |n| n.map(u32_le::to_native));
    neighbour != triangle
        && back.into_iter().enumerate().any(|(own, back)| {
            back as usize == triangle
                && ends(mesh, neighbour, own) == Some(expected)
                && class(neighbour, own) == class(triangle, edge)
        })
}

fn ends(mesh: &Sections<'_>, triangle: usize, edge: usize) -> Option<[u32; 2]> {
    let [a, b, c] = mesh.triangles.get(triangle)?.map(u32_le::to_native);
    [[a, b], [b, c], [c, a]].get(edge).copied()
}
