//! Static height fields: ground whose heights are known on a regular grid.
//!
//! `bake build --terrain` and `hullmap_bake::height_field` bake the file. The queries in
//! [`compound`](crate::compound) take a [`HeightField`] like a
//! [`TriangleMesh`](crate::TriangleMesh): its parts are its triangles, two for each cell that is
//! not a hole. A tree of height ranges finds them. Neighbours and classes of edges follow from the
//! grid. [`CompoundManifolds`](crate::CompoundManifolds) keeps a manifold for each triangle that
//! touches, with normals of the surface.
//!
//! # Frame
//! Heights are along +z, columns along +x, rows along +y, as in MuJoCo. Vertex (column, row) is at
//! x = origin + column · spacing, rounded to f64, and y likewise. Turn the field by its pose if
//! another axis is up.
//!
//! # What an answer means
//! The same as for a [triangle mesh](crate::triangle_mesh): the surface is thin, and collides on
//! both sides. [`OneSided`](crate::compound::OneSided) makes it collide from above only,
//! [`Joined`](crate::compound::Joined) joins neighbouring fields.
//!
//! # Examples
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use hullmap::glam::DVec3;
//! use hullmap::height_field::{Diagonal, Layout};
//! use hullmap::shapes::Sphere;
//! use hullmap::{Cache, HeightField, Pose, Settings};
//! use hullmap_bake::height_field::{HeightGrid, bake_height_field, write_height_field};
//!
//! // A ramp of two cells: 4 long, 1 wide, 2 high.
//! let layout =
//!     Layout { columns: 3, rows: 2, origin: [0.0; 2], spacing: [2.0, 1.0], diagonal: Diagonal::Rising };
//! let heights = [0.0, 1.0, 2.0, 0.0, 1.0, 2.0];
//! let baked = bake_height_field(&HeightGrid { layout, heights: &heights, holes: &[], materials: &[] })?;
//! let file = write_height_field(baked, &Default::default())?;
//!
//! let ramp = HeightField::from_bytes(&file)?; // or HeightField::open(path)
//! let ground = ramp.height_at(3.0, 0.5).ok_or("beyond the field")?;
//! assert_eq!((ground.height, ground.triangle / 2), (1.5, 1)); // in cell 1
//!
//! let (ball, settings) = (Sphere::new(0.5)?, Settings::default());
//! let above = DVec3::new(3.0, 0.5, ground.height) + 0.75 * ground.normal;
//! let mut cache = Cache::new();
//! let gap = hullmap::distance(&ramp, &ball, Pose::from_translation(above)?, &settings, &mut cache);
//! assert!((gap.distance - 0.25).abs() < 1e-9);
//! # Ok(())
//! # }
//! ```

mod ground;
mod in_box;
pub(crate) mod walk;

use glam::{DVec2, DVec3};
pub use ground::Ground;
pub use hullmap_format::height_field::layout::{Diagonal, Layout};
use hullmap_format::{
    header::{FileKind, Header},
    height_field::{
        check,
        pyramid::{Cells, Extent, Pyramid},
        ranges::{self, EMPTY, Heights},
        sections::Sections,
    },
    scale::Scale,
    triangle_mesh::class::{EdgeClass, VertexClass},
};
use rkyv::rend::u16_le;

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

/// A static height field, opened. See the [module](self).
///
/// Cell (column, row) has the index i = row · (columns − 1) + column, and the triangles 2 i and
/// 2 i + 1. A hole has no triangles, but their indices are reserved.
#[derive(Debug)]
pub struct HeightField {
    storage: Storage,
    header: Header,
    layout: Layout,
    pyramid: Pyramid,
    scale: Scale,
    /// Least and greatest height.
    heights: [f32; 2],
}

impl Checked for HeightField {
    const KIND: FileKind = FileKind::HeightField;

    fn new(header: Header, bytes: Bytes) -> Result<Self, InvalidPack> {
        let storage =
            Storage::try_new(bytes, |bytes| Sections::read(bytes.payload())).map_err(check::FieldError::from)?;
        let sections = storage.borrow_dependent();
        let layout = check::check(sections, storage.borrow_owner().payload())?;
        check_options(&header, sections.options_text())?;
        let heights = sections.height_range().unwrap_or_default();
        let [low, high] = heights;
        let pyramid = Pyramid::new(layout.cells());
        Ok(Self { storage, header, layout, pyramid, scale: Scale::new(low, high), heights })
    }
}

