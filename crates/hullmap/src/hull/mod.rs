//! One hull of a pack: its facts, vertices and faces in place, and its support mapping.

mod feature;
mod mass;
mod shared;

use glam::{DVec3, Vec3};
use hullmap_format::{
    IndexKind,
    archive::{ArchivedBlock, ArchivedHullRecord, NO_SOURCE_VERTEX},
    sections::Sections,
    walk::Cost,
};
use rkyv::rend::{f32_le, i16_le, u32_le};

use crate::support::hint::{Edges, IsLocalMaximum};
use crate::support::index::Index;
use crate::support::simd::{Dispatch, Instructions};
use crate::support::{SupportMap, SupportPoint};
use crate::vector::unit;

pub use mass::MassProperties;
pub use shared::SharedHull;

/// Bound on the difference between the maximum dot product and that of the support point, divided
/// by the outer radius. A cut of the index may omit a vertex whose normal cone extends less than
/// 4e-15 beyond the cut. With an earlier limit of 1e-13, the worst loss found was 8e-12 of the
/// diameter, 80 times the limit, on caps constructed for this purpose with bumps of 1e-11. The same
/// factor gives 3e-13 now. See docs/intervals.md.
const SUPPORT_ERROR: f64 = 1e-12;

/// A convex hull, read in place from its [`Pack`](crate::Pack). Copying it copies a few slices.
///
/// Points, directions and lengths are in the hull's local frame: the frame and units of the source
/// mesh. [`SharedHull`] is a hull without a lifetime.
#[derive(Clone, Copy, Debug)]
pub struct Hull<'a> {
    name: &'a [u8],
    record: &'a ArchivedHullRecord,
    vertices: &'a [[f32_le; 3]],
    source_vertices: &'a [u32_le],
    face_starts: &'a [u32_le],
    face_vertices: &'a [u32_le],
    index: Index<'a>,
    neighbour_starts: &'a [u32_le],
    neighbours: &'a [u32_le],
    neighbour_faces: &'a [u32_le],
    edges: &'a [i16_le],
    outer_vertices: &'a [[f32_le; 3]],
    interior_point: DVec3,
}

/// Answer of [`Hull::support`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportVertex {
    /// The vertex.
    pub point: Vec3,
    /// Its index, see [`Hull::vertex`].
    pub index: u32,
}

impl<'a> Hull<'a> {
    /// Hull `index` of `pack`, whose spans have been checked.
    pub(crate) fn new(pack: &Sections<'a>, index: usize) -> Option<Self> {
        let record = pack.hulls.get(index)?;
        let (start, end) = (pack.spans.get(index)?, pack.spans.get(index + 1)?);
        let vertices = start.vertex.to_native() as usize..end.vertex.to_native() as usize;
        // A pack that was opened without checks may state no known kind. Scanning all vertices is
        // always exact.
        let kind = IndexKind::of_record(record).unwrap_or(IndexKind::None);
        Some(Self {
            name: run(pack.names, start.name, end.name)?,
            record,
            vertices: pack.vertices.get(vertices.clone())?,
            source_vertices: pack.source_vertices.get(vertices.clone())?,
            face_starts: run(pack.face_starts, start.face, end.face)?,
            face_vertices: run(pack.face_vertices, start.face_vertex, end.face_vertex)?,
            index: Index {
                kind,
                slots: run(pack.slots, start.slot, end.slot)?,
                blocks: run(pack.blocks, start.block, end.block)?,
                leaf_blocks: record.leaf_blocks.to_native(),
                reach: record
                    .bounds_min
                    .iter()
                    .chain(&record.bounds_max)
                    .fold(0.0, |reach: f32, c| reach.max(c.to_native().abs())),
                dispatch: Dispatch::best(),
            },
            neighbour_starts: pack.neighbour_starts.get(vertices)?,
            neighbours: run(pack.neighbours, start.neighbour, end.neighbour)?,
            neighbour_faces: run(pack.neighbour_faces, start.neighbour, end.neighbour)?,
            edges: run(pack.edges, start.edge, end.edge)?,
            outer_vertices: run(pack.outer_vertices, start.outer, end.outer)?,
            interior_point: vector(&record.interior_point),
        })
    }

