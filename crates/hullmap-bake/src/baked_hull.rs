//! One hull: built, simplified, certified, measured and indexed.

use hullmap_format::IndexKind;
use hullmap_geometry::PointSet;

use crate::error::BakeError;
use crate::fit::{self, Fit, VoidsShare};
use crate::hull::{self, Hull};
use crate::index::{self, Index};
use crate::interior::{self, Interior};
use crate::mass::{self, Mass};
use crate::outer;
use crate::primitive::ProvenPrimitive;
use crate::progress::Stage;
use crate::simplify::{self, Limit, Simplified};

/// Source file and options, as stored in the pack.
#[derive(Clone, Debug, Default)]
pub struct SourceRecord {
    /// Path of the source relative to the pack's folder, with `/` separators.
    pub path: String,
    /// XXH3-128 of the source's bytes.
    pub hash: u128,
    /// The options that affect the bake, as one line of text.
    pub options: String,
    /// Warnings about the mesh and its hulls, one line each; hashed in the header with the options.
    pub warnings: Vec<String>,
}

/// A hull with its index, ready to be written.
#[derive(Clone, Debug)]
pub struct BakedHull {
    /// Name of the hull.
    pub name: String,
    /// Number of source points from which the hull was built.
    pub point_count: usize,
    /// Origin of the hull's frame in the source's frame.
    pub origin: [f64; 3],
    /// Maximum distance by which the hull exceeds the convex hull of its source points; 0 if exact.
    pub outer_error: f64,
    /// Index among the convex parts of its source object; 0 for a hull that is not a part.
    pub part: u32,
    /// Number of convex parts of its source object; 0 for a hull that is not a part.
    pub part_count: u32,
    /// How it fits the source object; `None` if that was not measured. Only parts are measured.
    pub fit: Option<Fit>,
    /// Mass properties of the source mesh's solid, if known. For a multi-part object, the first
    /// part's value is used.
    pub mesh_mass: Option<Mass>,
    /// Share of that solid that lies in no part, if known. For a multi-part object, the first
    /// part's value is used.
    pub voids: Option<VoidsShare>,
    /// A primitive that may replace it, if one was searched for and found.
    pub primitive: Option<ProvenPrimitive>,
    /// The hull.
    pub hull: Hull,
    /// Its mass properties.
    pub mass: Mass,
    /// Its centroid, inner ball and outer ball.
    pub interior: Interior,
    /// Vertices of the outer hull, a coarse polytope that contains it; empty if the hull is coarse.
    pub outer: Vec<[f32; 3]>,
    /// Its direction index.
    pub index: Index,
}

/// Builds, certifies and indexes the hull of `points`.
///
/// ```
/// use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
///
/// let corners = |i: usize| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32];
/// let cube = PointSet {
///     name: "cube".into(),
///     positions: (0..8).map(corners).collect(),
///     source_vertices: (0..8).collect(),
///     ..PointSet::default()
/// };
/// let baked = bake_hull(&cube, IndexKind::Tree)?;
/// assert_eq!((baked.hull.rank, baked.hull.vertices.len()), (3, 8));
/// assert!((baked.mass.volume - 1.0).abs() < 1e-12);
/// let bytes = write_pack(&[baked], &SourceRecord::default())?;
/// assert!(bytes.starts_with(b"hullmap"));
/// # Ok::<(), hullmap_bake::BakeError>(())
/// ```
///
/// # Errors
/// See [`BakeError`].
///
/// # Complexity
/// O(n log n) on all families tried.
pub fn bake_hull(points: &PointSet, index: IndexKind) -> Result<BakedHull, BakeError> {
    bake_hull_in(points, None, index, Stage::default())
}

/// Builds, simplifies within `limit` if necessary, certifies and indexes the hull of `points`.
///
/// # Errors
/// See [`BakeError`].
///
/// # Complexity
/// The cost of [`bake_hull`] plus the cost of [`simplify`](crate::simplify::simplify).
pub fn bake_simplified_hull(points: &PointSet, limit: Limit, index: IndexKind) -> Result<BakedHull, BakeError> {
    bake_hull_in(points, Some(limit), index, Stage::default())
}

/// Like [`bake_hull`], or with a limit like [`bake_simplified_hull`], as a stage of a computation
/// whose progress is shown.
///
/// # Errors
/// See [`BakeError`].
pub fn bake_hull_in(
    points: &PointSet,
    limit: Option<Limit>,
    index: IndexKind,
    stage: Stage,
) -> Result<BakedHull, BakeError> {
    let exact = hull::build(points)?;
    stage.reach(0.4);
    let simplified = limit.map_or(Ok(None), |limit| simplify::simplify(&exact, limit))?;
    stage.reach(0.7);
    let (hull, outer_error) = match simplified {
        Some(Simplified { mut hull, outer_error }) => {
            // Measure all source points, not only the vertices of the exact hull.
            hull.containment_error = hull::containment_error(&hull, points)?;
            (hull, outer_error)
        }
        None => (exact, 0.0),
    };
    let mass = mass::mass(&hull);
    let interior = interior::interior(&hull, &mass);
    let outer = outer::outer(&hull);
    let index = index::build(&hull, index)?;
    // A collision part has the mass of the mesh that it represents, which all parts share.
    let mesh_mass = if points.stands_for.is_none() { fit::mesh_mass(points) } else { None };
    stage.reach(1.0);
    Ok(BakedHull {
        name: points.name.clone(),
        point_count: points.positions.len(),
        origin: points.origin,
        outer_error,
        part: 0,
        part_count: 0,
        fit: None,
        mesh_mass,
        voids: None,
        primitive: None,
        hull,
        mass,
        interior,
        outer,
        index,
    })
}
