//! Points → convex hull → direction index → the bytes of a `.hullmap` pack.
//!
//! | module | from | to |
//! |---|---|---|
//! | [`decompose`] | concave mesh | points of its convex parts |
//! | [`hull`] | source points | certified convex hull of rank 3, 2, 1 or 0 |
//! | [`mass`], [`interior`], [`diameter`] | hull | the facts the pack records |
//! | [`outer`] | hull | a coarse polytope around it |
//! | [`simplify`] | hull | one of fewer vertices that holds it |
//! | [`gauss_map`] | hull | normal cones |
//! | [`index`] | normal cones | cube map or tree: words and blocks |
//! | [`bvh`] | bounds of the hulls | the tree of boxes over them |
//! | [`pack`] | baked hulls | bytes |
//!
//! The baker knows no files and no command line: points in, bytes out. Its output is a pure function of its input,
//! whatever the number of threads.
#![forbid(unsafe_code)]

pub mod bvh;
pub mod decompose;
pub mod diameter;
pub mod gauss_map;
pub mod hull;
pub mod index;
pub mod interior;
pub mod mass;
pub mod outer;
pub mod pack;
pub mod simplify;

pub use hullmap_format::archive::NO_SOURCE_VERTEX;
pub use pack::write_pack;

/// Most points of one hull: point numbers are kept in 32 bits, with room for marks.
pub const MAX_POINTS: usize = 1 << 30;

/// One named set of source points, of which one hull is built.
#[derive(Clone, Debug, Default)]
pub struct PointSet {
    /// Name of the hull: the OBJ object's, or the file's stem.
    pub name: String,
    /// Positions in source units.
    pub positions: Vec<[f32; 3]>,
    /// For each position the zero-based number of the vertex in the source file (the `v` lines of an OBJ);
    /// [`NO_SOURCE_VERTEX`] for a point that is none of the source's.
    pub source_vertices: Vec<u32>,
    /// Origin of the positions' frame in the source's frame: what was taken from the source's coordinates.
    pub origin: [f64; 3],
    /// The mesh over the positions, by their numbers; none in a point cloud. [`decompose`] alone looks at it.
    pub triangles: Vec<[u32; 3]>,
}

/// Which direction index a bake builds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IndexKind {
    /// The level-compressed tree over the six cube faces: the fastest.
    Tree {
        /// Size of its leaves.
        leaf_blocks: LeafBlocks,
    },
    /// The fastest of the trees that take at most this many bytes a vertex, words and blocks together; a scan where
    /// none does.
    Budget {
        /// Bytes a vertex.
        bytes_per_vertex: u32,
    },
    /// The paper's binary tree over the six cube faces.
    Binary,
    /// A uniform cube map.
    CubeMap {
        /// Cells along one edge of a cube face, at least 1.
        resolution: u32,
    },
    /// No index: every query scans all vertices.
    None,
}

impl IndexKind {
    /// The tree that most hulls want.
    pub const TREE: Self = Self::Tree { leaf_blocks: LeafBlocks::One };
    /// The tree that takes the fewest bytes.
    pub const COMPACT: Self = Self::Tree { leaf_blocks: LeafBlocks::Four };
}

/// How many blocks of eight candidates a leaf of a tree has: fewer are faster, more take fewer bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeafBlocks {
    /// 8 candidates.
    One,
    /// 16 candidates.
    Two,
    /// 32 candidates.
    Four,
}

impl LeafBlocks {
    /// Candidates of a leaf.
    pub fn lanes(self) -> usize {
        let blocks = match self {
            Self::One => 1,
            Self::Two => 2,
            Self::Four => 4,
        };
        blocks * hullmap_format::archive::LANES
    }
}

/// What the source file was, as the pack records it.
#[derive(Clone, Debug, Default)]
pub struct SourceRecord {
    /// Path of the source relative to the pack's folder, with `/` separators.
    pub path: String,
    /// XXH3-128 of the source's bytes.
    pub hash: u128,
    /// The options that shape the bake, spelt out; the header holds their hash.
    pub options: String,
}