checked::impl_checked!(HeightField);

impl HeightField {
    /// The grid: numbers of columns and rows, origin, spacing, and the diagonal of the cells.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Number of triangles, including the triangles of holes: twice the number of cells.
    pub fn triangle_count(&self) -> usize {
        self.layout.triangle_count()
    }

    /// Number of cells that are holes.
    pub fn hole_count(&self) -> usize {
        self.sections().records.first().map_or(0, |record| record.holes.to_native() as usize)
    }

    /// Whether the cell at this column and row is a hole; `true` beyond the grid.
    pub fn is_hole(&self, column: usize, row: usize) -> bool {
        let [across, along] = self.layout.cells();
        column >= across || row >= along || self.sections().is_hole(self.layout.cell(column, row))
    }

    /// The vertex at this column and row, in the frame of the field; `None` beyond the grid. A
    /// vertex whose cells are all holes has the height 0.
    pub fn vertex(&self, column: usize, row: usize) -> Option<DVec3> {
        let layout = &self.layout;
        (column < layout.columns && row < layout.rows).then(|| self.point(column, row))
    }

    /// The triangle with this index, in the frame of the field; `None` in a hole, and if the index
    /// is not below [`triangle_count`](Self::triangle_count). Its corners are counter-clockwise
    /// seen from +z.
    ///
    /// # Complexity
    /// O(1).
    pub fn triangle(&self, index: usize) -> Option<Triangle> {
        Triangle::new(self.corners(index)?).ok()
    }

    /// Upward unit normal of a triangle, in the frame of the field; `None` in a hole, and beyond
    /// the last triangle.
    pub fn normal(&self, triangle: usize) -> Option<DVec3> {
        let [a, b, c] = self.corners(triangle)?;
        unit((b - a).cross(c - a))
    }

    /// The triangles beyond the edges of a triangle, from corner i to the next one; `None` at
    /// borders, including the borders of holes.
    pub fn neighbours(&self, triangle: usize) -> Option<[Option<usize>; 3]> {
        self.corners(triangle)?;
        Some(self.layout.neighbours(triangle).map(|near| near.filter(|near| self.has_ground(*near))))
    }

    /// Classes of the edges of a triangle, from corner i to the next one.
    pub fn edge_classes(&self, triangle: usize) -> Option<[EdgeClass; 3]> {
        let [a, b, c] = self.corners(triangle)?.map(|corner| corner.to_array());
        let [ab, bc, ca] = self.neighbours(triangle)?;
        let class = |edge: [[f64; 3]; 3], near: Option<usize>| match near.and_then(|near| self.corners(near)) {
            None => EdgeClass::Border,
            Some(corners) => {
                // The corner that is not on the edge.
                let [from, to, _] = edge;
                let is_apart = |corner: &[f64; 3]| *corner != from && *corner != to;
                let opposite = corners.map(|corner| corner.to_array()).into_iter().find(is_apart);
                opposite.map_or(EdgeClass::Border, |opposite| EdgeClass::between(edge, opposite))
            }
        };
        Some([class([a, b, c], ab), class([b, c, a], bc), class([c, a, b], ca)])
    }

    /// Class of the vertex at this column and row; `None` beyond the grid, and for a vertex of
    /// holes alone.
    pub fn vertex_class(&self, column: usize, row: usize) -> Option<VertexClass> {
        let [across, along] = self.layout.cells();
        let near = |at: usize, count: usize| at.saturating_sub(1)..at.saturating_add(1).min(count);
        let cells = near(row, along).flat_map(|row| near(column, across).map(move |column| [column, row]));
        let mut class = None;
        for cell in cells.map(|[column, row]| self.layout.cell(column, row)) {
            for triangle in [2 * cell, 2 * cell + 1] {
                let corner = self.layout.corners(triangle).iter().position(|corner| *corner == [column, row]);
                let (Some(corner), Some([ab, bc, ca])) = (corner, self.edge_classes(triangle)) else { continue };
                let [next, last] = match corner {
                    0 => [ab, ca],
                    1 => [bc, ab],
                    _ => [ca, bc],
                };
                class = Some(class.unwrap_or(VertexClass::Flat).with(next).with(last));
            }
        }
        class
    }

    /// Material of a triangle: a number that the bake was given for its cell; 0 without one. `None`
    /// in a hole, and beyond the last triangle.
    pub fn material(&self, triangle: usize) -> Option<u16> {
        let materials = self.sections().materials;
        self.has_ground(triangle).then(|| materials.get(triangle / 2).copied().map_or(0, u16_le::to_native))
    }

