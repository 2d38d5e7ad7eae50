//! The rkyv archive after the header: vectors of plain numbers, shared by all hulls of the pack.
//!
//! Each section is one vector. A hull owns one run of it, from its entry in [`Pack::spans`] to the
//! next hull's entry. Indices inside a run count from the run's start, so that a run can be copied
//! elsewhere, for instance into a GPU buffer, without changes.
//!
//! No field is a bool, enum, string, map or shared pointer. So every bit pattern is a valid value
//! of its type, and only the checks of [`crate::check`] remain.

use bytemuck::{Pod, Zeroable};
use rkyv::{
    Archive, Serialize,
    rancor::Fallible,
    ser::{Allocator, Writer},
};

/// Candidates in one [`Block`].
pub const LANES: usize = 8;

/// Maximum number of vertices of an outer hull. A query reads all of them.
pub const MAX_OUTER_VERTICES: usize = 64;

/// Maximum number of levels of the BVH, with the root's: a reader's stack can have a fixed size.
pub const MAX_LEVELS: u32 = 32;

/// Maximum number of vertices of a hull that keeps its faces in a lean pack. The runtime solves
/// deep contacts of such small hulls by their faces.
pub const LEAN_FACES: u32 = 32;

/// Everything in a pack.
///
/// In a lean pack `quads`, `neighbour_starts`, `neighbours`, `neighbour_faces` and `edges` are
/// empty, and hulls of more than [`LEAN_FACES`] vertices have no faces.
#[derive(Archive, Serialize, Clone, Debug, Default)]
pub struct Pack {
    /// Candidate blocks that the index points to. They come first, so that they start on a cache
    /// line: rkyv itself aligns to 32 bytes at most.
    pub blocks: Vec<Block>,
    /// Path of the source relative to the pack's folder, UTF-8, with `/`; empty if not recorded.
    pub source_path: Vec<u8>,
    /// The options that shaped the bake, as the baker writes them, then a line per warning; UTF-8.
    pub options: Vec<u8>,
    /// Names of the hulls, UTF-8, one after the other, without separators.
    pub names: Vec<u8>,
    /// Start of each hull's runs, and a last entry with the end of every section.
    pub spans: Vec<Span>,
    /// One record per hull.
    pub hulls: Vec<HullRecord>,
    /// Mass of an object's mesh, in the run of its first hull: none or one record.
    pub masses: Vec<MassRecord>,
    /// BVH over the hulls, see [`crate::bvh`]: the root, then the other nodes breadth first. The
    /// two children of a node are adjacent. One leaf per hull: 2H − 1 nodes for H hulls.
    pub nodes: Vec<BvhNode>,
    /// Vertices in source units and in the hull's frame, with −0 as +0, by ascending source vertex.
    /// Vertices without one come last, by coordinates.
    pub vertices: Vec<[f32; 3]>,
    /// Zero-based index of each vertex in the source; the lowest, if several coincide.
    /// [`NO_SOURCE_VERTEX`] for a vertex that the bake created.
    pub source_vertices: Vec<u32>,
    /// For each face, the position in its hull's run of `face_vertices` at which its vertices
    /// start. They end where the next face's start; the last face's end with the run.
    pub face_starts: Vec<u32>,
    /// Vertices of the faces, as indices from the hull's first vertex, counter-clockwise seen from
    /// outside. Each face starts with its lowest index. Faces are in lexicographic order.
    pub face_vertices: Vec<u32>,
    /// One entry for each face with more than four corners, in the order of the faces.
    pub quads: Vec<Quad>,
    /// For each vertex, the position of its first neighbour in its hull's run of `neighbours`.
    pub neighbour_starts: Vec<u32>,
    /// Vertices that share an edge with each vertex, ascending.
    pub neighbours: Vec<u32>,
    /// For each neighbour w of a vertex v, the face in which w follows v: so a vertex's run
    /// contains each face at the vertex once. 0 for hulls without faces.
    pub neighbour_faces: Vec<u32>,
    /// Vertices of the outer hull, a coarse polytope that contains the hull; empty for a hull that
    /// is coarse itself.
    pub outer_vertices: Vec<[f32; 3]>,
    /// The direction index: see [`crate::slot`].
    pub slots: Vec<u32>,
    /// For each vertex, the directions to its neighbours, encoded as in [`crate::edge`]: all first
    /// coordinates, then all second ones, then all third ones. A vertex's run starts at three times
    /// the start of its neighbours. Empty for hulls of rank below 3.
    pub edges: Vec<i16>,
}

/// A pack with sections that only some packs have. Its root is the root of [`Pack`], which comes
/// last, with an entry for each further section in front.
#[derive(Archive, Clone, Debug, Default)]
pub struct ExtendedPack {
    /// One record for each object whose voids are known, in the order of the objects.
    pub voids: Vec<VoidsRecord>,
    /// One record for each part that a primitive can replace, in the order of the hulls.
    pub primitives: Vec<PrimitiveRecord>,
    /// The sections that all packs have.
    pub pack: Pack,
}