/// Why a hull could not be baked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BakeError {
    /// No points at all.
    #[error("there are no points to build a hull of")]
    Empty,
    /// More points than point numbers reach.
    #[error("{found} points, where at most {MAX_POINTS} can go into one hull: split the mesh")]
    TooManyPoints {
        /// How many there are.
        found: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("source vertex {source_vertex} is not finite")]
    NotFinite {
        /// Zero-based number in the source file.
        source_vertex: u32,
    },
    /// The hull does not keep its promises, and is not written.
    #[error("the hull could not be certified: {what}; please report this mesh")]
    Uncertified {
        /// The broken promise.
        what: String,
    },
    /// The index would need longer words.
    #[error("the direction index has more words than its slots can name: use --index none, or simplify the mesh")]
    IndexTooLarge,
    /// No solid has so few vertices.
    #[error("a hull cannot have {asked} vertices at most: ask for {} or more", simplify::FEWEST)]
    TooFewVertices {
        /// How many were asked for.
        asked: usize,
    },
    /// A distance that is none.
    #[error("{asked} is no distance that a simplified hull may keep: ask for 0 or more")]
    NoDistance {
        /// What was asked for.
        asked: f64,
    },
    /// Rounding to f32 defeats every hull of so few vertices: a flat one far from the origin.
    #[error(
        "no hull of {asked} vertices or fewer that holds it was found: allow more, or bake it closer to the origin"
    )]
    NotSimplified {
        /// How many were asked for.
        asked: usize,
    },
    /// The hulls are not in one frame.
    #[error("the hulls of a pack have different origins: build them in one frame")]
    Origins,
    /// The pack would need longer offsets.
    #[error("the pack would be larger than 2 GiB: split the source into several files")]
    PackTooLarge,
    /// The index just built is not one.
    #[error("the direction index could not be certified: {0}; please report this mesh")]
    Index(#[from] hullmap_format::walk::IndexError),
}

/// A hull with its index, ready to be written.
#[derive(Clone, Debug)]
pub struct BakedHull {
    /// Name of the hull.
    pub name: String,
    /// Source points the hull was built of.
    pub point_count: usize,
    /// Origin of the hull's frame in the source's.
    pub origin: [f64; 3],
    /// How far the hull reaches beyond the convex hull of its source points at most; 0 for an exact one.
    pub outer_error: f64,
    /// How far a vertex of the source object lies outside all of its parts at most; 0 for a hull that is no part.
    pub uncovered: f64,
    /// Number among the convex parts of its source object; 0 for the first, and for a hull that is no part.
    pub part: u32,
    /// The hull.
    pub hull: hull::Hull,
    /// Its mass properties.
    pub mass: mass::Mass,
    /// Its inner and outer ball.
    pub interior: interior::Interior,
    /// Vertices of a coarse polytope that holds it; none if it is coarse itself.
    pub outer: Vec<[f32; 3]>,
    /// Its direction index.
    pub index: index::Index,
}

/// Builds, certifies and indexes the hull of `points`.
///
/// # Errors
/// See [`BakeError`].
///
/// # Complexity
/// O(n log n) on all families tried.
pub fn bake_hull(points: &PointSet, index: IndexKind) -> Result<BakedHull, BakeError> {
    bake(points, hull::build(points)?, 0.0, index)
}

/// The same, of a simplified hull: with no more vertices, or no farther out, than `limit` says. A hull that is within the limit stays as
/// it is.
///
/// # Errors
/// See [`BakeError`].
///
/// # Complexity
/// That of [`bake_hull`], and of [`simplify`](simplify::simplify).
pub fn bake_simplified_hull(
    points: &PointSet,
    limit: simplify::Limit,
    index: IndexKind,
) -> Result<BakedHull, BakeError> {
    let exact = hull::build(points)?;
    match simplify::simplify(&exact, limit)? {
        Some(simplify::Simplified { mut hull, outer_error }) => {
            // Of the source's points, not of the exact hull's vertices alone.
            hull.containment_error = hull::containment_error(&hull, points)?;
            bake(points, hull, outer_error, index)
        }
        None => bake(points, exact, 0.0, index),
    }
}

fn bake(points: &PointSet, hull: hull::Hull, outer_error: f64, index: IndexKind) -> Result<BakedHull, BakeError> {
    let mass = mass::mass(&hull);
    let interior = interior::interior(&hull, &mass);
    let outer = outer::outer(&hull);
    let index = index::build(&hull, index)?;
    Ok(BakedHull {
        name: points.name.clone(),
        point_count: points.positions.len(),
        origin: points.origin,
        outer_error,
        uncovered: 0.0,
        part: 0,
        hull,
        mass,
        interior,
        outer,
        index,
    })
}
