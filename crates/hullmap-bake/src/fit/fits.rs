//! Proves how well parts fit their mesh: a pack's bounds on uncovered surface and protrusion.

use hullmap_format::SolidKind;
use rayon::prelude::*;

use super::{Accuracy, Solid, coverage::uncovered_until, protrusion};
use crate::{deadline::Deadline, hull::Hull};
use hullmap_geometry::PointSet;

/// Proven bounds on how a convex part fits its mesh, in the unit of the positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// How the solid of the mesh was determined.
    pub solid: SolidKind,
    /// Upper bound on how far the mesh's surface lies outside all parts; the same for each part.
    pub uncovered: f64,
    /// Upper bound on how far a point of this part lies outside the mesh's solid: see
    /// [`protrusion`](super::protrusion()).
    pub protrusion: f64,
    /// The point of the greatest protrusion found, in the frame of the positions.
    pub protrusion_at: [f64; 3],
}

/// The fit of each of `parts`, which together stand for `mesh`. `None` if the mesh has no
/// triangles, there are no parts, or a bound is not finite: then nothing is known.
///
/// If a bound on the protrusion exceeds `limit`, a further search tries to prove `limit` itself.
///
/// # Complexity
/// The cost of [`uncovered`](super::uncovered()), plus the cost of
/// [`protrusion`](super::protrusion()) for each part, on all threads of the pool.
pub fn fits(mesh: &PointSet, parts: &[&Hull], limit: Option<f64>) -> Option<Vec<Fit>> {
    if mesh.triangles.is_empty() {
        return None;
    }
    fits_around(&Solid::new(mesh), mesh, parts, limit, None)
}

/// As [`fits`], around the solid of `mesh`, which has triangles. After the deadline, bounds are not
/// improved, but hold.
pub fn fits_around(
    solid: &Solid,
    mesh: &PointSet,
    parts: &[&Hull],
    limit: Option<f64>,
    deadline: Option<Deadline>,
) -> Option<Vec<Fit>> {
    if parts.is_empty() {
        return None;
    }
    let uncovered = uncovered_until(mesh, parts, deadline).bound;
    let accuracy = Accuracy { deadline, ..Accuracy::tight(solid.diagonal()) };
    let fit = |part: &&Hull| {
        let mut found = protrusion(solid, part, &accuracy);
        // A bound may exceed a valid limit by the accuracy of the bound, and by more beside closing
        // triangles: distances are upper bounds there, and some points have better ones.
        let may_hold = |limit: &f64| found.reached <= *limit || solid.kind() == SolidKind::Closed;
        if let Some(limit) = limit.filter(|limit| found.bound > *limit).filter(may_hold) {
            let decided = protrusion(solid, part, &Accuracy { deadline, ..Accuracy::decide(limit) });
            if decided.bound <= limit {
                found = decided;
            }
        }
        // If nothing protrudes, any point of the part will do.
        let first = part.positions().first().copied().unwrap_or_default();
        let at = if found.reached > 0.0 { found.at } else { first };
        Fit { solid: solid.kind(), uncovered, protrusion: found.bound, protrusion_at: at.to_array() }
    };
    let fits: Vec<Fit> = parts.par_iter().map(fit).collect();
    let is_finite = |fit: &Fit| fit.uncovered.is_finite() && fit.protrusion.is_finite();
    fits.iter().all(is_finite).then_some(fits)
}
