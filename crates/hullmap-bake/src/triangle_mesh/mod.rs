//! Triangle meshes: a static mesh that keeps its triangles, with a tree of boxes, neighbours, and
//! classes of edges and vertices.
//!
//! # Steps
//! 1. Merge equal vertices, which files repeat where texture coordinates or normals differ. Drop
//!    unused ones.
//! 2. Order the triangles by the leaves of the tree (`order`), and the vertices by first use.
//! 3. Find neighbours and classes (`edges`).
//! 4. Find the boxes of the tree ([`tree`]).
//!
//! Nothing is repaired: degenerate, duplicate and reversed triangles are kept, and counted.

mod edges;
mod order;
mod t_junctions;

use std::collections::HashMap;

use hullmap_format::{
    header::{Header, options_hash},
    triangle_mesh::{
        MAX_TRIANGLES,
        archive::{Record, TriangleMesh},
        class::EdgeClass,
        tree::{self, Grid},
    },
};

use crate::{baked_hull::SourceRecord, error::BakeError, file, hull::bounds, pack::options_text};
pub use t_junctions::{TJunctions, t_junctions};

/// Triangles of a source, with the vertices that they index.
#[derive(Clone, Copy, Debug)]
pub struct Triangles<'a> {
    /// Vertices, in source units.
    pub positions: &'a [[f32; 3]],
    /// Corners of each triangle, counter-clockwise seen from the front.
    pub corners: &'a [[u32; 3]],
    /// Material of each triangle; empty if the source has none.
    pub materials: &'a [u16],
}

/// A triangle mesh, ready to be written.
#[derive(Clone, Debug)]
pub struct BakedTriangleMesh {
    mesh: TriangleMesh,
}

/// The contents of a triangle mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshCounts {
    /// Number of triangles.
    pub triangles: usize,
    /// Number of different vertices.
    pub vertices: usize,
    /// Number of vertices that equal an earlier one.
    pub merged: usize,
    /// Number of triangles whose corners are on a line.
    pub degenerate: usize,
    /// Number of triangles with the same three vertices as an earlier one.
    pub duplicate: usize,
    /// Number of edges of triangles with each class, in the order of [`EdgeClass::ALL`]. An edge
    /// that two triangles share counts for both.
    pub edges: [usize; EdgeClass::ALL.len()],
}

/// Bakes triangles as a static mesh: a pure function of the arguments, for any number of threads.
///
/// # Errors
/// There are no triangles, or too many. A corner is not a vertex, or a vertex of a triangle is NaN
/// or infinite. There are materials, but not one for each triangle.
///
/// # Complexity
/// O(n log n) for n triangles.
///
/// # Examples
/// ```
/// use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
///
/// // A square of two triangles.
/// let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// let corners = [[0, 1, 2], [0, 2, 3]];
/// let square = bake_triangle_mesh(&Triangles { positions: &positions, corners: &corners, materials: &[] })?;
/// let counts = square.counts();
/// assert_eq!((counts.triangles, counts.vertices), (2, 4));
/// // Four edges on the border, and both sides of a flat one.
/// assert_eq!(counts.edges[..2], [4, 2]);
/// let file = write_triangle_mesh(square, &Default::default())?;
/// assert!(file.starts_with(b"hullmsh\n"));
/// # Ok::<(), hullmap_bake::BakeError>(())
/// ```
pub fn bake_triangle_mesh(source: &Triangles<'_>) -> Result<BakedTriangleMesh, BakeError> {
    check(source)?;
    let Merged { vertices, corners, merged } = merge(source)?;
    let order = order::order(&vertices, &corners);
    let mut mesh = TriangleMesh {
        triangles: order.iter().map(|triangle| corners[*triangle as usize]).collect(),
        materials: order.iter().map(|t| source.materials.get(*t as usize).copied().unwrap_or_default()).collect(),
        source_triangles: order,
        ..TriangleMesh::default()
    };
    drop(corners);
    mesh.vertices = renumber(&vertices, &mut mesh.triangles);
    let found = edges::find(&mesh.vertices, &mesh.triangles);
    mesh.neighbours = found.neighbours;
    mesh.edge_classes = found.edge_classes;
    mesh.vertex_classes = found.vertex_classes;
    let [low, high] = bounds(&mesh.vertices);
    let grid = Grid::new(low, high);
    mesh.boxes = tree::boxes(mesh.triangles.len(), |triangle| {
        let [a, b, c] = mesh.triangles[triangle].map(|corner| grid.of_vertex(mesh.vertices[corner as usize]));
        tree::around(a, tree::around(b, c))
    });
    mesh.records = vec![Record {
        bounds_min: low,
        bounds_max: high,
        degenerate: found.degenerate,
        duplicate: found.duplicate,
        merged,
    }];
    Ok(BakedTriangleMesh { mesh })
}