/// The sections that all packs have come first in the file, as in every pack.
impl<S> Serialize<S> for ExtendedPack
where
    S: Fallible + Allocator + Writer + ?Sized,
{
    fn serialize(&self, serializer: &mut S) -> Result<Self::Resolver, S::Error> {
        let pack = self.pack.serialize(serializer)?;
        let voids = self.voids.serialize(serializer)?;
        Ok(ExtendedPackResolver { voids, primitives: self.primitives.serialize(serializer)?, pack })
    }
}

/// Start of one hull's runs in each section.
#[derive(Archive, Serialize, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[rkyv(derive(Clone, Copy, Debug, Pod, Zeroable))]
pub struct Span {
    /// In [`Pack::names`].
    pub name: u32,
    /// In [`Pack::vertices`], [`Pack::source_vertices`] and [`Pack::neighbour_starts`].
    pub vertex: u32,
    /// In [`Pack::face_starts`].
    pub face: u32,
    /// In [`Pack::face_vertices`].
    pub face_vertex: u32,
    /// In [`Pack::neighbours`] and [`Pack::neighbour_faces`].
    pub neighbour: u32,
    /// In [`Pack::slots`].
    pub slot: u32,
    /// In [`Pack::blocks`].
    pub block: u32,
    /// In [`Pack::outer_vertices`].
    pub outer: u32,
    /// In [`Pack::edges`].
    pub edge: u32,
    /// In [`Pack::quads`].
    pub quad: u32,
    /// In [`Pack::masses`].
    pub mass: u32,
}

/// Facts about one hull. Lengths are in source units, points in the hull's frame: the source's
/// frame, moved by [`origin`](HullRecord::origin).
#[derive(Archive, Serialize, Clone, Copy, Debug, Default, PartialEq)]
#[rkyv(derive(Clone, Copy, Debug, Pod, Zeroable))]
pub struct HullRecord {
    /// Maximum distance between two vertices.
    pub diameter: f64,
    /// Centre of mass at uniform density: of the solid, the polygon, the segment or the point.
    pub centroid: [f64; 3],
    /// A point of the hull up to rounding error; strictly inside if the inner radius is above 0.
    pub interior_point: [f64; 3],
    /// Radius of a ball around the interior point that lies in the hull; 0 below rank 3, and for a
    /// solid so thin that rounding error leaves no ball.
    pub inner_radius: f64,
    /// Radius of a ball around the interior point that contains the hull.
    pub outer_radius: f64,
    /// Volume; 0 below rank 3.
    pub volume: f64,
    /// Surface area; both sides of a polygon; 0 below rank 2.
    pub surface_area: f64,
    /// Second moments about the centroid divided by the measure (volume, area or length): xx, yy,
    /// zz, yz, zx, xy; all 0 for a point.
    pub second_moments: [f64; 6],
    /// Maximum distance of a source point from the hull, relative to the diameter; 0 for a point.
    pub containment_error: f64,
    /// Maximum distance by which the hull exceeds the convex hull of its source points; 0 if exact.
    pub outer_error: f64,
    /// Upper bound on how far the source object's surface lies outside all its parts; equal for all
    /// parts. 0 if [`solid`](HullRecord::solid) is 0: not measured.
    pub uncovered: f64,
    /// Upper bound on how far the part leaves the source object's solid. 0 if
    /// [`solid`](HullRecord::solid) is 0: not measured.
    pub protrusion: f64,
    /// The point where the part protrudes most, as far as known. 0 if [`solid`](HullRecord::solid)
    /// is 0.
    pub protrusion_at: [f64; 3],
    /// Origin of the hull's frame in the source's, equal for all hulls.
    pub origin: [f64; 3],
    /// Minimum coordinates of the vertices.
    pub bounds_min: [f32; 3],
    /// Maximum coordinates of the vertices.
    pub bounds_max: [f32; 3],
    /// Dimension: 3 solid, 2 polygon, 1 segment, 0 point.
    pub rank: u32,
    /// Code of the index kind: see [`IndexKind::code`](crate::IndexKind::code).
    pub index_kind: u32,
    /// Cells along the edge of a face of the cube map; 0 for the other kinds.
    pub resolution: u32,
    /// Blocks of a plain leaf: 1, 2 or 4.
    pub leaf_blocks: u32,
    /// Maximum number of neighbours of a vertex.
    pub max_neighbours: u32,
    /// Maximum number of branches, planes and fans above any leaf.
    pub max_nodes: u32,
    /// Maximum number of lanes of any leaf, [`LANES`] per block, used or not: bounds dot products.
    pub max_dots: u32,
    /// Number of source points that the hull was built from. Coincident points are all counted.
    pub source_points: u32,
    /// Index of the hull's leaf in [`Pack::nodes`].
    pub leaf: u32,
    /// Index among the convex parts of the source object, which are stored consecutively. 0 for the
    /// first part, and for a hull that is not a part.
    pub part: u32,
    /// Number of convex parts of the source object; 0 for a hull that is not a part.
    pub part_count: u32,
    /// Code of the kind of solid that the part was measured against: see
    /// [`SolidKind::code`](crate::SolidKind::code). 0 if it was not measured.
    pub solid: u32,
}

