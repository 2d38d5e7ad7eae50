//! MPR portal refinement: phase two of Minkowski portal refinement moves the portal to the surface.
//!
//! It decides whether the origin is inside the Minkowski difference, and finds the portal through
//! which the ray from the centre v0 through the origin leaves it.
//!
//! # Reference
//! Kenwright, Algorithm 1 lines 6 to 9 and Listing 2, phase 2; figure 9.
//!
//! # Steps
//! 1. n is the normal of the portal, away from v0. If the origin is behind the portal, the shapes
//!    overlap (line 9).
//! 2. w is the support point along n (v4 in the paper). If w · n < 0, n is a separating axis.
//! 3. If w is no farther out than the portal, the portal is on the surface (line 6).
//! 4. Of the three triangles of w and a side of the portal keep the one that the ray pierces (lines
//!    7 and 8), and continue with step 1.
//!
//! # Deviations
//! - The paper's absolute tolerance 0.001 is relative to the support value here, and rounding error
//!   is relative to the size of the query.
//! - Overlap is decided as soon as the origin is behind a portal and not at the last one. An
//!   intersection test ends there.
//! - The support value h(n) is kept, which is a true upper bound of the depth along n. The paper's
//!   n · v1 is too small until the surface is reached. As a depth, h(n) still depends on the centre
//!   ray; EPA improves it.
//! - Three signed volumes select one of the three triangles, instead of the six in Listing 2, and
//!   one is always selected. The paper's "should never get here" cannot happen.
//! - The number of steps is limited, and reaching the limit is an outcome.

use super::discovery::{Portal, is_clearly_negative};
use crate::solver::bound::Bound;
use crate::solver::minkowski::Minkowski;
use crate::support::SupportMap;
use glam::DVec3;

/// Maximum number of portals. Polytopes need 2 to 20. Smooth shapes that touch halve their error in
/// each step, so 60 steps would exhaust the digits of an f64.
pub(super) const MAX_REFINEMENT_STEPS: u32 = 100;

/// When to stop refining.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::solver) enum Until {
    /// As soon as it is known whether the origin is inside.
    Decided,
    /// When the portal is on the surface, within `tolerance` relative to the support value: the
    /// paper's phase two.
    Surface { tolerance: f64 },
}

/// Position of the origin, as far as portal refinement found it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::solver) enum Side {
    /// Outside; [`Refinement::axis`] separates.
    Separated,
    /// Inside the tetrahedron of v0 and the portal.
    Overlapping,
    /// On the surface, within rounding error.
    Touching,
    /// Not known: the step limit was reached, or the portal has no area.
    Undecided,
}

/// Outcome of portal refinement.
#[derive(Clone, Copy, Debug)]
pub(in crate::solver) struct Refinement {
    pub(in crate::solver) side: Side,
    /// Normal, from A to B, of the plane that decided: separating, touching, or in front of the
    /// origin. It is not of unit length.
    pub(in crate::solver) axis: DVec3,
    pub(in crate::solver) iterations: u32,
}

/// Portal refinement, in place. The ray from the centre through the origin must pierce `portal`.
///
/// With [`Until::Surface`], `bound` receives the minimum support value along the normal of a
/// portal.
#[inline(always)]
pub(in crate::solver) fn refine_portal<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    portal: &mut Portal,
    until: Until,
    bound: &mut Bound,
) -> Refinement {
    let rounding = m.rounding_error();
    let v0 = m.center_point().w;
    let mut side = Side::Undecided;
    // Algorithm 1, line 6: while we can get closer.
    for iterations in 1..=MAX_REFINEMENT_STEPS {
        let Some(mut n) = portal.normal() else {
            return Refinement { side, axis: DVec3::ZERO, iterations };
        };
        let [v1, v2, v3] = portal.vertices.map(|v| v.w);
        if until != Until::Decided {
            n /= n.length();
        }
        let plane = n.dot(v1);
        // Line 9: the origin is behind the portal.
        if is_clearly_negative(-plane, n, rounding) {
            side = Side::Overlapping;
            if until == Until::Decided {
                return Refinement { side, axis: n, iterations };
            }
        }
        let v4 = m.point(n);
        let value = v4.w.dot(n);
        if is_clearly_negative(value, n, rounding) {
            // The point seen last is the closest to the origin.
            portal.vertices[0] = v4;
            return Refinement { side: Side::Separated, axis: n, iterations };
        }
        let enough = match until {
            Until::Decided => 0.0,
            Until::Surface { tolerance } => {
                if value < bound.upper {
                    *bound = Bound::at(value, n, portal.vertices.each_ref());
                }
                tolerance * value
            }
        };
        // NaN counts as the surface, since no point is known to be farther out.
        let farther = is_clearly_negative(plane - value + enough, n, rounding);
        if !farther {
            if side == Side::Undecided && !is_clearly_negative(-value.abs(), n, 2.0 * rounding) {
                side = Side::Touching;
            }
            return Refinement { side, axis: n, iterations };
        }
        // Lines 7 and 8, Listing 2: v4 replaces one vertex, so that the ray pierces the new portal.
        let ray_normal = v4.w.cross(v0);
        if v1.dot(ray_normal) >= 0.0 {
            if v2.dot(ray_normal) >= 0.0 {
                portal.vertices[0] = v4;
            } else {
                portal.vertices[2] = v4;
            }
        } else if v3.dot(ray_normal) >= 0.0 {
            portal.vertices[1] = v4;
        } else {
            portal.vertices[0] = v4;
        }
    }
    Refinement { side, axis: DVec3::ZERO, iterations: MAX_REFINEMENT_STEPS }
}
