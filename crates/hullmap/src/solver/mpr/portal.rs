//! The portal of MPR: a triangle v1 v2 v3 of support points of the Minkowski difference that the
//! ray from the centre v0 through the origin pierces.

use glam::DVec3;

use crate::solver::minkowski::Point;

/// Minimum height of a tetrahedron relative to the outer radius, and minimum sine of the angle
/// between two edges of a portal. Below it the signs of volumes, which decide where the ray goes,
/// are rounding error.
pub(super) const FLATNESS: f64 = 1e-11;

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
    /// `inner_radius` around v0: in their tetrahedron, or beside it by less than the room that the
    /// ball leaves.
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
    pub(in crate::solver) fn faces_away(&self, v0: DVec3) -> bool {
        let [v1, v2, v3] = self.vertices.map(|v| v.w);
        (v2 - v1).cross(v3 - v1).dot(v1 - v0) > 0.0
    }
}

/// Whether `value` < −`length` |`n`|, where `value` is a dot product with `n`. False for NaN.
#[inline(always)]
pub(in crate::solver) fn is_clearly_negative(value: f64, n: DVec3, length: f64) -> bool {
    value < 0.0 && value * value > length * length * n.length_squared()
}
