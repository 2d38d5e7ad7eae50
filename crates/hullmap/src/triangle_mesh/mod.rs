//! Triangle meshes: static levels, which keep their triangles.
//!
//! `hullmap_bake::triangle_mesh` bakes the file. The queries in [`compound`](crate::compound) take
//! a [`TriangleMesh`]: its parts are its triangles, found by a tree of boxes in the file.
//! [`CompoundManifolds`](crate::CompoundManifolds) keeps a manifold for each triangle that touches,
//! with normals of the surface: a body does not stumble over edges inside it.
//!
//! # What an answer means
//! Triangles are thin, and collide on both sides. `distance` returns the distance from the nearest
//! triangle. `contact` returns the contact with the deepest triangle: the interval of its depth is
//! proven for this triangle only. A mesh has no inside here, so the depth is a convention: the
//! shorter way out of the triangle, on either side.
//!
//! # Examples
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use hullmap::glam::DVec3;
//! use hullmap::shapes::Cuboid;
//! use hullmap::{CompoundManifolds, ManifoldSettings, Pose, TriangleMesh};
//! use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
//!
//! // Two triangles, whose front is upwards.
//! let positions = [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]];
//! let corners = [[0, 1, 2], [0, 2, 3]];
//! let baked = bake_triangle_mesh(&Triangles { positions: &positions, corners: &corners, materials: &[] })?;
//! let file = write_triangle_mesh(baked, &Default::default())?;
//!
//! let ground = TriangleMesh::from_bytes(&file)?; // or TriangleMesh::open(path)
//! let die = Cuboid::new(DVec3::splat(0.5))?;
//! let at = Pose::from_translation(DVec3::new(0.1, 0.0, 0.499))?; // over both triangles, 1 mm deep
//! let mut manifolds = CompoundManifolds::new(16);
//! let counts = manifolds.update(&ground, &die, at, &ManifoldSettings::default());
//! assert_eq!(counts.touching, 2);
//! assert!(manifolds.iter().all(|(_, manifold)| manifold.normal().distance(DVec3::Z) < 1e-9));
//! # Ok(())
//! # }
//! ```

mod in_box;
#[cfg(feature = "mmap")]
mod map;
mod on_line;
pub(crate) mod winding;

use glam::DVec3;
use hullmap_format::{
    header::{FileKind, Header},
    triangle_mesh::{
        archive::{ArchivedRecord, NO_NEIGHBOUR},
        check,
        class::{EdgeClass, VertexClass},
        sections::Sections,
        tree::{self, Grid},
    },
};
use rkyv::rend::{f32_le, u16_le, u32_le};

use crate::file::checked::{self, Checked};
use crate::file::{Bytes, check_options};
use crate::pack::{InvalidPack, OpenError};
use crate::shapes::Triangle;
use crate::vector::unit;

self_cell::self_cell!(
    /// The bytes of a file, which no other process may change, and the sections in them.
    struct Storage {
        owner: Bytes,
        #[covariant]
        dependent: Sections,
    }
    impl {Debug}
);

/// A static triangle mesh, opened. See the [module](self).
#[derive(Debug)]
pub struct TriangleMesh {
    storage: Storage,
    header: Header,
    grid: Grid,
    open_edge: Option<OpenSurface>,
}

/// A mesh is not watertight: one of its edges does not have exactly two triangles with the front on
/// the same side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the surface is not watertight: an edge of triangle {triangle} ({source_triangle} in the source) is {}; close the \
     mesh, or ask for the distance from its triangles",
    phrase(*edge)
)]
pub struct OpenSurface {
    /// Index of a triangle with such an edge: the first one.
    pub triangle: usize,
    /// Its index in the source.
    pub source_triangle: u32,
    /// Class of the edge.
    pub edge: EdgeClass,
}

fn phrase(edge: EdgeClass) -> &'static str {
    if edge == EdgeClass::Border { "a border" } else { edge.as_str() }
}

impl Checked for TriangleMesh {
    const KIND: FileKind = FileKind::TriangleMesh;

    fn new(header: Header, bytes: Bytes) -> Result<Self, InvalidPack> {
        let storage =
            Storage::try_new(bytes, |bytes| Sections::read(bytes.payload())).map_err(check::MeshError::from)?;
        let sections = storage.borrow_dependent();
        check::check(sections, storage.borrow_owner().payload())?;
        check_options(&header, sections.options_text())?;
        let [low, high] = bounds(sections);
        let grid = Grid::new(low, high);
        let mut mesh = Self { storage, header, grid, open_edge: None };
        mesh.open_edge = mesh.first_open_edge();
        Ok(mesh)
    }
}

checked::impl_checked!(TriangleMesh);

impl TriangleMesh {
    /// Number of triangles, at least 1.
    pub fn triangle_count(&self) -> usize {
        self.sections().triangle_count()
    }

    /// Checks that the surface is watertight: every edge has exactly two triangles, with the front
    /// on the same side. The classes of the edges state it.
    ///
    /// # Errors
    /// An edge that is open, non-manifold or reversed.
    ///
    /// # Complexity
    /// O(1): all edges were tested at opening.
    pub fn check_closed(&self) -> Result<(), OpenSurface> {
        self.open_edge.map_or(Ok(()), Err)
    }

    fn first_open_edge(&self) -> Option<OpenSurface> {
        let is_closed = |edge: EdgeClass| matches!(edge, EdgeClass::Flat | EdgeClass::Convex | EdgeClass::Concave);
        (0..self.triangle_count()).find_map(|triangle| {
            let edge = self.edge_classes(triangle)?.into_iter().find(|edge| !is_closed(*edge))?;
            Some(OpenSurface { triangle, source_triangle: self.source_triangle(triangle)?, edge })
        })
    }

