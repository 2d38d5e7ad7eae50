//! Errors of a bake.

use hullmap_format::{height_field::check::LayoutError, triangle_mesh::MAX_TRIANGLES, walk::IndexError};

use crate::hull::certify::CertificateError;
use crate::index::certify::proof::Unproven;
use crate::point_set::MAX_POINTS;
use crate::simplify::limit::MIN_VERTICES;

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
    #[error("the direction index is larger than its slots can address: use --index none, or simplify the mesh")]
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
