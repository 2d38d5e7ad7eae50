//! The rkyv archive behind the header: plain vectors of plain numbers, shared by all hulls of the pack.
//!
//! Each section is one vector; a hull owns one run of it, from its entry in [`Pack::spans`] to the next hull's entry.
//! Numbers inside a run count from the run's start, so that a run can be copied out, or into a GPU buffer, as it is.
//!
//! Nothing here is a bool, enum, string, map or shared pointer: rkyv can then hold no value that is invalid by its
//! bits, and what is left to check is what [`crate::check`] checks.

use rkyv::{Archive, Serialize};

/// Candidates in one [`Block`].
pub const LANES: usize = 8;

/// Everything in a pack.
#[derive(Archive, Serialize, Clone, Debug, Default)]
pub struct Pack {
    /// Candidate blocks that the index points to. They come first, so that they start on a cache line: rkyv itself
    /// aligns to 32 bytes at most.
    pub blocks: Vec<Block>,
    /// Path of the source relative to the pack's folder, UTF-8, `/` between folders; empty where none was recorded.
    pub source_path: Vec<u8>,
    /// The options that shaped the bake, as the baker spells them out, UTF-8.
    pub options: Vec<u8>,
    /// Names of the hulls, UTF-8, one after the other, without separators.
    pub names: Vec<u8>,
    /// Where each hull's runs start; one entry more than there are hulls, the last one naming every section's end.
    pub spans: Vec<Span>,
    /// One record a hull.
    pub hulls: Vec<HullRecord>,
    /// Boxes over the hulls, see [`crate::bvh`]: the root first, then breadth first, two nodes side by side for each inner one.
    /// One leaf a hull: 2H − 1 nodes for H hulls.
    pub nodes: Vec<BvhNode>,
    /// Vertices, source units, the hull's frame; −0 is stored as +0. In ascending order of their source vertices, those that
    /// have none last, by their coordinates.
    pub vertices: Vec<[f32; 3]>,
    /// For each vertex its zero-based number in the source; the first one where several source vertices coincide.
    /// [`NO_SOURCE_VERTEX`] for one that the bake made, of a simplified hull or of a convex part.
    pub source_vertices: Vec<u32>,
    /// For each face the place in its hull's run of `face_vertices` at which its vertices start. They end where the
    /// next face's start, those of a hull's last face at the run's end.
    pub face_starts: Vec<u32>,
    /// Vertices of the faces, numbered from their hull's first, counter-clockwise seen from outside. Each face starts
    /// at its least vertex; faces stand in lexicographic order.
    pub face_vertices: Vec<u32>,
    /// For each vertex the place in its hull's run of `neighbours` at which its neighbours start.
    pub neighbour_starts: Vec<u32>,
    /// Vertices that share an edge with each vertex, ascending.
    pub neighbours: Vec<u32>,
    /// For each entry w of `neighbours`, of vertex v, the face to the left of the edge from v to w: the one in which w
    /// follows v. So a vertex's run names each face at the vertex once. 0 where there are no faces.
    pub neighbour_faces: Vec<u32>,
    /// Vertices of a coarse polytope that holds the hull; none for a hull that is coarse itself.
    pub outer_vertices: Vec<[f32; 3]>,
    /// The direction index: see [`crate::slot`].
    pub slots: Vec<u32>,
    /// For each vertex the directions to its neighbours, as [`crate::edge`] has them: first all first coordinates, then all
    /// second ones, then all third ones. A vertex's run starts at three times the start of its neighbours. Empty for hulls
    /// that are no solids.
    pub edges: Vec<i16>,
}

impl ArchivedPack {
    /// The options that shaped the bake; empty if they are not UTF-8.
    pub fn options_text(&self) -> &str {
        std::str::from_utf8(&self.options).unwrap_or_default()
    }
}

/// Where one hull's runs start in each section.
#[derive(Archive, Serialize, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[rkyv(derive(Debug))]
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
}

