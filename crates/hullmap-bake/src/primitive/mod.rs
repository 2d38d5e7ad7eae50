//! Primitives that replace parts: a box, a sphere, a capsule or a cylinder within both bounds of
//! the part.
//!
//! # Steps
//! 1. Clip the mesh's triangles by the planes of the part, moved outward by what the parts leave
//!    uncovered. The primitive must contain the corners of all pieces.
//! 2. Find the smallest primitive of each kind around these points.
//! 3. Prove the smallest one, or else the next one: the polytope around it must protrude by at most
//!    the limit.
//!
//! # Why the bounds hold
//! - *Cover.* Each point of the surface is in a part, to within what the parts leave uncovered, so
//!   in a piece of some part. A convex primitive contains the piece whose corners it contains.
//! - *Protrusion.* The polytope contains the primitive, whose support point along each face's
//!   normal is behind the face. It is measured like any part.
//!
//! Overlap and voids are measured on the hulls, not on the primitives.

pub mod around;
pub mod candidates;
mod shape;

use glam::DVec3;
use rayon::prelude::*;

pub use shape::Primitive;

use crate::{
    deadline::{Deadline, is_over},
    decompose::partition::body::Body,
    fit::{Accuracy, Fit, Solid, protrusion},
    hull::Hull,
};
use hullmap_geometry::{PointSet, bounds, planes};

/// Distance by which primitives are larger than the smallest one around their points, relative to
/// the diagonal: more than rounding to stored coordinates moves a point.
const MARGIN: f64 = 1e-9;

/// Share of the limit by which the polytope may protrude more than the primitive in it.
const EXCESS: f64 = 0.04;

/// A primitive with its proven bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProvenPrimitive {
    /// The primitive.
    pub primitive: Primitive,
    /// Upper bound on how far a point of it lies outside the mesh's solid.
    pub protrusion: f64,
}

/// Limits of primitives.
#[derive(Clone, Copy, Debug)]
pub struct PrimitiveLimits {
    /// Maximum protrusion from the solid.
    pub protrusion: f64,
    /// Time after which no more primitives are searched for.
    pub deadline: Option<Deadline>,
}

/// For each part of `mesh` the smallest primitive that can replace it; `None` where there is none.
/// `fits` are the bounds of the parts. Protrusion counts from `solid`.
///
/// # Complexity
/// For each part, a pass over the triangles, and at most four proofs.
pub fn primitives(
    solid: &Solid,
    mesh: &PointSet,
    parts: &[&Hull],
    fits: &[Fit],
    limits: &PrimitiveLimits,
) -> Vec<Option<ProvenPrimitive>> {
    let replaced = |(part, fit): (&&Hull, &Fit)| {
        if part.rank < 3 || is_over(limits.deadline) {
            return None;
        }
        let mut points = contained(mesh, part, fit.uncovered, solid.diagonal());
        if points.is_empty() {
            points.extend(part.positions());
        }
        of_points(solid, &points, limits)
    };
    parts.par_iter().zip(fits).map(replaced).collect()
}

/// The corners of all pieces of the mesh's surface that are at most `uncovered` outside a part.
pub fn contained(mesh: &PointSet, part: &Hull, uncovered: f64, diagonal: f64) -> Vec<DVec3> {
    let room = uncovered + MARGIN * diagonal;
    let planes: Vec<_> = part.half_spaces().into_iter().map(|plane| plane.moved(room)).collect();
    let [low, high] = bounds(part.positions());
    let mut points = Vec::new();
    for triangle in &mesh.triangles {
        let corners = mesh.corners(triangle);
        let [least, greatest] = bounds(corners);
        if least.cmpgt(high + room).any() || greatest.cmplt(low - room).any() {
            continue;
        }
        points.extend(planes::divide(&corners, &planes, 0.0).0);
    }
    points
}

fn of_points(solid: &Solid, points: &[DVec3], limits: &PrimitiveLimits) -> Option<ProvenPrimitive> {
    let diagonal = solid.diagonal();
    let body = Body::new(points, 0.0);
    let mut found = candidates::candidates(&body, MARGIN * diagonal);
    found.retain(|primitive| points.iter().all(|p| primitive.holds(*p, 0.0)));
    found.sort_by(|a, b| a.volume().total_cmp(&b.volume()));
    found.into_iter().find_map(|primitive| {
        let protrusion = proven(solid, &primitive, limits.protrusion, limits.deadline)?;
        Some(ProvenPrimitive { primitive, protrusion })
    })
}

/// A bound on how far a primitive protrudes from a solid, if it is at most `limit`; `None` also if
/// the deadline passes first.
pub fn proven(solid: &Solid, primitive: &Primitive, limit: f64, deadline: Option<Deadline>) -> Option<f64> {
    let diagonal = solid.diagonal();
    // Most primitives that protrude are refuted by a few points. Written so that NaN fails.
    if !around::surface_points(primitive).iter().all(|p| solid.distance(*p) <= limit) {
        return None;
    }
    let polytope = around::polytope(primitive, EXCESS * limit, diagonal)?;
    let mut found = protrusion(solid, &polytope, &Accuracy { deadline, ..Accuracy::tight(diagonal) }).bound;
    if found > limit {
        found = protrusion(solid, &polytope, &Accuracy { deadline, ..Accuracy::decide(limit) }).bound;
    }
    (found <= limit).then_some(found)
}

#[cfg(test)]
mod tests;
