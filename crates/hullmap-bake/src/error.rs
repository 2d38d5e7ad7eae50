//! Errors of a bake.

use hullmap_format::{height_field::check::LayoutError, triangle_mesh::MAX_TRIANGLES, walk::IndexError};

use crate::limit::MIN_VERTICES;
use glam::DVec3;
use hullmap_geometry::MAX_POINTS;
use hullmap_geometry::number::short;

/// Why a hull could not be baked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum BakeError {
    /// There are no points.
    #[error("there are no points to build a hull from")]
    Empty,
    /// There are more points than point indices can address.
    #[error("a hull can be built from at most {MAX_POINTS} points (found {found}): split the mesh")]
    TooManyPoints { found: usize },
    /// There are more triangles than the nodes of a tree can address.
    #[error("a triangle mesh has at most {MAX_TRIANGLES} triangles (found {found}): split the mesh")]
    TooManyTriangles { found: usize },
    /// A corner of a triangle is not a vertex.
    #[error("triangle {triangle} has the vertex {found}, but there are {vertex_count}")]
    Corner { triangle: usize, found: u32, vertex_count: usize },
    /// There are materials, but not one for each triangle.
    #[error("there are {found} materials for {expected} triangles: name one for each triangle, or none")]
    Materials { found: usize, expected: usize },
    /// The grid of a height field has no cells, too many, or coordinates that do not rise.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// There are not as many heights, holes or materials as the grid has vertices or cells.
    #[error("there are {found} {what} for a grid with {expected}: name one for each, or none")]
    GridCount { what: &'static str, found: usize, expected: usize },
    /// A height is infinite.
    #[error("the height at column {column}, row {row} is infinite: use NaN for a vertex without ground")]
    InfiniteHeight { column: usize, row: usize },
    /// All cells are holes.
    #[error("every cell of the height field is a hole: at least one cell needs a height at all four vertices")]
    OnlyHoles,
    /// A coordinate is NaN or infinite.
    #[error("source vertex {source_vertex} is not finite")]
    NotFinite {
        /// Zero-based index in the source file.
        source_vertex: u32,
    },
    /// The hull fails its certificate.
    #[error("the hull could not be certified: {0}; please report this mesh")]
    Uncertified(#[from] CertificateError),
    /// The index has more words or blocks than slots can address.
    #[error("the direction index is larger than its slots can address: use --set index=none, or simplify the mesh")]
    IndexTooLarge,
    /// The requested maximum is below the vertices of a tetrahedron.
    #[error("a simplified hull requires at least {} vertices (the requested maximum is {requested})", MIN_VERTICES)]
    TooFewVertices { requested: usize },
    /// The requested distance is negative or NaN.
    #[error("the maximum error of a simplified hull must be at least 0 (requested {requested})")]
    InvalidDistance { requested: f64 },
    /// Rounding to f32 defeats every hull with this few vertices, for instance if the hull is flat
    /// and far from the origin.
    #[error(
        "found no hull of at most {requested} vertices that contains this one: allow more vertices, or move the mesh closer to the origin"
    )]
    NotSimplified { requested: usize },
    /// The hulls have different origins.
    #[error("the hulls of a pack have different origins: build them in one frame")]
    Origins,
    /// The parts of an object are not consecutive or not complete, or state different kinds of
    /// solid or uncovered distances; or a hull that is not a part was measured.
    #[error("hull {hull} does not continue the parts before it: write the parts of an object one after the other")]
    Parts { hull: usize },
    /// The pack would be larger than 32-bit offsets can address.
    #[error("the pack would be larger than 2 GiB: split the source into several files")]
    PackTooLarge,
    /// The direction index is malformed. This is a bug.
    #[error("the direction index could not be certified: {0}; please report this mesh")]
    Index(#[from] IndexError),
    /// Not even a scan of all vertices is proven to be exact. This is a bug.
    #[error("no direction index could be proven: {0}; please report this mesh")]
    Unproven(Unproven),
}

/// Why a hull fails its certificate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum CertificateError {
    /// A source point is too far outside the hull.
    #[error(
        "a source point is {} of the diameter outside of the hull (at most {CONTAINMENT:e} is allowed)",
        short(*error)
    )]
    Containment {
        /// Distance relative to the diameter; NaN if unknown.
        error: f64,
    },
    /// The faces do not form a closed, consistently oriented surface.
    #[error(
        "its faces are not a closed surface (V - E + F is {euler}; every edge must be in two faces, once in each direction)"
    )]
    Surface {
        /// V − E + F; 2 for a polyhedron.
        euler: i64,
    },
    /// A face is degenerate or faces inward.
    #[error("face {face} is degenerate or faces inward")]
    Inward { face: usize },
}

/// Maximum distance of a source point from the hull, relative to the hull's diameter.
pub const CONTAINMENT: f64 = 1e-7;

/// Maximum regret of a proven index, relative to the diameter. A support query is exact up to
/// 2e-7, of which the hull's distance from its source points may take the other half.
pub const REGRET_LIMIT: f64 = 1e-7;

/// Why an index is not proven.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum Unproven {
    /// A leaf does not list a support vertex.
    #[error("in direction {direction}, the leaf at word {slot} does not list support vertex {vertex}")]
    Missing { slot: usize, vertex: u32, direction: DVec3 },
    /// No arc crosses a leaf, and none of its candidates is the support vertex there.
    #[error("in direction {direction}, the leaf at word {slot} does not list the support vertex")]
    Elsewhere { slot: usize, direction: DVec3 },
    /// The region of a leaf is so thin that rounding error may matter.
    #[error(
        "the leaf at word {slot} has a region so thin that its regret may reach {bound:.1e} of the diameter (at most {REGRET_LIMIT:.1e} is exact)"
    )]
    Thin { slot: usize, bound: f64 },
    /// A lane of a block does not hold a vertex of the hull.
    #[error("lane {lane} of block {block} does not hold a vertex of the hull")]
    Lane { block: usize, lane: usize },
    /// A plane or a fan has a vector that is not of unit length, or a step of a fan does not start
    /// at its own angle.
    #[error("the node at word {at} has a vector that is not of unit length, or a step at the wrong angle")]
    Node { at: usize },
    /// Nodes are shared so that a proof would take too long.
    #[error("a proof would take too long: the index visits its nodes too often")]
    Work,
}