    /// Support vertex of the hull in direction `dir`: a vertex whose dot product with `dir` is
    /// maximal.
    ///
    /// `dir` is in the hull's local frame and need not be of unit length. Of several vertices with
    /// the same dot product, the lowest index among the candidates of `dir`'s cell is returned. If
    /// `dir` is zero or not finite, some vertex is returned.
    ///
    /// # Complexity
    /// With an index, at most [`worst_cost`](Self::worst_cost) nodes and dot products in every
    /// direction. No allocation.
    ///
    /// # Reference
    /// Kenwright, "Generic Convex Collision Detection using Support Mapping", 4.2, 4.8 and 4.9.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// use hullmap::glam::Vec3;
    ///
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// let corner = cube.support(Vec3::new(1.0, 2.0, -3.0));
    /// assert_eq!(corner.point, Vec3::new(1.0, 1.0, -1.0));
    /// assert_eq!(cube.vertex(corner.index), Some(corner.point));
    /// # }
    /// ```
    #[inline]
    pub fn support(&self, dir: Vec3) -> SupportVertex {
        let (index, point) = self.index.support(dir.to_array());
        SupportVertex { point: Vec3::from_array(point), index }
    }

    /// Support vertex in direction `dir`, with vertex `hint` tried first. A good hint is the answer
    /// to a nearby direction.
    ///
    /// The answer is that of [`support`](Self::support) for every hint. The hint is returned only
    /// if it is certainly the answer: if all its edges lead away from the direction by more than
    /// the rounding error. On a convex hull, its dot product is then the maximum. Otherwise, and if
    /// `hint` is not a vertex, this is an ordinary query.
    ///
    /// # Complexity
    /// One dot product for each neighbour of the hint, eight at a time, then at most the cost of a
    /// query. A vertex has six neighbours on average. A hint with more than 16 is not tried.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// use hullmap::glam::Vec3;
    ///
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// let first = cube.support(Vec3::new(1.0, 1.0, 1.0));
    /// let dir = Vec3::new(1.0, 1.1, 0.9);
    /// assert_eq!(cube.support_from(dir, first.index), cube.support(dir));
    /// # }
    /// ```
    #[inline]
    pub fn support_from(&self, dir: Vec3, hint: u32) -> SupportVertex {
        match self.certain(dir.to_array(), hint) {
            Some(point) => SupportVertex { point: Vec3::from_array(point), index: hint },
            None => self.support(dir),
        }
    }

    /// The position of vertex `hint` if it is certainly the support point in direction `dir`.
    #[inline]
    fn certain(&self, dir: [f32; 3], hint: u32) -> Option<[f32; 3]> {
        let at = hint as usize;
        let start = self.neighbour_starts.get(at)?.to_native() as usize;
        let end = self.neighbour_starts.get(at + 1).map_or(self.neighbours.len(), |next| next.to_native() as usize);
        // Empty for hulls of rank below 3.
        let numbers = self.edges.get(3 * start..)?;
        let edges = Edges { components: numbers, count: end.saturating_sub(start) };
        let point = self.vertices.get(at)?;
        (!numbers.is_empty() && self.index.dispatch.run(IsLocalMaximum(edges), dir))
            .then(|| point.map(f32_le::to_native))
    }

    /// Vector instructions that queries on this hull use. By default, the best that the processor
    /// supports.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// let portable = cube.with_instructions(hullmap::Instructions::Portable).unwrap();
    /// assert_eq!(portable.instructions(), hullmap::Instructions::Portable);
    /// # }
    /// ```
    pub fn instructions(&self) -> Instructions {
        self.index.dispatch.instructions()
    }

    /// The same hull, queried with `instructions`; `None` if the processor does not have them. The
    /// answers are the same.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// use hullmap::{Instructions, glam::Vec3};
    ///
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// if let Some(fast) = cube.with_instructions(Instructions::Avx2) {
    ///     assert_eq!(fast.support(Vec3::ONE), cube.support(Vec3::ONE));
    /// }
    /// # }
    /// ```
    pub fn with_instructions(mut self, instructions: Instructions) -> Option<Self> {
        self.index.dispatch = Dispatch::of(instructions)?;
        Some(self)
    }

    /// Cost of [`support`](Self::support) in direction `dir`: nodes visited and dot products.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// use hullmap::glam::Vec3;
    ///
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// let cost = cube.support_cost(Vec3::X);
    /// assert!(cost.nodes <= cube.worst_cost().nodes && cost.dots <= cube.worst_cost().dots);
    /// # }
    /// ```
    pub fn support_cost(&self, dir: Vec3) -> Cost {
        self.index.cost(dir.to_array())
    }

