//! Convex decomposition: few convex parts that contain the whole surface of a concave mesh and
//! protrude by a limited length. `fit/coverage.rs` and `fit/protrusion.rs` prove both.
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

mod alone;
mod convex;
mod curve;
mod finish;
mod parameters;
mod part;
pub mod partition;
mod patch;
mod rest;
mod search;

use alone::one_part;
pub use alone::vertices_of_one_part;
use convex::is_convex;
pub use curve::{CurvePoint, curve};
pub use parameters::{Cover, Length, ONE_PART_VERTICES, PART_VERTICES};
use part::SourceVertices;
use partition::{few, field::Field};
use search::Search;

use crate::{
    deadline::{Deadline, Reserve},
    error::BakeError,
    fit::{Frame, Solid, SolidRule},
    hull,
    progress::Stage,
    simplify,
};
use hullmap_geometry::PointSet;

/// Time that a decomposition leaves for measuring its parts.
const MEASURING: Reserve = Reserve { share: 0.2, seconds: 4.0 };

/// The convex parts of a mesh; `None` if the mesh is convex and more than its walls, or has no
/// triangles or no volume.
///
/// Parts are named after the mesh, with the suffix `_part_00`, `_part_01` and so on. Without a time
/// limit, they depend on the mesh and the parameters only. Walls, which have no inside, are covered
/// by parts of the thickness [`wall`](Cover::wall), which is at most half of the maximum error.
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
pub fn decompose_in(mesh: &PointSet, parameters: &Cover, stage: Stage) -> Result<Option<Vec<PointSet>>, BakeError> {
    let deadline = parameters.seconds.map(|seconds| Deadline::after(seconds).with_reserve(MEASURING));
    decompose_by(mesh, parameters, deadline, stage)
}

fn decompose_by(
    mesh: &PointSet,
    parameters: &Cover,
    deadline: Option<Deadline>,
    stage: Stage,
) -> Result<Option<Vec<PointSet>>, BakeError> {
    let hull = hull::build(mesh)?;
    let is_whole = parameters.solid != SolidRule::Walls && is_convex(mesh, &hull);
    if hull.rank < 3 || mesh.triangles.is_empty() || is_whole {
        return Ok(None);
    }
    let frame = Frame::new(mesh);
    let mesh = &frame.of_mesh(mesh);
    let vertices = SourceVertices::new(mesh, &frame);
    let max_vertices = (parameters.part_vertices() as usize).max(simplify::MIN_VERTICES);
    let solid = Solid::in_frame(mesh, parameters.solid);
    let hull = hull::build(mesh)?;
    let alone = match parameters.max_parts {
        None | Some(1) => one_part(hull.clone(), &solid, parameters, parameters.one_part_vertices() as usize),
        Some(_) => None,
    };
    let found = match alone {
        Some((_, hull)) => Some(vec![hull]),
        None if parameters.max_parts == Some(1) => None,
        None => {
            let field = Field::new(&solid);
            Search { mesh, vertices: &vertices, field, parameters, max_vertices, deadline, stage }.hulls()
        }
    };
    let hulls = found.unwrap_or_else(|| vec![few::within_vertices(hull, max_vertices)]);
    stage.reach(1.0);
    let named = |(index, hull)| PointSet { name: format!("{}_part_{index:02}", mesh.name), ..vertices.part(hull) };
    Ok(Some(hulls.iter().enumerate().map(named).collect()))
}

#[cfg(test)]
mod tests;