/// The bytes of the file of a triangle mesh: a pure function of the arguments.
///
/// # Errors
/// [`BakeError::PackTooLarge`] if the file exceeds 2 GiB.
pub fn write_triangle_mesh(baked: BakedTriangleMesh, source: &SourceRecord) -> Result<Vec<u8>, BakeError> {
    let options = options_text(source);
    let options_hash = options_hash(&options);
    let source_path = source.path.clone().into_bytes();
    let mesh = TriangleMesh { source_path, options: options.into_bytes(), ..baked.mesh };
    file::bytes(&mesh, |payload| Header::for_triangle_mesh(source.hash, options_hash, payload))
}

impl BakedTriangleMesh {
    /// T-junctions: vertices inside a triangle's border edge. O(n log n) for n border edges.
    pub fn t_junctions(&self) -> TJunctions {
        t_junctions(&self.mesh.vertices, &self.mesh.triangles, &self.mesh.edge_classes)
    }

    /// The contents of the mesh.
    pub fn counts(&self) -> MeshCounts {
        let mesh = &self.mesh;
        let record = mesh.records.first().copied().unwrap_or_default();
        let mut edges = [0; EdgeClass::ALL.len()];
        for classes in &mesh.edge_classes {
            for class in (0..3).filter_map(|edge| EdgeClass::unpack(*classes, edge)) {
                edges[usize::from(class.code())] += 1;
            }
        }
        MeshCounts {
            triangles: mesh.triangles.len(),
            vertices: mesh.vertices.len(),
            merged: record.merged as usize,
            degenerate: record.degenerate as usize,
            duplicate: record.duplicate as usize,
            edges,
        }
    }
}

fn check(source: &Triangles<'_>) -> Result<(), BakeError> {
    let Triangles { positions, corners, materials } = source;
    if corners.is_empty() {
        return Err(BakeError::Empty);
    }
    if corners.len() > MAX_TRIANGLES {
        return Err(BakeError::TooManyTriangles { found: corners.len() });
    }
    if !materials.is_empty() && materials.len() != corners.len() {
        return Err(BakeError::Materials { found: materials.len(), expected: corners.len() });
    }
    let is_beyond = |corner: &&u32| **corner as usize >= positions.len();
    for (triangle, corners) in corners.iter().enumerate() {
        if let Some(found) = corners.iter().find(is_beyond) {
            return Err(BakeError::Corner { triangle, found: *found, vertex_count: positions.len() });
        }
    }
    Ok(())
}

struct Merged {
    vertices: Vec<[f32; 3]>,
    corners: Vec<[u32; 3]>,
    merged: u32,
}

fn merge(source: &Triangles<'_>) -> Result<Merged, BakeError> {
    const UNUSED: u32 = u32::MAX;
    let mut numbers = vec![UNUSED; source.positions.len()];
    let mut known = HashMap::new();
    let (mut vertices, mut merged) = (Vec::new(), 0);
    let mut number = |corner: u32| {
        let known_number = &mut numbers[corner as usize];
        if *known_number == UNUSED {
            // −0 becomes +0.
            let vertex = source.positions[corner as usize].map(|c| c + 0.0);
            if !vertex.iter().all(|c| c.is_finite()) {
                return Err(BakeError::NotFinite { source_vertex: corner });
            }
            let fresh = vertices.len() as u32;
            *known_number = *known.entry(vertex.map(f32::to_bits)).or_insert(fresh);
            if *known_number == fresh {
                vertices.push(vertex);
            } else {
                merged += 1;
            }
        }
        Ok(*known_number)
    };
    let mut corners = Vec::with_capacity(source.corners.len());
    for &[a, b, c] in source.corners {
        corners.push([number(a)?, number(b)?, number(c)?]);
    }
    Ok(Merged { vertices, corners, merged })
}

fn renumber(vertices: &[[f32; 3]], triangles: &mut [[u32; 3]]) -> Vec<[f32; 3]> {
    const UNUSED: u32 = u32::MAX;
    let mut numbers = vec![UNUSED; vertices.len()];
    let mut ordered = Vec::with_capacity(vertices.len());
    for corner in triangles.as_flattened_mut() {
        let number = &mut numbers[*corner as usize];
        if *number == UNUSED {
            *number = ordered.len() as u32;
            ordered.push(vertices[*corner as usize]);
        }
        *corner = *number;
    }
    ordered
}

#[cfg(test)]
mod tests;
