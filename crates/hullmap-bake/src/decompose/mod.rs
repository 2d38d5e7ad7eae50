//! Convex decomposition: a concave mesh becomes few convex parts that contain its whole surface and
//! protrude by a limited length, both proven.
//!
//! | file | concept |
//! |---|---|
//! | this one | parameters, and the search for the smallest error with a maximum number of parts |
//! | [`cover`] | the parts for one maximum error |
//! | `merge` | mergers of parts, where there are too many |
//! | `convex` | meshes that need no parts |
//! | `part` | a part as a point set, with the indices of its mesh |
//!
//! ```
//! use hullmap_bake::{PointSet, decompose::{Cover, Length, decompose}};
//!
//! // Two tetrahedra that share a corner.
//! let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let far = corners.map(|p: [f32; 3]| p.map(|x| -x));
//! let outward = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
//! let inward = outward.map(|[a, b, c]: [u32; 3]| [a + 4, c + 4, b + 4]);
//! let mesh = PointSet {
//!     positions: [corners, far].concat(),
//!     source_vertices: (0..8).collect(),
//!     triangles: [outward, inward].concat(),
//!     ..PointSet::default()
//! };
//! let cover = Cover { max_error: Length::Relative(0.02), ..Cover::default() };
//! let parts = decompose(&mesh, &cover)?.expect("the mesh is concave");
//! assert_eq!(parts.len(), 2);
//! # Ok::<(), hullmap_bake::BakeError>(())
//! ```

mod convex;
pub mod cover;
mod merge;
mod part;

use convex::is_convex;
use cover::{CoverLimits, Deadline};
use glam::DVec3;
use merge::merge;
use part::SourceVertices;
use rayon::prelude::*;

use crate::{
    BakeError, PointSet,
    fit::{Accuracy, protrusion, solid::Solid, uncovered_triangles},
    hull::{self, Hull},
    progress::Stage,
};

/// A length, absolute or relative to the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// In the unit of the positions.
    Absolute(f64),
    /// In diagonals of the mesh's box.
    Relative(f64),
}

impl Length {
    /// The length for a mesh with this diagonal.
    pub fn of(self, diagonal: f64) -> f64 {
        match self {
            Self::Absolute(length) => length,
            Self::Relative(share) => share * diagonal,
        }
    }
}

/// Parameters of a cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cover {
    /// Maximum protrusion of a part from the mesh's solid, above 0. With `max_parts`, the search
    /// starts with this limit, and finds the smallest one that suffices.
    pub max_error: Length,
    /// Maximum number of parts, at least 1. It is never exceeded: if `max_error` takes more parts,
    /// `max_error` is exceeded.
    pub max_parts: Option<u32>,
    /// Maximum number of vertices of a part, at least
    /// [`MIN_VERTICES`](crate::simplify::MIN_VERTICES).
    pub max_vertices: u32,
    /// Time after which the search stops, in seconds. The result then depends on the machine, and
    /// its parts may exceed `max_error`. If no cover was found in time, the result is the mesh's
    /// hull.
    pub seconds: Option<f64>,
}

impl Default for Cover {
    fn default() -> Self {
        Self { max_error: Length::Relative(0.02), max_parts: None, max_vertices: 64, seconds: None }
    }
}

/// Smallest limit on the protrusion that is searched for, relative to the diagonal. Parts are
/// rounded and moved outward by up to a tenth of that.
const LEAST_ERROR: f64 = 2e-5;

/// Distance from the parts up to which the surface counts as covered, relative to the diagonal.
const COVERED: f64 = 1e-7;

/// Maximum number of times that a part is built again because it lost vertices.
const BUILDS: usize = 4;

/// Maximum number of rounds in which thin parts are added. Bounds are measured by subtracting
/// parts, so further parts may raise the bound of a triangle that they cut.
const UNCOVERED_ROUNDS: usize = 4;

/// Maximum number of further searches for the smallest limit at which there are few enough parts.
const BISECTIONS: usize = 5;

/// Ratio of the limit that is reached to one that is too small, at which the search ends.
const CLOSE_ENOUGH: f64 = 1.05;

/// Share of the search in the time that it takes to find parts for one limit.
const SEARCH: f64 = 0.9;

/// Number of parts above which neighbours are joined before the best mergers are sought.
const MANY_PARTS: usize = 256;