    /// Number of vertices. Each is there once.
    pub fn vertex_count(&self) -> usize {
        self.sections().vertices.len()
    }

    /// The triangle with this index, in the frame of the mesh; `None` if the index is not below
    /// [`triangle_count`](Self::triangle_count). Its corners are counter-clockwise seen from the
    /// front.
    ///
    /// # Complexity
    /// O(1).
    pub fn triangle(&self, index: usize) -> Option<Triangle> {
        let corners = self.sections().corners(index)?;
        // All coordinates were tested at opening.
        Some(Triangle::of_finite(corners.map(|corner| DVec3::from_array(corner.map(f64::from)))))
    }

    /// Unit normal of a triangle, to its front; `None` if it has no area, or does not exist.
    pub fn normal(&self, triangle: usize) -> Option<DVec3> {
        let [a, b, c] = self.triangle(triangle)?.corners();
        unit((b - a).cross(c - a))
    }

    /// Indices of the corners of a triangle among the vertices.
    pub fn corners(&self, triangle: usize) -> Option<[u32; 3]> {
        Some(self.sections().triangles.get(triangle)?.map(u32_le::to_native))
    }

    /// The triangles beyond the edges of a triangle, from corner i to the next one; `None` at
    /// borders, and where more than two triangles meet.
    pub fn neighbours(&self, triangle: usize) -> Option<[Option<u32>; 3]> {
        let named = |neighbour: u32_le| Some(neighbour.to_native()).filter(|n| *n != NO_NEIGHBOUR);
        Some(self.sections().neighbours.get(triangle)?.map(named))
    }

    /// Classes of the edges of a triangle, from corner i to the next one.
    pub fn edge_classes(&self, triangle: usize) -> Option<[EdgeClass; 3]> {
        let classes = self.sections().edge_classes.get(triangle)?.to_native();
        let of = |edge: usize| EdgeClass::unpack(classes, edge);
        Some([of(0)?, of(1)?, of(2)?])
    }

    /// Class of a vertex.
    pub fn vertex_class(&self, vertex: usize) -> Option<VertexClass> {
        VertexClass::from_code(*self.sections().vertex_classes.get(vertex)?)
    }

    /// Index of a triangle in the source, in the order of the file, each polygon as a fan of
    /// triangles.
    pub fn source_triangle(&self, triangle: usize) -> Option<u32> {
        self.sections().source_triangles.get(triangle).map(|source| source.to_native())
    }

    /// Material of a triangle: a number that the bake was given; 0 without one.
    pub fn material(&self, triangle: usize) -> Option<u16> {
        self.sections().materials.get(triangle).copied().map(u16_le::to_native)
    }

    /// The vertex with this index.
    pub fn vertex(&self, index: usize) -> Option<glam::Vec3> {
        let coordinates = self.sections().vertices.get(index)?;
        Some(glam::Vec3::from_array(coordinates.map(f32_le::to_native)))
    }

    /// Number of triangles whose corners are on a line, as the bake counted them.
    pub fn degenerate_count(&self) -> usize {
        self.record().map_or(0, |record| record.degenerate.to_native() as usize)
    }

    /// Number of triangles with the same three vertices as an earlier one, as the bake counted
    /// them.
    pub fn duplicate_count(&self) -> usize {
        self.record().map_or(0, |record| record.duplicate.to_native() as usize)
    }

    /// Number of vertices of the source that equal an earlier one, as the bake counted them.
    pub fn merged_count(&self) -> usize {
        self.record().map_or(0, |record| record.merged.to_native() as usize)
    }

    /// Minimum and maximum coordinates of the vertices.
    pub fn bounds(&self) -> [glam::Vec3; 2] {
        bounds(self.sections()).map(glam::Vec3::from_array)
    }

    fn record(&self) -> Option<&ArchivedRecord> {
        self.sections().records.first()
    }

    /// Corners of the box of a node of the tree, and its triangles: the first, and the one after
    /// the last. `None` for a node beyond the tree.
    #[inline]
    pub(crate) fn node(&self, node: u32) -> Option<([DVec3; 2], [usize; 2])> {
        let sections = self.sections();
        let [start, end] = tree::triangles(node, sections.triangle_count());
        if let Some(stored) = sections.boxes.get(node as usize) {
            let corners = self.grid.corners(stored.map(u16_le::to_native));
            return Some((corners.map(DVec3::from_array), [start, end]));
        }
        Some((self.corner_bounds(start, end)?, [start, end]))
    }

    /// The box around few triangles.
    fn corner_bounds(&self, start: usize, end: usize) -> Option<[DVec3; 2]> {
        let sections = self.sections();
        let mut bounds: Option<[DVec3; 2]> = None;
        for triangle in start..end.min(start.saturating_add(4)) {
            for corner in sections.corners(triangle)? {
                let corner = DVec3::from_array(corner.map(f64::from));
                bounds = Some(bounds.map_or([corner; 2], |[low, high]| [low.min(corner), high.max(corner)]));
            }
        }
        bounds
    }

    /// Upper bound of the node numbers.
    pub(crate) fn node_bound(&self) -> usize {
        tree::node_bound(self.triangle_count())
    }
}

fn bounds(sections: &Sections<'_>) -> [[f32; 3]; 2] {
    let stated = |record: &ArchivedRecord| [record.bounds_min, record.bounds_max].map(|c| c.map(f32_le::to_native));
    sections.records.first().map_or([[0.0; 3]; 2], stated)
}