    /// Maximum cost of [`support`](Self::support) over all directions. Opening a pack checks it.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// // Eight vertices fit into one block, so every direction costs the same.
    /// assert_eq!(cube.worst_cost().dots, 8);
    /// # }
    /// ```
    pub fn worst_cost(&self) -> Cost {
        Cost { nodes: self.record.max_nodes.to_native(), dots: self.record.max_dots.to_native() }
    }

    /// Name of the hull: that of the object in the source file, or the source's file name without
    /// its extension.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert_eq!(cube.name(), "cube");
    /// # }
    /// ```
    pub fn name(&self) -> &'a str {
        std::str::from_utf8(self.name).unwrap_or_default()
    }

    /// Dimension of the hull: 3 for a solid, 2 for a polygon, 1 for a segment, 0 for a point.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert_eq!(cube.rank(), 3);
    /// # }
    /// ```
    pub fn rank(&self) -> u32 {
        self.record.rank.to_native()
    }

    /// Number of vertices, at least 1.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert_eq!(cube.vertex_count(), 8);
    /// # }
    /// ```
    pub fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    /// Position of the vertex of index `index`; `None` if there is no such vertex.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// use hullmap::glam::Vec3;
    ///
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert_eq!(cube.vertex(0), Some(Vec3::NEG_ONE));
    /// assert_eq!(cube.vertex(8), None);
    /// # }
    /// ```
    pub fn vertex(&self, index: u32) -> Option<Vec3> {
        self.vertices.get(index as usize).map(|v| Vec3::from_array(v.map(|c| c.to_native())))
    }

    /// Positions of all vertices, in the order of their indices.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert!(cube.vertices().all(|vertex| vertex.abs() == hullmap::glam::Vec3::ONE));
    /// # }
    /// ```
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = Vec3> + 'a {
        self.vertices.iter().map(|v| Vec3::from_array(v.map(|c| c.to_native())))
    }

    /// Index, counted from 0, that vertex `index` has in the source file.
    ///
    /// `None` if there is no such vertex, and for a vertex that the bake made: of a simplified
    /// hull, or where a convex part was cut off.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert_eq!(cube.source_vertex(7), Some(7));
    /// # }
    /// ```
    pub fn source_vertex(&self, index: u32) -> Option<u32> {
        self.source_vertices.get(index as usize).map(|v| v.to_native()).filter(|v| *v != NO_SOURCE_VERTEX)
    }

    /// Number of source points that the hull was built from.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let rock = pack.hull_named("rock").expect("the pack has a rock");
    /// assert_eq!(rock.source_point_count(), 40);
    /// assert!(rock.vertex_count() <= 40);
    /// # }
    /// ```
    pub fn source_point_count(&self) -> u32 {
        self.record.source_points.to_native()
    }

    /// Number of faces: all faces of a solid, both sides of a polygon, 0 for a segment or a point.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert_eq!(cube.face_count(), 6);
    /// # }
    /// ```
    pub fn face_count(&self) -> usize {
        self.face_starts.len()
    }

    /// Vertex indices of all faces. The vertices of a face are in counter-clockwise order, seen
    /// from outside.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert!(cube.faces().all(|face| face.len() == 4));
    /// # }
    /// ```
    pub fn faces(&self) -> impl Iterator<Item = impl ExactSizeIterator<Item = u32> + 'a> + 'a {
        let (starts, vertices) = (self.face_starts, self.face_vertices);
        starts.iter().enumerate().map(move |(face, start)| {
            let start = start.to_native() as usize;
            let end = starts.get(face + 1).map_or(vertices.len(), |next| next.to_native() as usize);
            vertices.get(start..end).unwrap_or_default().iter().map(|v| v.to_native())
        })
    }

    /// Indices of the vertices that share an edge with vertex `index`, ascending. Empty if there is
    /// no such vertex.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// // One neighbour along each axis.
    /// assert_eq!(cube.neighbours(0).collect::<Vec<_>>(), [1, 2, 4]);
    /// # }
    /// ```
    pub fn neighbours(&self, index: u32) -> impl ExactSizeIterator<Item = u32> + 'a {
        self.neighbour_run(index).iter().map(|v| v.to_native())
    }

    #[inline]
    fn neighbour_run(&self, index: u32) -> &'a [u32_le] {
        self.neighbours.get(self.neighbour_range(index)).unwrap_or_default()
    }

    #[inline]
    fn neighbour_range(&self, index: u32) -> std::ops::Range<usize> {
        let at = index as usize;
        let start = |at: usize| self.neighbour_starts.get(at).map_or(self.neighbours.len(), |s| s.to_native() as usize);
        start(at)..start(at.saturating_add(1))
    }

    /// Vertex indices of face `face` in counter-clockwise order, seen from outside. Empty if there
    /// is no such face.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert_eq!(cube.face(0).len(), 4);
    /// assert_eq!(cube.face(6).len(), 0);
    /// # }
    /// ```
    pub fn face(&self, face: u32) -> impl ExactSizeIterator<Item = u32> + 'a {
        let at = face as usize;
        let end =
            self.face_starts.get(at.saturating_add(1)).map_or(self.face_vertices.len(), |s| s.to_native() as usize);
        let start = self.face_starts.get(at).map_or(end, |s| s.to_native() as usize);
        self.face_vertices.get(start..end).unwrap_or_default().iter().map(|v| v.to_native())
    }

    /// Indices of the faces that meet at vertex `index`, each once. There are as many as the vertex
    /// has neighbours. Empty below rank 2, and if there is no such vertex.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert_eq!(cube.faces_at(0).len(), 3);
    /// # }
    /// ```
    pub fn faces_at(&self, index: u32) -> impl ExactSizeIterator<Item = u32> + 'a {
        let range = if self.record.rank < 2 { 0..0 } else { self.neighbour_range(index) };
        self.neighbour_faces.get(range).unwrap_or_default().iter().map(|f| f.to_native())
    }

    /// Unit outward normal of face `face`; `None` if there is no such face.
    ///
    /// # Complexity
    /// O(1). Faces are planar, so three corners a third of the way around from each other span the
    /// plane well.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// use hullmap::glam::DVec3;
    ///
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// let top = cube.face_towards(DVec3::Z).expect("a solid has faces");
    /// assert_eq!(cube.face_normal(top), Some(DVec3::Z));
    /// # }
    /// ```
    pub fn face_normal(&self, face: u32) -> Option<DVec3> {
        let mut corners = self.face(face);
        // A face has three corners or more.
        let third = (corners.len() / 3).max(1);
        let mut after = |skipped| corners.nth(skipped).and_then(|v| self.vertex(v)).map(Vec3::as_dvec3);
        let (first, second, third) = (after(0)?, after(third - 1)?, after(third - 1)?);
        // From the two shorter sides: the cross product of two long sides of a needle would lose
        // the short side to rounding errors.
        let (a, b, c) = (second - first, third - second, first - third);
        let [a_sq, b_sq, c_sq] = [a, b, c].map(DVec3::length_squared);
        unit(if c_sq >= a_sq && c_sq >= b_sq {
            a.cross(b)
        } else if a_sq >= b_sq {
            b.cross(c)
        } else {
            c.cross(a)
        })
    }

    /// The face that faces `dir` (local frame, any length): of the faces at the support vertex, the
    /// one whose normal is closest to `dir`. `None` below rank 2, and if `dir` is zero or not
    /// finite.
    ///
    /// # Complexity
    /// One support query, and one normal for each face at its vertex. A vertex has six faces on
    /// average; the tip of a cone has one for each neighbour.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// use hullmap::glam::DVec3;
    ///
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// let face = cube.face_towards(DVec3::new(0.1, -5.0, 0.2)).expect("a solid has faces");
    /// assert_eq!(cube.face_normal(face), Some(DVec3::NEG_Y));
    /// # }
    /// ```
    pub fn face_towards(&self, dir: DVec3) -> Option<u32> {
        let dir = unit(dir)?;
        let vertex = SupportMap::support_point(self, dir).feature;
        let alignment = |face: u32| self.face_normal(face).map_or(f64::NEG_INFINITY, |n| n.dot(dir));
        let mut best = (f64::NEG_INFINITY, None);
        for face in self.faces_at(vertex) {
            let found = alignment(face);
            if found > best.0 {
                best = (found, Some(face));
            }
        }
        best.1
    }

    /// Vertices of the outer hull: a coarse polytope of at most 64 vertices that contains the hull.
    /// Empty for a hull that has few vertices itself.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert_eq!(cube.outer_vertices().len(), 0);
    /// # }
    /// ```
    pub fn outer_vertices(&self) -> impl ExactSizeIterator<Item = Vec3> + 'a {
        self.outer_vertices.iter().map(|v| Vec3::from_array(v.map(|c| c.to_native())))
    }

    /// Maximum distance between two vertices, in source units.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert!((cube.diameter() - 12_f64.sqrt()).abs() < 1e-12);
    /// # }
    /// ```
    pub fn diameter(&self) -> f64 {
        self.record.diameter.to_native()
    }

    /// Volume; 0 below rank 3.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert!((cube.volume() - 8.0).abs() < 1e-12);
    /// # }
    /// ```
    pub fn volume(&self) -> f64 {
        self.record.volume.to_native()
    }

    /// Surface area: both sides of a polygon, 0 below rank 2.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert!((cube.surface_area() - 24.0).abs() < 1e-12);
    /// # }
    /// ```
    pub fn surface_area(&self) -> f64 {
        self.record.surface_area.to_native()
    }

    /// Centre of mass at uniform density, in the hull's local frame.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert!(cube.centroid().length() < 1e-12);
    /// # }
    /// ```
    pub fn centroid(&self) -> DVec3 {
        vector(&self.record.centroid)
    }

    /// Second moments about the centroid, divided by the volume (area, length): xx, yy, zz, yz, zx,
    /// xy.
    ///
    /// For the inertia tensor, see [`mass_properties`](Self::mass_properties).
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// let [xx, .., xy] = cube.second_moments();
    /// // The mean of x² over −1 to 1.
    /// assert!((xx - 1.0 / 3.0).abs() < 1e-12 && xy.abs() < 1e-12);
    /// # }
    /// ```
    pub fn second_moments(&self) -> [f64; 6] {
        self.record.second_moments.map(|m| m.to_native())
    }

    /// Minimum and maximum coordinates of the vertices.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// use hullmap::glam::Vec3;
    ///
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert_eq!(cube.bounds(), [Vec3::NEG_ONE, Vec3::ONE]);
    /// # }
    /// ```
    pub fn bounds(&self) -> [Vec3; 2] {
        [&self.record.bounds_min, &self.record.bounds_max].map(|b| Vec3::from_array(b.map(|c| c.to_native())))
    }

    /// Maximum distance of a source point from the hull, divided by the diameter. At most 1e-7.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert!(cube.containment_error() <= 1e-7);
    /// # }
    /// ```
    pub fn containment_error(&self) -> f64 {
        self.record.containment_error.to_native()
    }

    /// Maximum distance by which the hull reaches beyond the convex hull of its source points, in
    /// source units. 0 for an exact hull, positive for a simplified one.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert_eq!(cube.outer_error(), 0.0);
    /// # }
    /// ```
    pub fn outer_error(&self) -> f64 {
        self.record.outer_error.to_native()
    }

    /// Origin of the hull's frame in the frame of the source file. Add it to a point of the hull to
    /// get the source's coordinates. Zero unless the bake recentred; the same for all hulls of a
    /// pack.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert_eq!(cube.origin(), hullmap::glam::DVec3::ZERO);
    /// # }
    /// ```
    pub fn origin(&self) -> DVec3 {
        vector(&self.record.origin)
    }

    /// Index of the hull among the convex parts of its source object, counted from 0. Also 0 for a
    /// hull that is not a part. The parts of an object follow one another.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert_eq!(cube.part(), 0);
    /// # }
    /// ```
    pub fn part(&self) -> u32 {
        self.record.part.to_native()
    }

    /// Maximum distance of a vertex of the source object from the union of its convex parts, in
    /// source units: what a decomposition lost. The same for all parts of an object; 0 for a hull
    /// that is not a part.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert_eq!(cube.uncovered(), 0.0);
    /// # }
    /// ```
    pub fn uncovered(&self) -> f64 {
        self.record.uncovered.to_native()
    }

    /// Kind of the direction index that the hull was baked with.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// println!("{:?}", cube.index_kind());
    /// # }
    /// ```
    pub fn index_kind(&self) -> IndexKind {
        self.index.kind
    }

    /// Size of the direction index in the file, in bytes: words and candidate blocks.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() {
    /// # let pack: hullmap::Pack = pack();
    /// let cube = pack.hull_named("cube").expect("the pack has a cube");
    /// assert!(cube.index_byte_len() > 0);
    /// # }
    /// ```
    pub fn index_byte_len(&self) -> usize {
        size_of_val(self.index.slots) + size_of_val::<[ArchivedBlock]>(self.index.blocks)
    }
}