/// The convex parts of a mesh; `None` if the mesh is convex, or has no triangles or no volume.
///
/// Each part is named after the mesh, with the suffix `_part_00`, `_part_01` and so on. Without a
/// time limit, parts and their order depend on the mesh and the parameters only. A sheet, which has
/// no inside, is covered by thin parts.
///
/// # Errors
/// The errors of [`hull::build`].
///
/// # Complexity
/// See [`cover`].
pub fn decompose(mesh: &PointSet, parameters: &Cover) -> Result<Option<Vec<PointSet>>, BakeError> {
    decompose_in(mesh, parameters, Stage::default())
}

/// Like [`decompose`], as a stage of a computation whose progress is shown.
///
/// # Errors
/// The errors of [`decompose`].
pub fn decompose_in(mesh: &PointSet, parameters: &Cover, stage: Stage) -> Result<Option<Vec<PointSet>>, BakeError> {
    let hull = hull::build(mesh)?;
    if hull.rank < 3 || mesh.triangles.is_empty() || is_convex(mesh, &hull) {
        return Ok(None);
    }
    let vertices = SourceVertices::new(mesh);
    let parts = cover_within(mesh, &vertices, hull, parameters, stage)?;
    let named = |(index, hull)| PointSet { name: format!("{}_part_{index:02}", mesh.name), ..vertices.part(hull) };
    Ok(Some(parts.iter().enumerate().map(named).collect()))
}

/// The hull of a part's vertices in their order in the mesh. Another order may give faces, and thus
/// bounds, that differ by rounding.
fn as_built(vertices: &SourceVertices, mut hull: Hull) -> Hull {
    for _ in 0..BUILDS {
        let Ok(built) = hull::build(&vertices.part(&hull)) else { break };
        let is_same = built.vertices.len() == hull.vertices.len();
        hull = built;
        if is_same {
            break;
        }
    }
    hull
}

/// Adds thin parts for each triangle that is not proven to be covered, for instance one without
/// area, of which no cell is made. A triangle of the mesh protrudes nowhere.
fn add_uncovered(mesh: &PointSet, vertices: &SourceVertices, parts: &mut Vec<Hull>, diagonal: f64, what: &CoverLimits) {
    let thickness = (0.25 * what.limit).min(1e-6 * diagonal);
    for _ in 0..UNCOVERED_ROUNDS {
        let missing = uncovered_triangles(mesh, &parts.iter().collect::<Vec<_>>(), COVERED * diagonal);
        if missing.is_empty() {
            return;
        }
        let thin = missing.into_par_iter().flat_map_iter(|triangle| {
            let corner = |v: u32| DVec3::from_array(mesh.positions[v as usize].map(f64::from));
            let corners = mesh.triangles[triangle].map(corner);
            cover::wrap::of_polygon(&corners, diagonal, thickness, what.max_vertices)
        });
        let thin: Vec<Hull> = thin.map(|hull| as_built(vertices, hull)).collect();
        parts.extend(thin);
    }
}

/// The hulls of a cover, within the maximum number of parts. `hull` is the hull of the mesh, and
/// the result if nothing better is found in time.
fn cover_within(
    mesh: &PointSet,
    vertices: &SourceVertices,
    hull: Hull,
    parameters: &Cover,
    stage: Stage,
) -> Result<Vec<Hull>, BakeError> {
    let deadline = parameters.seconds.map(Deadline::after);
    let max_vertices = (parameters.max_vertices as usize).max(crate::simplify::MIN_VERTICES);
    let max_parts = parameters.max_parts.map(|count| count.max(1) as usize);
    let is_over = || stage.is_cancelled() || deadline.is_some_and(|deadline| deadline.is_over());
    let whole = |hull| Ok(vec![cover::wrap::within_vertices(hull, max_vertices)]);
    if max_parts == Some(1) {
        return whole(hull);
    }
    let solid = Solid::new(mesh);
    let diagonal = solid.diagonal();
    let least = LEAST_ERROR * diagonal;
    let search = |limit: f64, stage: Stage| -> Option<Vec<Hull>> {
        let what = CoverLimits { limit: limit.max(least), max_vertices, deadline, stage: stage.from_to(0.0, SEARCH) };
        let found = cover::search(mesh, &solid, &what)?;
        stage.reach(SEARCH);
        let mut hulls: Vec<Hull> = found.into_par_iter().map(|(hull, _)| as_built(vertices, hull)).collect();
        add_uncovered(mesh, vertices, &mut hulls, diagonal, &what);
        (!hulls.is_empty()).then_some(hulls)
    };
    let limit = parameters.max_error.of(diagonal).max(least);
    // With a maximum number of parts, each search takes about as long as the first.
    let searches = if max_parts.is_some() { 1 + BISECTIONS } else { 1 };
    let stage_of = |index: usize| stage.from_to(index as f64 / searches as f64, (index + 1) as f64 / searches as f64);
    let Some(mut best) = search(limit, stage_of(0)) else { return whole(hull) };
    let Some(max_parts) = max_parts else { return Ok(best) };
    // The greatest limit known to be too small, and the limit that the best parts reach.
    let (mut low, mut reached) = (0.0, limit);
    if best.len() > max_parts {
        low = limit;
        (best, reached) = merged(best, &solid, max_parts, max_vertices)?;
    }
    for round in 1..=BISECTIONS {
        if is_over() || !(reached > least.max(CLOSE_ENOUGH * low)) {
            break;
        }
        let middle = if low > 0.0 { (low * reached).sqrt() } else { 0.25 * reached };
        let Some(found) = search(middle, stage_of(round)) else { break };
        if is_over() {
            // These parts may not be proven.
            break;
        }
        if found.len() <= max_parts {
            (best, reached) = (found, middle);
            continue;
        }
        low = middle;
        if found.len() <= 2 * max_parts {
            let (merged, bound) = merged(found, &solid, max_parts, max_vertices)?;
            if bound < reached {
                (best, reached) = (merged, bound);
            }
        }
    }
    Ok(best)
}