    /// Corners of the box around the field, in its own frame: x and y of the whole grid, z of the
    /// cells that are not holes.
    pub fn bounds(&self) -> [DVec3; 2] {
        let [across, along] = self.layout.cells();
        let [low, high] = self.heights.map(f64::from);
        let at = |column: usize, row: usize, z: f64| DVec3::new(self.layout.x(column), self.layout.y(row), z);
        [at(0, 0, low), at(across, along, high)]
    }

    /// Height, normal and triangle of the ground at (x, y), in the frame of the field; `None` in a
    /// hole and beyond the field. On a shared edge or vertex, the triangle is the one with the
    /// lowest index.
    ///
    /// # Complexity
    /// O(1).
    ///
    /// # Examples
    /// See the [module](self).
    pub fn height_at(&self, x: f64, y: f64) -> Option<Ground> {
        let point = DVec2::new(x, y);
        let [columns, rows] = ground::cells(&self.layout, point)?;
        // A point on the edge of a cell is also one of the cell beyond, which may have ground where
        // the first one is a hole.
        let cells = rows.into_iter().flat_map(|row| columns.map(|column| (column, row)));
        cells.into_iter().find_map(|(column, row)| self.ground_in_cell(column, row, point))
    }

    fn ground_in_cell(&self, column: usize, row: usize, point: DVec2) -> Option<Ground> {
        if self.is_hole(column, row) {
            return None;
        }
        let corner = |dx: usize, dy: usize| self.vertex(column + dx, row + dy);
        let corners = [corner(0, 0)?, corner(1, 0)?, corner(0, 1)?, corner(1, 1)?];
        let (height, is_second) = ground::in_cell(corners, self.layout.diagonal, point);
        let triangle = 2 * self.layout.cell(column, row) + usize::from(is_second);
        Some(Ground { height, normal: self.normal(triangle)?, triangle })
    }

    /// Whether a triangle exists, and is not in a hole.
    #[inline]
    fn has_ground(&self, triangle: usize) -> bool {
        triangle < self.triangle_count() && !self.sections().is_hole(triangle / 2)
    }

    #[inline]
    fn point(&self, column: usize, row: usize) -> DVec3 {
        let layout = &self.layout;
        let height = self.sections().height(layout.vertex(column, row));
        DVec3::new(layout.x(column), layout.y(row), height.into())
    }

    #[inline]
    fn corners(&self, triangle: usize) -> Option<[DVec3; 3]> {
        self.has_ground(triangle).then(|| self.layout.corners(triangle).map(|[column, row]| self.point(column, row)))
    }

    /// Content of a node of the tree; `None` for a node beyond the tree.
    #[inline]
    pub(crate) fn extent(&self, node: u32) -> Option<Extent> {
        self.pyramid.extent(node)
    }

    /// Corners of the box of a node with this extent; `None` if it has only holes.
    #[inline]
    pub(crate) fn bounds_of(&self, node: u32, extent: Extent) -> Option<[DVec3; 2]> {
        let cells = match extent {
            Extent::Cells(cells) => cells,
            Extent::Triangle(triangle) => {
                let [a, b, c] = self.corners(triangle)?;
                return Some([a.min(b).min(c), a.max(b).max(c)]);
            }
        };
        self.box_of(cells, node)
    }

    /// Corners of the box around a rectangle of cells; `None` if all are holes. The heights are the
    /// range of this node of the tree, if it is stored.
    #[inline]
    fn box_of(&self, cells: Cells, node: u32) -> Option<[DVec3; 2]> {
        let [low, high] = match self.sections().ranges.get(node as usize) {
            Some(stored) => {
                let [low, high] = stored.map(u16_le::to_native);
                if [low, high] == EMPTY {
                    return None;
                }
                [self.scale.position(low), self.scale.position(high)]
            }
            None => ranges::range(self.sections(), &self.layout, cells)?.map(f64::from),
        };
        let ([left, right], [bottom, top]) = (cells.columns, cells.rows);
        let at = |column: usize, row: usize, z: f64| DVec3::new(self.layout.x(column), self.layout.y(row), z);
        Some([at(left, bottom, low), at(right, top, high)])
    }

    /// Upper bound of the node numbers.
    pub(crate) fn node_bound(&self) -> usize {
        self.pyramid.node_bound()
    }
}
