//! MPR portal discovery: phase one of Minkowski portal refinement finds a portal.
//!
//! A portal is a triangle v1 v2 v3 of support points of the Minkowski difference that the ray from
//! the centre v0 through the origin pierces. If the origin is outside, the search may find a
//! separating plane instead.
//!
//! # Reference
//! Kenwright, Algorithm 1 lines 1 to 5 and Listing 2, phase 1; figure 8.
//!
//! # Steps
//! 1. v0 is the centre of the Minkowski difference (line 1).
//! 2. v1 is the support point towards the origin, v2 the support point perpendicular to the plane
//!    of v0, v1 and the origin, and v3 the support point perpendicular to the plane of v0, v1 and
//!    v2 (line 2).
//! 3. While the ray misses the triangle on one side, replace the vertex across that side (lines 3
//!    to 5).
//!
//! # Deviations
//! - Each support point w in a direction n with w · n < 0 ends the search, since n is a separating
//!   axis. The paper continues with phase two although the origin cannot be inside.
//! - The paper's direction for v2, v0 × v1, is zero if centre, v1 and origin are on one line (the
//!   "line case"). Then any direction perpendicular to the line serves, and any direction at all if
//!   the centre is the origin.
//! - The sides are closed half-spaces, so a ray through an edge or a vertex does not loop for ever.
//!   A limit on the steps ends what rounding error still keeps going. A portal without area, or
//!   flat against v0, is [`Discovery::Flat`].
//! - Directions are not normalised. Comparisons with a length are squared instead.

use crate::solver::minkowski::{Minkowski, Point};
use crate::support::SupportMap;
use crate::vector::{perpendicular, unit};
use glam::DVec3;

/// Maximum number of replacements. Most pairs need 2 to 3; the worst pair found needed 19.
pub(super) const MAX_DISCOVERY_STEPS: u32 = 64;

/// Minimum height of a tetrahedron relative to the outer radius, and minimum sine of the angle
/// between two edges of a portal. Below it the signs of volumes, which decide where the ray goes,
/// are rounding error.
pub(in crate::solver) const FLATNESS: f64 = 1e-11;

/// A triangle that the ray from the centre through the origin pierces.
#[derive(Clone, Copy, Debug)]
pub(in crate::solver) struct Portal {
    /// v1, v2, v3, counter-clockwise as seen from outside: (v2 − v1) × (v3 − v1) points away from
    /// v0.
    pub(in crate::solver) vertices: [Point; 3],
}

impl Portal {
    /// Initial value, before a portal is found.
    pub(in crate::solver) const EMPTY: Self = Self { vertices: [Point::EMPTY; 3] };

    /// Normal of the portal, away from v0 and not of unit length. `None` if the portal has no area.
    #[inline(always)]
    pub(in crate::solver) fn normal(&self) -> Option<DVec3> {
        let [v1, v2, v3] = self.vertices.map(|v| v.w);
        let (e2, e3) = (v2 - v1, v3 - v1);
        let n = e2.cross(e3);
        // NaN takes the failing branch.
        (n.length_squared() > FLATNESS * FLATNESS * e2.length_squared() * e3.length_squared()).then_some(n)
    }

    /// Whether the origin is certainly in the convex hull of the portal and the ball of
    /// `inner_radius` around v0: in their tetrahedron, or beside it by less than the ball makes
    /// room for.
    ///
    /// `rounding` is the error of the points. The error of a height over a face is `rounding` over
    /// the sine of the angle between two edges of the face. So volumes are compared with `rounding`
    /// times the product of the lengths of the edges.
    pub(in crate::solver) fn holds_origin(&self, v0: DVec3, inner_radius: f64, rounding: f64) -> bool {
        let [v1, v2, v3] = self.vertices.map(|v| v.w);
        let (e2, e3) = (v2 - v1, v3 - v1);
        let n = e2.cross(e3);
        let (below, height) = (n.dot(v1), n.dot(v1 - v0));
        // NaN takes the failing branch, here and below.
        let is_below = below > rounding * (e2.length_squared() * e3.length_squared()).sqrt();
        // Room that the ball leaves at the height of the origin: the whole radius at v0, none at
        // the portal.
        let room = inner_radius * (below / height).min(1.0);
        let is_within = |p: DVec3, q: DVec3| {
            let (volume, from_p, from_q) = (p.cross(q).dot(v0), p - v0, q - v0);
            let error = rounding * (from_p.length_squared() * from_q.length_squared()).sqrt();
            volume > error || (volume >= 0.0 && room * from_p.cross(from_q).length() > error)
        };
        is_below && height > 0.0 && is_within(v1, v3) && is_within(v3, v2) && is_within(v2, v1)
    }