/// Hulls of groups of `parts`, at most `max_parts`, and the greatest bound on their protrusions.
/// Groups grow by the mergers that add the least volume.
fn merged(
    parts: Vec<Hull>,
    solid: &Solid,
    max_parts: usize,
    max_vertices: usize,
) -> Result<(Vec<Hull>, f64), BakeError> {
    let mut sets: Vec<PointSet> = parts.iter().map(|hull| points_of(&hull.vertices)).collect();
    if sets.len() > MANY_PARTS.max(max_parts) {
        sets = clustered(sets, MANY_PARTS.max(max_parts));
    }
    let groups = merge(&sets, max_parts, solid.diagonal())?;
    let hull_of = |group: &Vec<usize>| -> Result<(Hull, f64), BakeError> {
        let points: Vec<[f32; 3]> = group.iter().flat_map(|part| sets[*part].positions.iter().copied()).collect();
        let hull = cover::wrap::within_vertices(hull::build(&points_of(&points))?, max_vertices);
        let bound = protrusion(solid, &hull, &Accuracy::tight(solid.diagonal())).bound;
        Ok((hull, bound))
    };
    let found: Result<Vec<(Hull, f64)>, BakeError> = groups.par_iter().map(hull_of).collect();
    let (hulls, bounds): (Vec<Hull>, Vec<f64>) = found?.into_iter().unzip();
    Ok((hulls, bounds.into_iter().fold(0.0, f64::max)))
}

fn points_of(positions: &[[f32; 3]]) -> PointSet {
    let source_vertices = (0..positions.len() as u32).collect();
    PointSet { positions: positions.to_vec(), source_vertices, ..PointSet::default() }
}

/// Sets of points joined to at most `count` sets: the largest group is halved along the longest
/// side of its box, until there are that many groups.
fn clustered(sets: Vec<PointSet>, count: usize) -> Vec<PointSet> {
    let centres: Vec<DVec3> = sets
        .iter()
        .map(|set| {
            set.positions.iter().map(|p| DVec3::from_array(p.map(f64::from))).sum::<DVec3>()
                / set.positions.len() as f64
        })
        .collect();
    let mut groups: Vec<Vec<usize>> = vec![(0..sets.len()).collect()];
    while groups.len() < count {
        let Some(largest) = (0..groups.len()).max_by_key(|group| (groups[*group].len(), usize::MAX - group)) else {
            break;
        };
        let mut group = groups.swap_remove(largest);
        let (low, high) = cover::body::bounds(&group.iter().map(|set| centres[*set]).collect::<Vec<_>>());
        let axis = cover::body::longest(high - low);
        group.sort_by(|a, b| centres[*a][axis].total_cmp(&centres[*b][axis]).then(a.cmp(b)));
        let second = group.split_off(group.len() / 2);
        groups.extend([group, second]);
    }
    groups
        .iter()
        .filter(|group| !group.is_empty())
        .map(|group| points_of(&group.iter().flat_map(|set| sets[*set].positions.iter().copied()).collect::<Vec<_>>()))
        .collect()
}