impl SupportMap for Hull<'_> {
    #[inline(always)]
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        // By name, not as arrays: a round trip through memory would stall the processor here.
        let (feature, [x, y, z]) = self.index.support([dir.x, dir.y, dir.z]);
        SupportPoint { point: DVec3::new(x.into(), y.into(), z.into()), feature }
    }

    #[inline]
    fn interior_point(&self) -> DVec3 {
        self.interior_point
    }

    #[inline]
    fn inner_radius(&self) -> f64 {
        self.record.inner_radius.to_native()
    }

    #[inline]
    fn outer_radius(&self) -> f64 {
        self.record.outer_radius.to_native()
    }

    #[inline]
    fn support_error(&self) -> f64 {
        SUPPORT_ERROR * self.record.outer_radius.to_native()
    }

    #[inline]
    fn point(&self, feature: u32) -> Option<DVec3> {
        let [x, y, z] = self.vertices.get(feature as usize)?;
        Some(DVec3::new(x.to_native().into(), y.to_native().into(), z.to_native().into()))
    }

    #[inline]
    fn support_point_from(&self, dir: DVec3, hint: u32) -> SupportPoint {
        match self.certain(dir.as_vec3().to_array(), hint) {
            Some(point) => SupportPoint { point: DVec3::from_array(point.map(f64::from)), feature: hint },
            None => SupportMap::support_point(self, dir),
        }
    }
}