/// Mass properties of the solid of an object's mesh, at uniform density, in the frame of the hulls.
#[derive(Archive, Serialize, Clone, Copy, Debug, Default, PartialEq)]
#[rkyv(derive(Clone, Copy, Debug, Pod, Zeroable))]
pub struct MassRecord {
    /// Volume, above 0.
    pub volume: f64,
    /// Centre of mass.
    pub centroid: [f64; 3],
    /// Second moments about the centre, divided by the volume: xx, yy, zz, yz, zx, xy.
    pub second_moments: [f64; 6],
}

/// The share of a solid's volume that lies in none of its parts. An estimate.
#[derive(Archive, Serialize, Clone, Copy, Debug, Default, PartialEq)]
#[rkyv(derive(Clone, Copy, Debug, Pod, Zeroable))]
pub struct VoidsRecord {
    /// Index of the first part of the object in [`Pack::hulls`].
    pub hull: u32,
    /// Volume in no part, relative to the volume of the solid: 0 to 1.
    pub share: f32,
    /// Error of the share: 0 to 1.
    pub error: f32,
}

/// A primitive that contains the surface in a part, and may replace it. In the hulls' frame.
#[derive(Archive, Serialize, Clone, Copy, Debug, Default, PartialEq)]
#[rkyv(derive(Clone, Copy, Debug, Pod, Zeroable))]
pub struct PrimitiveRecord {
    /// Index of the part in [`Pack::hulls`].
    pub hull: u32,
    /// Code of the kind: see [`PrimitiveKind::code`](crate::PrimitiveKind::code).
    pub kind: u32,
    /// Centre.
    pub center: [f64; 3],
    /// Rotation from its own axes: a unit quaternion, its scalar part last.
    pub rotation: [f64; 4],
    /// Box: half extents. Sphere: radius. Capsule and cylinder: radius, and half the length of the
    /// axis, which is z. The rest is 0.
    pub sizes: [f64; 3],
    /// Upper bound on how far a point of it lies outside the source object's solid.
    pub protrusion: f64,
}

/// A node of the bounding volume hierarchy (BVH). Two `vec4` in a GPU buffer.
#[derive(Archive, Serialize, Clone, Copy, Debug, Default, PartialEq)]
#[rkyv(derive(Clone, Copy, Debug, Pod, Zeroable))]
pub struct BvhNode {
    /// Minimum coordinates of the vertices of all hulls below.
    pub bounds_min: [f32; 3],
    /// A leaf's hull, or the first of an inner node's two adjacent children.
    pub target: u32,
    /// Maximum coordinates of the vertices of all hulls below.
    pub bounds_max: [f32; 3],
    /// Number of hulls below: 1 for a leaf, at least 2 for an inner node.
    pub hull_count: u32,
}

/// Four corners that stand for a face with more than four corners in a contact manifold.
#[derive(Archive, Serialize, Clone, Copy, Debug, Default, PartialEq)]
#[rkyv(derive(Clone, Copy, Debug, Pod, Zeroable))]
pub struct Quad {
    /// The face.
    pub face: u32,
    /// Positions among the corners of the face, ascending. Their quadrilateral has at least half of
    /// the face's area.
    pub corners: [u32; 4],
    /// How steeply the surface falls away from the face: see [`crate::quad::falls`].
    pub fall: f32,
}

/// Entry of [`Pack::source_vertices`] for a vertex that is not in the source.
pub const NO_SOURCE_VERTEX: u32 = u32::MAX;

/// Eight candidates of a leaf, by component: two cache lines.
///
/// A leaf's vertices ascend over all its blocks. Each lane after them holds some other vertex of
/// the hull, so that a scan needs no count. A leaf that lists all vertices at the ends of the axes
/// repeats its last vertex instead.
#[derive(Archive, Serialize, Clone, Copy, Debug, PartialEq)]
#[rkyv(derive(Clone, Copy, Debug, Pod, Zeroable), attr(repr(align(32))))]
pub struct Block {
    /// First coordinates.
    pub x: [f32; LANES],
    /// Second coordinates.
    pub y: [f32; LANES],
    /// Third coordinates.
    pub z: [f32; LANES],
    /// Vertex indices, counted from the hull's first.
    pub vertex: [u32; LANES],
}
