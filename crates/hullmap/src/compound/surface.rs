//! Signed distance of a point from the surface of a closed triangle mesh.
//!
//! # Steps
//! 1. Decide by exact arithmetic whether the point is inside, outside or on a triangle: by the
//!    number of times that the surface winds around it.
//! 2. Search the nearest triangle, as for a compound. Its distance gets the sign.
//!
//! # Deviations
//! Pseudo-normals (Bærentzen, Aanæs, "Signed Distance Computation Using the Angle Weighted
//! Pseudonormal", 2005) need only the nearest triangle, but require a surface that does not meet
//! itself: where two closed objects of a level overlap, the nearest triangle may be inside one of
//! them. The winding number is correct there as well.

#![forbid(unsafe_code)]

use glam::DVec3;

use super::signed_distance::signed_distance;
use crate::solver::{Cache, Settings, SignedDistance, VectorError};
use crate::triangle_mesh::winding::{Place, TINY};
use crate::triangle_mesh::{OpenSurface, TriangleMesh};

/// Why there is no signed distance.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SurfaceError {
    /// The point is not finite, or too far away.
    #[error(transparent)]
    Point(#[from] VectorError),
    /// The mesh has no inside.
    #[error(transparent)]
    Open(#[from] OpenSurface),
}

/// Signed distance of `point` from the surface of a watertight mesh: negative inside.
///
/// A point is inside if the surface winds around it at least once, with its fronts outwards. So
/// several closed objects may overlap: their union is inside. Where they do, the nearest triangle
/// may be inside another object; the distance is that to the nearest triangle. A mesh with its
/// fronts inwards has no inside.
///
/// The interval contains this distance, and its sign is exact: it is decided without rounding, also
/// for points above edges and corners. `point` of the answer is the nearest point of the surface,
/// and `normal` the gradient of the distance, at distance 0 a normal of a triangle there.
///
/// Lengths are in the mesh's unit, points and directions in its frame. `cache` belongs to the mesh
/// and to points near this one; the query reads and updates it.
///
/// # Errors
/// [`SurfaceError::Open`] if the mesh has an edge that not exactly two triangles share, front
/// beside front, and [`SurfaceError::Point`] as for [`signed_distance`](crate::signed_distance()).
///
/// # Complexity
/// Branch and bound for the nearest triangle, and one descent of the tree along an axis for the
/// sign. No allocation.
///
/// # Examples
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use hullmap::glam::DVec3;
/// use hullmap::{Cache, Settings, TriangleMesh, compound};
/// # use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
/// # let positions = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
/// # let corners = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
/// # let baked = bake_triangle_mesh(&Triangles { positions: &positions, corners: &corners, materials: &[] })?;
/// # let file = write_triangle_mesh(baked, &Default::default())?;
///
/// // A tetrahedron with corners at the origin and 4 along each axis.
/// let mesh = TriangleMesh::from_bytes(&file)?;
/// let (settings, mut cache) = (Settings::default(), Cache::new());
/// let mut at = |x: f64| compound::surface_distance(&mesh, DVec3::new(x, 1.0, 1.0), &settings, &mut cache);
/// assert!((at(0.25)?.distance + 0.25).abs() < 1e-12);
/// let outside = at(-2.0)?;
/// assert!((outside.distance - 2.0).abs() < 1e-12 && outside.normal.distance(DVec3::NEG_X) < 1e-12);
/// # Ok(())
/// # }
/// ```
pub fn surface_distance(
    mesh: &TriangleMesh,
    point: DVec3,
    settings: &Settings,
    cache: &mut Cache,
) -> Result<SignedDistance, SurfaceError> {
    mesh.check_closed()?;
    let mut answer = signed_distance(mesh, point, settings, cache)?;
    // A triangle has no inside. Beside it, the nearest point gives the gradient.
    (answer.distance, answer.lower) = (answer.distance.max(0.0), answer.lower.max(0.0));
    answer.upper = answer.upper.max(0.0) + TINY;
    match mesh.place(point) {
        Place::On => {
            (answer.distance, answer.lower) = (0.0, 0.0);
            if let Some(normal) = mesh.normal(answer.part as usize) {
                answer.normal = normal;
            }
        }
        Place::Around(turns) if turns >= 1 => {
            (answer.lower, answer.upper) = (-answer.upper, -answer.lower);
            (answer.distance, answer.normal) = (-answer.distance, -answer.normal);
        }
        Place::Around(_) => {}
    }
    Ok(answer)
}
