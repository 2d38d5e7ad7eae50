//! Why a pack is rejected: one variant for each requirement that a file may violate.
//!
//! A message states what is wrong, what was found and what was expected. Indices count from zero.
//! Vertices, faces and blocks of a hull are counted from the hull's first.

use crate::{
    archive::MAX_LEVELS,
    index_kind::RecordedKindError,
    mass::MassError,
    primitive::PrimitiveError,
    voids::VoidsError,
    walk::{Cost, IndexError},
};

/// Why an archive is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum CheckError {
    /// The payload is shorter than the archive's root.
    #[error("the archive is {found} bytes long, but its root alone takes {expected}; bake the source again")]
    TooShort { found: usize, expected: usize },
    /// The payload starts at an address that is not a multiple of
    /// [`PAYLOAD_ALIGNMENT`](crate::sections::PAYLOAD_ALIGNMENT).
    #[error("the bytes are not aligned to 64 bytes in memory; copy them to an aligned buffer")]
    Misaligned,
    /// A section does not start at the position to which this version writes it.
    #[error("section {section} starts at byte {found} of the archive instead of {expected}; bake the source again")]
    Section {
        /// The section, or "root".
        section: &'static str,
        found: i64,
        expected: usize,
    },
    /// A section extends past the end of the archive.
    #[error("section {section} has {count} elements, but only {available} bytes remain; bake the source again")]
    SectionLength { section: &'static str, count: usize, available: usize },
    /// The pack has no hulls.
    #[error("the pack has no hulls; bake the source again")]
    NoHulls,
    /// A section that has one element per element of another section has more or fewer.
    #[error("section {section} has {found} elements (expected {expected}); bake the source again")]
    SectionCount { section: &'static str, found: usize, expected: usize },
    /// A hull's run starts before the run of the hull before it.
    #[error("hull {hull}: its {section} start at {found} (expected at least {least}); bake the source again")]
    SpanOrder {
        /// The hull; one past the last for the end of the last hull.
        hull: usize,
        section: &'static str,
        found: u32,
        least: u32,
    },
    /// The run of the first hull does not start at 0.
    #[error("hull 0: its {section} start at {found} (expected 0); bake the source again")]
    FirstSpan { section: &'static str, found: u32 },
    /// The runs of a section do not end where the section ends.
    #[error("the {section} of all hulls end at {found} (expected {expected}); bake the source again")]
    SpanEnd { section: &'static str, found: u32, expected: usize },
    /// A byte between two sections is not zero.
    #[error("byte {offset} of the archive, before section {next_section}, is not zero; bake the source again")]
    Gap {
        /// The section after the gap, or "root".
        next_section: &'static str,
        offset: usize,
    },
    /// A section of text is not UTF-8.
    #[error("section {section} is not UTF-8 from byte {at} on; bake the source again")]
    Text { section: &'static str, at: usize },
    /// A hull is invalid.
    #[error("hull {hull}: {source}; bake the source again")]
    Hull { hull: usize, source: HullError },
    /// The BVH over the hulls is invalid.
    #[error("bounding volume hierarchy: {0}; bake the source again")]
    Bvh(#[from] BvhError),
    /// A record of voids is invalid.
    #[error("voids, {0}; bake the source again")]
    Voids(#[from] VoidsError),
    /// A record of a primitive is invalid.
    #[error("primitives, {0}; bake the source again")]
    Primitive(#[from] PrimitiveError),
}

/// Which requirement a hull violates.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum HullError {
    /// The name is not UTF-8.
    #[error("its name is not UTF-8 from byte {at} on")]
    Name { at: usize },
    /// A length, area, volume or error is negative or not finite.
    #[error("its {field} is {found} (expected a finite number of at least 0)")]
    Length { field: &'static str, found: f64 },
    /// A coordinate or a moment is not finite.
    #[error("component {axis} of its {field} is {found} (expected a finite number)")]
    NotFinite { field: &'static str, axis: usize, found: f64 },
    /// The rank is not 0 to 3.
    #[error("its rank is {found} (expected 0 to 3)")]
    Rank { found: u32 },
    /// A hull of this rank has more or fewer vertices.
    #[error("it has {found} vertices (expected {} for rank {rank})", vertices_of_rank(*rank))]
    VertexCount { rank: u32, found: u32 },
    /// The inner ball is larger than the outer one.
    #[error("its inner radius {inner} is greater than its outer radius {outer}")]
    Radii { inner: f64, outer: f64 },
    /// The part index does not follow the previous hull's.
    #[error("its part is {found} (expected {expected})")]
    Part {
        found: u32,
        /// Index of the next part, or 0 if the hull before completes its object.
        expected: u32,
    },
    /// The number of parts of its object differs from the previous part's, or fewer hulls follow.
    #[error("its object has {found} parts (expected {})", expected_parts(*expected, *left))]
    PartCount {
        found: u32,
        /// Number in the record of the part before it, if there is one.
        expected: Option<u32>,
        left: usize,
    },
    /// The kind of solid is not 0 to 3.
    #[error("its kind of solid is {found} (expected 0 to 3)")]
    Solid { found: u32 },
    /// A hull that was not measured states an uncovered distance or a protrusion.
    #[error("its kind of solid states that it was not measured, but its uncovered distance or its protrusion is not 0")]
    Unmeasured,
    /// A hull that is not a part was measured.
    #[error("it is not a part of an object, but states a kind of solid")]
    MeasuredAlone,
    /// Two parts of an object state different uncovered distances or kinds of solid.
    #[error("its uncovered distance or its kind of solid differs from the part before it")]
    PartsDiffer,
    /// It has several mass records, or one although it is not the first hull of its object.
    #[error("it has {found} mass records (expected at most {expected})")]
    MassCount {
        found: usize,
        /// 1 for the first hull of an object, 0 for its other parts.
        expected: usize,
    },
    /// The mass of its mesh cannot be the mass of a solid.
    #[error("{0}")]
    Mass(#[from] MassError),
    /// Its frame differs from the frame of the other hulls.
    #[error("its origin is {found:?} (expected {expected:?}, the origin of the hull before it)")]
    Origin { found: [f64; 3], expected: [f64; 3] },
    /// A vertex is outside of the bounds, or not finite.
    #[error("vertex {vertex}: coordinate {axis} is {found} (the bounds are {low} to {high})")]
    VertexBounds { vertex: usize, axis: usize, found: f32, low: f32, high: f32 },
    /// Source vertices do not ascend.
    #[error("vertex {vertex}: source vertex {found} does not follow source vertex {before} of the vertex before it")]
    SourceVertexOrder { vertex: usize, found: u32, before: u32 },
    /// A segment or a point has faces, or a polygon or a solid has no faces.
    #[error("it has {faces} faces and {corners} face vertices (rank {rank} {})", faces_of_rank(*rank))]
    FaceCount { rank: u32, faces: usize, corners: usize },
    /// A large hull in a lean pack has faces.
    #[error(
        "it has {faces} faces (a lean pack has none of a hull of {vertex_count} vertices, more than {})",
        crate::archive::LEAN_FACES
    )]
    LeanFaces { vertex_count: u32, faces: usize },
    /// A face has fewer than three vertices, or its run is out of order or out of range.
    #[error(
        "face {face}: its vertices are entries {start}..{end} of {corners} (runs must be contiguous, of 3 entries or more)"
    )]
    FaceRun { face: usize, start: u32, end: u32, corners: usize },
    /// A face refers to a vertex that does not exist.
    #[error("face {face}: vertex index {found} is out of range (the hull has {vertex_count} vertices)")]
    FaceVertex { face: usize, found: u32, vertex_count: u32 },
    /// The numbers of vertices, edges and faces violate Euler's formula for a polyhedron.
    #[error(
        "its {vertices} vertices, {faces} faces and {corners} face vertices (two per edge) violate Euler's formula"
    )]
    Euler {
        vertices: u32,
        faces: usize,
        /// Number of vertices of all faces: twice the number of edges.
        corners: usize,
    },
    /// An entry of the quads does not name the next face with more than four corners.
    #[error("quad {quad}: its face is {found} (expected {})", expected_face(*expected))]
    QuadFace {
        quad: usize,
        found: u32,
        /// The next face with more than four corners; `None` if there are no more.
        expected: Option<u32>,
    },
    /// A face with more than four corners has no entry.
    #[error("face {face} has more than four corners and no quad")]
    QuadMissing { face: usize },
    /// The corners of a quad are not corners of its face, in ascending order.
    #[error("quad {quad}: its corners are {found:?} (they must ascend below {corner_count}, the corners of its face)")]
    QuadCorners { quad: usize, found: [u32; 4], corner_count: u32 },
    /// The fall of a quad is not the sine of an angle from 0 to a right angle.
    #[error("quad {quad}: its fall is {found} (expected 0 to 1)")]
    QuadFall { quad: usize, found: f32 },
    /// The fall of a quad differs from the fall of its face.
    #[error("quad {quad}: its fall is {found} (expected {expected}, from the edges that leave its face)")]
    QuadFallDiffers { quad: usize, found: f32, expected: f32 },
    /// A quad is smaller than half of its face.
    #[error("quad {quad}: it has {share} of the area of its face (expected at least 0.5)")]
    QuadArea { quad: usize, share: f64 },
    /// A run of neighbours is out of order or out of range.
    #[error("vertex {vertex}: its neighbours are entries {start}..{end} of {count} (runs must be contiguous)")]
    NeighbourRun { vertex: usize, start: u32, end: u32, count: usize },
    /// The maximum in the record is wrong.
    #[error("its record states at most {found} neighbours of a vertex (expected {expected})")]
    MaxNeighbours { found: u32, expected: u32 },
    /// A neighbour is a vertex that does not exist.
    #[error("neighbour {entry}: vertex index {found} is out of range (the hull has {vertex_count} vertices)")]
    Neighbour { entry: usize, found: u32, vertex_count: u32 },
    /// The face to the left of an edge does not exist.
    #[error("neighbour {entry}: face index {found} is out of range (the hull has {face_count} faces)")]
    NeighbourFace { entry: usize, found: u32, face_count: u32 },
    /// There are more or fewer neighbours than directed edges of faces.
    #[error("its vertices have {found} neighbours (expected {expected}, one per face vertex)")]
    NeighbourCount { found: usize, expected: usize },
    /// The neighbours of a vertex do not ascend.
    #[error("vertex {vertex}: its neighbours do not ascend at neighbour {found}")]
    NeighbourOrder { vertex: usize, found: u32 },
    /// An edge of a face is not among the neighbours, or a neighbour names a face without it.
    #[error("face {face} and the neighbours disagree on the edge from vertex {from} to vertex {to}")]
    FaceEdge { face: usize, from: u32, to: u32 },
    /// A solid without exactly three edge coordinates per neighbour, or another hull with some.
    #[error("it has {found} edge coordinates (expected {expected})")]
    EdgeCount {
        found: usize,
        /// Three per neighbour for a solid, otherwise 0.
        expected: usize,
    },
    /// The outer hull has too few or too many vertices.
    #[error("its outer hull has {found} vertices (expected 0, or 4 to {})", crate::archive::MAX_OUTER_VERTICES)]
    OuterVertexCount { found: usize },
    /// A coordinate of the outer hull is not finite.
    #[error("vertex {vertex} of its outer hull: coordinate {axis} is {found} (expected a finite number)")]
    OuterVertex { vertex: usize, axis: usize, found: f32 },
    /// The record does not state an index kind.
    #[error(transparent)]
    IndexKind(#[from] RecordedKindError),
    /// There are no candidates.
    #[error("it has no blocks (expected at least 1)")]
    NoBlocks,
    /// The words are not a direction index.
    #[error(transparent)]
    Index(#[from] IndexError),
    /// The worst cost of a query in the record is wrong.
    #[error(
        "its record states a worst case of {} nodes and {} dot products (expected {} and {})",
        found.nodes, found.dots, expected.nodes, expected.dots
    )]
    WorstCost { found: Cost, expected: Cost },
    /// A leaf has more candidates than the hull has vertices.
    #[error("a leaf of its index has {found} candidates (a hull of {vertex_count} vertices has at most {limit})")]
    LeafCandidates {
        found: u32,
        vertex_count: u32,
        /// The vertices, rounded up to whole blocks and to a plain leaf.
        limit: u32,
    },
    /// A lane of a block refers to a vertex that does not exist.
    #[error("block {block}, lane {lane}: vertex index {found} is out of range (the hull has {vertex_count} vertices)")]
    BlockVertex { block: usize, lane: usize, found: u32, vertex_count: u32 },
    /// A lane of a block is outside of the bounds, or not finite.
    #[error("block {block}, lane {lane}: coordinate {axis} is {found} (the bounds are {low} to {high})")]
    BlockBounds { block: usize, lane: usize, axis: usize, found: f32, low: f32, high: f32 },
    /// The position in a lane differs from its vertex's.
    #[error(
        "block {block}, lane {lane}: it has position {found:?} (expected {expected:?}, the position of vertex {vertex})"
    )]
    BlockPosition { block: usize, lane: usize, vertex: u32, found: [f32; 3], expected: [f32; 3] },
    /// An edge is not the direction between its vertices.
    #[error("the edge from vertex {vertex} to vertex {neighbour} is {found:?} (expected {expected:?})")]
    Edge { vertex: usize, neighbour: u32, found: [i16; 3], expected: [i16; 3] },
    /// A run or an index is out of range, in an archive that has not passed
    /// [`contents`](crate::check::contents).
    #[error("its {section} are out of range")]
    OutOfRange { section: &'static str },
}

/// Why nodes are not a bounding volume hierarchy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum BvhError {
    /// The number of leaves differs from the number of hulls.
    #[error("it has {found} nodes (expected {expected})")]
    NodeCount {
        found: usize,
        /// Twice the number of hulls, minus one.
        expected: usize,
    },
    /// No earlier node has this node as a child.
    #[error("node {node} is not a child of any node before it")]
    NoParent { node: usize },
    /// A leaf refers to a hull that does not exist.
    #[error("node {node}: hull index {found} is out of range (the pack has {hull_count} hulls)")]
    Hull { node: usize, found: usize, hull_count: usize },
    /// A hull's record states another leaf.
    #[error("node {node} is the leaf of hull {hull}, whose record states leaf {found}")]
    Leaf { node: usize, hull: usize, found: usize },
    /// The box of a leaf differs from the bounds of its hull.
    #[error("node {node}: its box is not the bounds of hull {hull}")]
    LeafBox { node: usize, hull: usize },
    /// The children of a node are not the next nodes without a parent.
    #[error("node {node}: its first child is {found} (expected {expected})")]
    ChildOrder { node: usize, found: usize, expected: usize },
    /// A child does not exist.
    #[error("node {node}: its children {first} and {} are out of range (the tree has {node_count} nodes)", first + 1)]
    ChildRange { node: usize, first: usize, node_count: usize },
    /// A node states a number of hulls that differs from the number below it.
    #[error("node {node} states {found} hulls (its children have {expected:?})")]
    HullCount { node: usize, found: u32, expected: [u32; 2] },
    /// The box of a node is not the union of its children's boxes.
    #[error("node {node}: its box is not the union of the boxes of its children")]
    Box { node: usize },
    /// The tree has too many levels.
    #[error("it has {found} levels (at most {MAX_LEVELS} are allowed)")]
    Levels { found: u32 },
}

fn vertices_of_rank(rank: u32) -> &'static str {
    match rank {
        0 => "1",
        1 => "2",
        2 => "at least 3",
        _ => "at least 4",
    }
}

fn faces_of_rank(rank: u32) -> &'static str {
    if rank < 2 { "has no faces" } else { "has at least 2 faces" }
}

fn expected_parts(expected: Option<u32>, left: usize) -> String {
    expected.map_or_else(|| format!("at most {left}"), |expected| format!("{expected}, as in the part before it"))
}

fn expected_face(face: Option<u32>) -> String {
    face.map_or_else(|| "no more faces with more than four corners".to_owned(), |face| face.to_string())
}