/// Facts about one hull. Lengths are in source units, points in the hull's frame: the source's, moved by [`origin`].
///
/// [`origin`]: HullRecord::origin
#[derive(Archive, Serialize, Clone, Copy, Debug, Default, PartialEq)]
#[rkyv(derive(Debug))]
pub struct HullRecord {
    /// Greatest distance between two vertices.
    pub diameter: f64,
    /// Centre of mass at uniform density: of the solid, the polygon, the segment or the point.
    pub centroid: [f64; 3],
    /// A point of the hull up to rounding; strictly inside where the inner radius is above 0.
    pub interior_point: [f64; 3],
    /// Radius of a ball around the interior point that lies in the hull; 0 below rank 3, and for a solid so thin that
    /// rounding leaves none.
    pub inner_radius: f64,
    /// Radius of a ball around the interior point that holds the hull.
    pub outer_radius: f64,
    /// Volume; 0 below rank 3.
    pub volume: f64,
    /// Surface area; both sides of a polygon; 0 below rank 2.
    pub surface_area: f64,
    /// Second moments about the centroid divided by the measure (volume, area or length): xx, yy, zz, yz, zx, xy; all 0
    /// for a point.
    pub second_moments: [f64; 6],
    /// How far the worst source point lies outside the hull, divided by the diameter; 0 for a point.
    pub containment_error: f64,
    /// How far the hull reaches beyond the convex hull of its source points at most, source units; 0 for an exact one.
    pub outer_error: f64,
    /// How far a vertex of the source object lies outside all of its parts at most, source units; the same for all parts of an
    /// object, 0 for a hull that is no part.
    pub uncovered: f64,
    /// Origin of the hull's frame in the source's: what was taken from the source's coordinates. The same for all hulls.
    pub origin: [f64; 3],
    /// Least coordinates of the vertices.
    pub bounds_min: [f32; 3],
    /// Greatest coordinates of the vertices.
    pub bounds_max: [f32; 3],
    /// Dimension: 3 solid, 2 polygon, 1 segment, 0 point.
    pub rank: u32,
    /// Which index: see [`index_kind`].
    pub index_kind: u32,
    /// Cells along the edge of a face of the cube map; 0 for the other kinds.
    pub resolution: u32,
    /// Blocks of a plain leaf: 1, 2 or 4.
    pub leaf_blocks: u32,
    /// Most neighbours of a vertex.
    pub max_neighbours: u32,
    /// Most branches, planes and fans above any leaf: no direction visits more.
    pub max_nodes: u32,
    /// Most lanes of any leaf, [`LANES`] a block, used or not: no direction is multiplied with more vertices.
    pub max_dots: u32,
    /// Source points that the hull was built of; those that coincide count each.
    pub source_points: u32,
    /// Number of its leaf in [`Pack::nodes`].
    pub leaf: u32,
    /// Number among the convex parts of its source object, which stand one after the other; 0 for the first part and for a
    /// hull that is no part.
    pub part: u32,
}

/// A node of the tree of boxes. Two `vec4` in a GPU buffer.
#[derive(Archive, Serialize, Clone, Copy, Debug, Default, PartialEq)]
#[rkyv(derive(Debug))]
pub struct BvhNode {
    /// Least coordinates of the vertices of all hulls below.
    pub bounds_min: [f32; 3],
    /// The hull of a leaf; for an inner node the number of its first child, behind which the second one stands.
    pub target: u32,
    /// Greatest coordinates of the vertices of all hulls below.
    pub bounds_max: [f32; 3],
    /// Hulls below: 1 for a leaf, and for leaves alone.
    pub hull_count: u32,
}

/// Entry of [`Pack::source_vertices`] for a vertex that is none of the source's.
pub const NO_SOURCE_VERTEX: u32 = u32::MAX;

/// Values of [`HullRecord::index_kind`].
pub mod index_kind {
    /// No index: all blocks are scanned.
    pub const SCAN: u32 = 0;
    /// Uniform cube map.
    pub const CUBE_MAP: u32 = 1;
    /// Binary tree over the cube's faces, as the paper has it.
    pub const BINARY: u32 = 2;
    /// Level-compressed tree over the cube's faces.
    pub const TREE: u32 = 3;
}

/// Eight candidates of a leaf, by component: two cache lines.
///
/// A leaf's vertices ascend over all its blocks. The lanes behind them hold some other vertex of the hull, so that a scan
/// needs no count; a leaf that lists all vertices at the ends of the axes repeats its last one.
#[derive(Archive, Serialize, Clone, Copy, Debug, PartialEq)]
#[rkyv(derive(Debug), attr(repr(align(32))))]
pub struct Block {
    /// First coordinates.
    pub x: [f32; LANES],
    /// Second coordinates.
    pub y: [f32; LANES],
    /// Third coordinates.
    pub z: [f32; LANES],
    /// Vertex numbers, counted from the hull's first.
    pub vertex: [u32; LANES],
}