fn vector(v: &[rkyv::rend::f64_le; 3]) -> DVec3 {
    DVec3::from_array(v.map(|c| c.to_native()))
}

fn run<T>(section: &[T], start: u32_le, end: u32_le) -> Option<&[T]> {
    section.get(start.to_native() as usize..end.to_native() as usize)
}

#[cfg(test)]
mod tests {
    use shapes::{families, rng::SplitMix64};

    use super::*;
    use crate::pack::Pack;

    fn pack(positions: Vec<[f32; 3]>) -> Pack {
        Pack::from_bytes(&hullmap_testkit::packs::tree_bytes(&positions)).unwrap()
    }

    #[test]
    fn instructions_change_no_answer() {
        for positions in [families::rock(500, 1), families::prism(500, 0), families::cube_grid(64, 0)] {
            let pack = pack(positions);
            let best = pack.hull(0).unwrap();
            // Every processor supports these.
            let portable = best.with_instructions(Instructions::Portable).unwrap();
            assert_eq!(portable.instructions(), Instructions::Portable);
            match best.with_instructions(Instructions::Avx2) {
                Some(hull) => {
                    assert_eq!((hull.instructions(), best.instructions()), (Instructions::Avx2, Instructions::Avx2))
                }
                None => assert_eq!(best.instructions(), Instructions::Portable),
            }
            let mut rng = SplitMix64::new(1);
            let mut hint = 0;
            for round in 0..3_000 {
                let mut dir = rng.direction();
                // In directions normal to faces and edges, several vertices tie.
                dir[round % 3] *= [1.0, 0.0, 1e-8][round / 3 % 3];
                let dir = DVec3::from_array(dir);
                assert_eq!(SupportMap::support_point(&best, dir), SupportMap::support_point(&portable, dir), "{dir}");
                let dir = dir.as_vec3();
                assert_eq!(best.support(dir), portable.support(dir), "{dir}");
                assert_eq!(best.support_from(dir, hint), portable.support_from(dir, hint), "{dir} from {hint}");
                assert_eq!(best.support_cost(dir), portable.support_cost(dir));
                hint = best.support(dir).index;
            }
        }
    }

    #[test]
    fn hints_are_certain_within_cones_alone() {
        let pack = pack(families::sphere(300, 4));
        let hull = pack.hull(0).unwrap();
        let (mut certain, mut rng) = (0, SplitMix64::new(2));
        for _ in 0..2_000 {
            let dir = DVec3::from_array(rng.direction()).as_vec3();
            let right = hull.support(dir);
            for hint in 0..hull.vertex_count() as u32 {
                let found = hull.certain(dir.to_array(), hint);
                assert!(
                    found.is_none() || (hint, found) == (right.index, Some(right.point.to_array())),
                    "{dir} {hint}"
                );
            }
            certain += usize::from(hull.certain(dir.to_array(), right.index).is_some());
            assert_eq!(hull.certain(dir.to_array(), u32::MAX), None);
        }
        assert!(certain > 1_900, "{certain} of 2,000");
        // Also the last vertex, at whose edges the section ends.
        let last = hull.vertex_count() as u32 - 1;
        let outward = hull.vertex(last).unwrap();
        assert_eq!(hull.certain(outward.to_array(), last), Some(outward.to_array()));
    }
}