    /// Whether the ray from `v0` pierces the portal and the normal points away from `v0`: the
    /// postcondition of portal discovery.
    #[inline]
    pub(in crate::solver) fn is_pierced(&self, v0: DVec3) -> bool {
        let [v1, v2, v3] = self.vertices.map(|v| v.w);
        v1.cross(v3).dot(v0) >= 0.0 && v3.cross(v2).dot(v0) >= 0.0 && v2.cross(v1).dot(v0) >= 0.0 && self.faces_away(v0)
    }

    /// Whether the normal points away from `v0`.
    #[inline(always)]
    pub(super) fn faces_away(&self, v0: DVec3) -> bool {
        let [v1, v2, v3] = self.vertices.map(|v| v.w);
        (v2 - v1).cross(v3 - v1).dot(v1 - v0) > 0.0
    }
}

/// Outcome of portal discovery.
#[derive(Clone, Copy, Debug)]
pub(in crate::solver) enum Discovery {
    /// A portal was found.
    Portal,
    /// The origin is outside. The separating axis points from A to B and is not of unit length.
    Separated { axis: DVec3 },
    /// The Minkowski difference, or the part seen of it, is flat. EPA has to decide.
    Flat,
    /// The step limit was reached.
    Limit,
}

/// Whether `value` < −`length` |`n`|, where `value` is a dot product with `n`. False for NaN.
#[inline]
pub(in crate::solver) fn is_clearly_negative(value: f64, n: DVec3, length: f64) -> bool {
    value < 0.0 && value * value > length * length * n.length_squared()
}

/// Portal discovery, in place. Returns the outcome and the number of steps.
///
/// If there is no portal, `portal` holds the points seen last.
#[inline(always)]
pub(in crate::solver) fn discover_portal<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    portal: &mut Portal,
) -> (Discovery, u32) {
    // Algorithm 1, line 1: v0, the centre of the Minkowski difference.
    let v0 = m.center_point().w;
    let rounding = m.rounding_error();
    let flat = FLATNESS * m.outer_radius();

    // Line 2: v1 towards the origin. If the centre is the origin, any direction serves.
    let towards = if v0.length_squared() > rounding * rounding { -v0 } else { DVec3::X };
    let mut v1 = m.point(towards);
    if is_clearly_negative(v1.w.dot(towards), towards, rounding) {
        portal.vertices = [v1; 3];
        return (Discovery::Separated { axis: towards }, 1);
    }
    // v2 perpendicular to the plane of v0, v1 and the origin; in the line case perpendicular to the
    // line.
    let line = v1.w - v0;
    let mut normal = v1.w.cross(v0);
    let spans_plane = normal.length_squared() > flat * flat * line.length_squared();
    if !spans_plane {
        let Some(line) = unit(line) else { return (Discovery::Flat, 1) };
        normal = perpendicular(line);
    }
    let mut v2 = m.point(normal);
    if is_clearly_negative(v2.w.dot(normal), normal, rounding) {
        portal.vertices = [v1, v2, v2];
        return (Discovery::Separated { axis: normal }, 1);
    }
    // v3 perpendicular to the plane of v0, v1 and v2, on the origin's side.
    let mut n = (v1.w - v0).cross(v2.w - v0);
    if n.dot(v0) > 0.0 {
        (v1, v2) = (v2, v1);
        n = -n;
    }

    // Lines 3 to 5: while the tetrahedron does not contain the origin, recalculate.
    for step in 1..=MAX_DISCOVERY_STEPS {
        if n == DVec3::ZERO {
            return (Discovery::Flat, step);
        }
        let v3 = m.point(n);
        if is_clearly_negative(v3.w.dot(n), n, rounding) {
            portal.vertices = [v1, v2, v3];
            return (Discovery::Separated { axis: n }, step);
        }
        // Listing 2: the ray is outside the plane of v0, v1, v3, so v3 replaces v2.
        if v1.w.cross(v3.w).dot(v0) < 0.0 {
            v2 = v3;
        // The ray is outside the plane of v0, v3, v2, so v3 replaces v1.
        } else if v3.w.cross(v2.w).dot(v0) < 0.0 {
            v1 = v3;
        } else {
            portal.vertices = [v1, v2, v3];
            let height = (v3.w - v0).dot(n);
            // NaN takes the failing branch.
            let high = height > 0.0 && height * height > flat * flat * n.length_squared();
            // The other two sides have passed their tests. NaN takes the failing branch.
            let pierced = v2.w.cross(v1.w).dot(v0) >= 0.0 && portal.faces_away(v0);
            let found = high && pierced && portal.normal().is_some();
            return (if found { Discovery::Portal } else { Discovery::Flat }, step);
        }
        n = (v1.w - v0).cross(v2.w - v0);
    }
    (Discovery::Limit, MAX_DISCOVERY_STEPS)
}
