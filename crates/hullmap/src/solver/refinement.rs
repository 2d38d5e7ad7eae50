//! Phase two of portal refinement: push the portal out until it lies on the surface.
//!
//! Computes whether the origin lies inside, and the portal through which the ray from the centre v0 through the origin
//! leaves the Minkowski difference.
//!
//! # Reference
//! Kenwright, Algorithm 1 lines 6 to 9 and Listing 2, phase 2; figure 9.
//!
//! # Steps
//! 1. n = the portal's normal, away from v0; origin behind it: they overlap (line 9);
//! 2. w = support along n (paper: v4); w · n < 0: a separating plane;
//! 3. w no farther out than the portal: the surface is reached (line 6);
//! 4. of the triangles w makes with the portal's sides keep the one that the ray pierces (lines 7 and 8); again.
//!
//! # Deviations
//! - The paper's absolute 0.001 becomes a share of the support value, and rounding a share of the query's size.
//! - Overlap is settled as soon as the origin is behind a portal, not after the last one: a yes/no query stops there.
//! - The support value h(n) is kept, a true upper bound of the depth along n, instead of the plane's distance n · v1, which
//!   is too small until the surface is reached. As a depth it still depends on the centre ray: the expansion improves it.
//! - The three children are told apart by three signed volumes instead of the six of Listing 2, and one of them is
//!   always chosen: the paper's "should never get here" cannot happen.
//! - The number of steps is capped; running out is a result.

use super::discovery::{Portal, is_beyond};
use super::expansion::Bound;
use crate::SupportMap;
use crate::minkowski::Minkowski;
use glam::DVec3;

/// Most portals tried. Polytopes need 2 to 20; smooth shapes touching one another halve an error each step, so 60 would use
/// up the digits.
const MAX_REFINEMENT: u32 = 100;

/// When to stop refining.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Until {
    /// As soon as it is known whether the origin is inside.
    Decided,
    /// When the portal lies on the surface, to this share of the support value: the paper's phase two to its end.
    Surface { tolerance: f64 },
}

/// What phase two found out about the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Side {
    /// Outside; [`Refinement::axis`] separates.
    Separated,
    /// Inside the tetrahedron of v0 and the portal.
    Overlapping,
    /// On the surface, within rounding.
    Touching,
    /// Not settled: cap reached or portal without area.
    Undecided,
}

/// The outcome of phase two.
#[derive(Clone, Copy, Debug)]
pub(super) struct Refinement {
    pub(super) side: Side,
    /// Normal, from A to B, of the plane that decided: separating, touching, or in front of the origin. Of any length.
    pub(super) axis: DVec3,
    pub(super) iterations: u32,
}

/// Refines `portal`, which the ray from the centre through the origin pierces, in place. With [`Until::Surface`] the least
/// support value along a portal's normal is kept in `bound`, with the portal.
#[inline]
pub(super) fn refine<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    portal: &mut Portal,
    until: Until,
    bound: &mut Bound,
) -> Refinement {
    let rounding = m.rounding();
    let v0 = m.center_point().w;
    let mut side = Side::Undecided;
    // Algorithm 1, line 6: while we can get closer.
    for iterations in 1..=MAX_REFINEMENT {
        let Some(mut n) = portal.normal() else {
            return Refinement { side, axis: DVec3::ZERO, iterations };
        };
        let [v1, v2, v3] = portal.vertices.map(|v| v.w);
        if until != Until::Decided {
            n /= n.length();
        }
        let plane = n.dot(v1);
        // Line 9: origin on the inside of the outer face.
        if is_beyond(-plane, n, rounding) {
            side = Side::Overlapping;
            if until == Until::Decided {
                return Refinement { side, axis: n, iterations };
            }
        }
        let v4 = m.point(n);
        let value = v4.w.dot(n);
        if is_beyond(value, n, rounding) {
            // What was seen last is nearest to the origin.
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
        // NaN counts as the surface: there is nothing farther out to go to.
        let farther = is_beyond(plane - value + enough, n, rounding);
        if !farther {
            if side == Side::Undecided && !is_beyond(-value.abs(), n, 2.0 * rounding) {
                side = Side::Touching;
            }
            return Refinement { side, axis: n, iterations };
        }
        // Lines 7 and 8, Listing 2: v4 replaces the vertex across the side that the ray is on.
        let beside = v4.w.cross(v0);
        if v1.dot(beside) >= 0.0 {
            if v2.dot(beside) >= 0.0 {
                portal.vertices[0] = v4;
            } else {
                portal.vertices[2] = v4;
            }
        } else if v3.dot(beside) >= 0.0 {
            portal.vertices[1] = v4;
        } else {
            portal.vertices[0] = v4;
        }
    }
    Refinement { side, axis: DVec3::ZERO, iterations: MAX_REFINEMENT }
}
