//! Convex decomposition: a concave mesh becomes few convex parts that contain its whole surface and
//! protrude by a limited length, both proven.
//!
//! | file | concept |
//! |---|---|
//! | `parameters` | parameters of a cover |
//! | `levels` | the limits for which parts are searched, and which result is taken |
//! | [`partition`] | the parts for one limit |
//! | `rest` | triangles that are not covered |
//! | this one | meshes that need no parts, and finished hulls |
//! | `convex` | whether a mesh needs no parts |
//! | `patch`, `part` | pieces of the surface, a part as a point set |
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
mod levels;
mod parameters;
mod part;
pub mod partition;
mod patch;
mod rest;

use convex::is_convex;
use glam::DVec3;
use levels::Levels;
pub use parameters::{Cover, Length};
use part::SourceVertices;
use partition::{
    Found, Part,
    body::Body,
    shape::{large_faces, tightened},
    wrap,
};
use rayon::prelude::*;
use rest::{Corners, Rest};

use crate::{
    BakeError, PointSet,
    deadline::Deadline,
    fit::{planes::HalfSpace, solid::Solid, uncovered_triangles},
    hull::{self, Hull},
    progress::Stage,
    simplify,
};

/// Distance from the parts up to which the surface counts as covered, relative to the diagonal.
const COVERED: f64 = 1e-7;

/// Maximum number of times that a part is built again because it lost vertices.
const BUILDS: usize = 4;

/// Maximum number of rounds in which triangles that are not proven to be covered are absorbed by
/// parts or become parts, for instance because they have no area. Bounds are measured by
/// subtracting parts, so further parts may raise the bound of a triangle that they cut.
const UNCOVERED_ROUNDS: usize = 4;

/// The convex parts of a mesh; `None` if the mesh is convex, or has no triangles or no volume.
///
/// Each part is named after the mesh, with the suffix `_part_00`, `_part_01` and so on. Without a
/// time limit, parts and their order depend on the mesh and the parameters only. A sheet, which has
/// no inside, is covered by parts of the minimum thickness, which is at most half of the maximum
/// error.
///
/// # Errors
/// The errors of [`hull::build`].
///
/// # Complexity
/// See [`partition`].
pub fn decompose(mesh: &PointSet, parameters: &Cover) -> Result<Option<Vec<PointSet>>, BakeError> {
    decompose_in(mesh, parameters, Stage::default())
}

/// Like [`decompose`], as a stage of a computation whose progress is shown.
///
/// # Errors
/// The errors of [`decompose`].
pub fn decompose_in(mesh: &PointSet, parameters: &Cover, stage: Stage) -> Result<Option<Vec<PointSet>>, BakeError> {
    let deadline = parameters.seconds.map(Deadline::after);
    let hull = hull::build(mesh)?;
    if hull.rank < 3 || mesh.triangles.is_empty() || is_convex(mesh, &hull) {
        return Ok(None);
    }
    let vertices = SourceVertices::new(mesh);
    let max_vertices = (parameters.max_vertices as usize).max(simplify::MIN_VERTICES);
    let solid = Solid::new(mesh);
    let mut levels = Levels::new(mesh, &solid, parameters, max_vertices, stage, deadline);
    let found = if parameters.max_parts == Some(1) { None } else { levels.parts() };
    let hulls = match found {
        Some(parts) => finished(mesh, &vertices, &levels, parts, parameters.max_parts),
        None => vec![wrap::within_vertices(hull, max_vertices)],
    };
    stage.reach(1.0);
    let named = |(index, hull)| PointSet { name: format!("{}_part_{index:02}", mesh.name), ..vertices.part(hull) };
    Ok(Some(hulls.iter().enumerate().map(named).collect()))
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

/// The hulls of parts, and of what they do not cover. They cover the mesh, and are at most
/// `max_parts`.
fn finished(
    mesh: &PointSet,
    vertices: &SourceVertices,
    levels: &Levels,
    found: Found,
    max_parts: Option<u32>,
) -> Vec<Hull> {
    let Found { parts, limit } = found;
    let diagonal = levels.field.solid().diagonal();
    let bounds = levels.last_bounds(limit);
    let corner = |v: u32| DVec3::from_array(mesh.positions[v as usize].map(f64::from));
    let points: Vec<DVec3> = (0..mesh.positions.len() as u32).map(corner).collect();
    let sides: Vec<HalfSpace> = large_faces(&Body::new(&points, 0.0)).collect();
    let thin = levels.bounds_of_thin_parts(limit);
    let search_bounds = levels.bounds(limit);
    let tight = |part: &Part| wrap::thick(&levels.field, tightened(&levels.field, part, &sides, &search_bounds), &thin);
    let tight = |part: &Part| as_built(vertices, tight(part));
    let mut hulls: Vec<Hull> = parts.par_iter().map(tight).collect();
    let max_parts = max_parts.map_or(usize::MAX, |count| count as usize);
    let mut rest = Rest { levels, bounds, thickness: thin.thickness, max_parts, proofs: 0 };
    for _ in 0..UNCOVERED_ROUNDS {
        let missing = uncovered_triangles(mesh, &hulls.iter().collect::<Vec<_>>(), COVERED * diagonal);
        let missing: Vec<Corners> = missing.into_iter().map(|index| mesh.triangles[index].map(corner)).collect();
        if missing.is_empty() {
            break;
        }
        rest.add(&mut hulls, &missing, &|hull| as_built(vertices, hull));
        if bounds.is_over() {
            break;
        }
    }
    hulls
}

#[cfg(test)]
mod tests;
