//! Phase one of portal refinement: find a portal.
//!
//! A portal is a triangle v1 v2 v3 of support points of the Minkowski difference such that the ray from the centre v0
//! through the origin pierces it. If there is none because the origin lies outside, a separating plane shows up.
//!
//! # Reference
//! Kenwright, Algorithm 1 lines 1 to 5 and Listing 2, phase 1; figure 8.
//!
//! # Steps
//! 1. v0 = centre of the Minkowski difference (line 1);
//! 2. v1 = support towards the origin, v2 = support beside the plane of v0, v1 and origin, v3 = support beside the plane of
//!    v0, v1, v2 (line 2);
//! 3. while the ray misses the triangle, replace the vertex across the side it passes (lines 3 to 5).
//!
//! # Deviations
//! - Each support point w of a direction n with w · n < 0 ends the search: n is a separating axis. The paper goes
//!   on to phase two with an origin that cannot be inside.
//! - The paper's v2 is sought with v0 × v1 of absolute size; where centre, v1 and origin lie on one line (the "line
//!   case") it is zero. Then any direction beside the line does, and where the centre is the origin, any at all.
//! - The sides are tested with closed half-spaces, so that a ray through an edge or a vertex is no endless loop; a cap ends
//!   what rounding still keeps going. A portal without area, or flat against v0, is [`NoPortal::Flat`].
//! - Directions are not brought to unit length; what is compared with a length is squared instead.

use crate::SupportMap;
use crate::minkowski::{Minkowski, Point, perpendicular, unit};
use glam::DVec3;

/// Most replacements of v3. Well-behaved pairs need 2 to 3, the worst seen 19.
const MAX_DISCOVERY: u32 = 64;

/// Heights of a tetrahedron below this share of the outer radius are none: the signs of volumes that decide where the
/// ray goes would be rounding.
pub(super) const FLAT: f64 = 1e-11;

/// A triangle that the ray from the centre through the origin pierces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portal {
    /// v1, v2, v3, counter-clockwise as seen from outside: (v2 − v1) × (v3 − v1) points away from v0.
    pub(super) vertices: [Point; 3],
}

impl Portal {
    /// What there is before one is found.
    pub(super) const NONE: Self = Self { vertices: [Point::EMPTY; 3] };

    /// The portal's normal, away from v0, of any length; nothing when the portal has no area.
    #[inline]
    pub(super) fn normal(&self) -> Option<DVec3> {
        let [v1, v2, v3] = self.vertices.map(|v| v.w);
        let (e2, e3) = (v2 - v1, v3 - v1);
        let n = e2.cross(e3);
        // NaN takes the failing branch.
        (n.length_squared() > FLAT * FLAT * e2.length_squared() * e3.length_squared()).then_some(n)
    }

    /// Whether the origin is for certain in the tetrahedron of v0 and the portal, or beside it by less than a ball of `inner_radius` around
    /// v0 makes room for: in a convex set that holds ball and portal. `rounding` is what points may be off by.
    ///
    /// An offset from the plane of a face is uncertain by `rounding` over the sine of the angle between two of the face's edges. So
    /// what is compared is volumes, with `rounding` times the product of the edges' lengths.
    pub(super) fn holds_origin(&self, v0: DVec3, inner_radius: f64, rounding: f64) -> bool {
        let [v1, v2, v3] = self.vertices.map(|v| v.w);
        let (e2, e3) = (v2 - v1, v3 - v1);
        let n = e2.cross(e3);
        let (below, height) = (n.dot(v1), n.dot(v1 - v0));
        // NaN takes the failing branch, here and below.
        let is_below = below > rounding * (e2.length_squared() * e3.length_squared()).sqrt();
        // The ball's share where the origin is: all of it at v0, none at the portal.
        let room = inner_radius * (below / height).min(1.0);
        let is_within = |p: DVec3, q: DVec3| {
            let (volume, from_p, from_q) = (p.cross(q).dot(v0), p - v0, q - v0);
            let uncertain = rounding * (from_p.length_squared() * from_q.length_squared()).sqrt();
            volume > uncertain || (volume >= 0.0 && room * from_p.cross(from_q).length() > uncertain)
        };
        is_below && height > 0.0 && is_within(v1, v3) && is_within(v3, v2) && is_within(v2, v1)
    }

    /// Whether the ray from `v0` pierces the portal and the normal points away from it: all that phase one promises.
    #[inline]
    pub(super) fn is_pierced(&self, v0: DVec3) -> bool {
        let [v1, v2, v3] = self.vertices.map(|v| v.w);
        v1.cross(v3).dot(v0) >= 0.0 && v3.cross(v2).dot(v0) >= 0.0 && v2.cross(v1).dot(v0) >= 0.0 && self.faces_away(v0)
    }

    /// Whether the normal points away from `v0`.
    #[inline(always)]
    fn faces_away(&self, v0: DVec3) -> bool {
        let [v1, v2, v3] = self.vertices.map(|v| v.w);
        (v2 - v1).cross(v3 - v1).dot(v1 - v0) > 0.0
    }
}

/// How phase one ended.
#[derive(Clone, Copy, Debug)]
pub(super) enum Discovery {
    /// With a portal.
    Portal,
    /// The origin is outside: a separating axis, from A to B, of any length.
    Separated { axis: DVec3 },
    /// The difference, or what was seen of it, is flat; somebody else must decide.
    Flat,
    /// The cap was reached.
    Limit,
}

/// Whether `value` is less than −`length` |`n`|; false for NaN.
#[inline]
pub(super) fn is_beyond(value: f64, n: DVec3, length: f64) -> bool {
    value < 0.0 && value * value > length * length * n.length_squared()
}

/// Finds a portal, in place. If there is none, the points seen last are left there. Returns the number of steps too.
#[inline]
pub(super) fn discover<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    portal: &mut Portal,
) -> (Discovery, u32) {
    // Algorithm 1, line 1: v0, the centre of the Minkowski difference.
    let v0 = m.center_point().w;
    let rounding = m.rounding();
    let flat = FLAT * m.outer_radius();

    // Line 2: v1 towards the origin. Coincident centres: any direction is towards it.
    let towards = if v0.length_squared() > rounding * rounding { -v0 } else { DVec3::X };
    let mut v1 = m.point(towards);
    if is_beyond(v1.w.dot(towards), towards, rounding) {
        portal.vertices = [v1; 3];
        return (Discovery::Separated { axis: towards }, 1);
    }
    // v2 beside the line from v0 through the origin; in the line case beside the line from v0 through v1.
    let line = v1.w - v0;
    let mut beside = v1.w.cross(v0);
    let aside = beside.length_squared() > flat * flat * line.length_squared();
    if !aside {
        let Some(line) = unit(line) else { return (Discovery::Flat, 1) };
        beside = perpendicular(line);
    }
    let mut v2 = m.point(beside);
    if is_beyond(v2.w.dot(beside), beside, rounding) {
        portal.vertices = [v1, v2, v2];
        return (Discovery::Separated { axis: beside }, 1);
    }
    // v3 beside the plane of v0, v1, v2, on the origin's side.
    let mut n = (v1.w - v0).cross(v2.w - v0);
    if n.dot(v0) > 0.0 {
        (v1, v2) = (v2, v1);
        n = -n;
    }

    // Lines 3 to 5: while the tetrahedron does not contain the origin, recalculate.
    for step in 1..=MAX_DISCOVERY {
        if n == DVec3::ZERO {
            return (Discovery::Flat, step);
        }
        let v3 = m.point(n);
        if is_beyond(v3.w.dot(n), n, rounding) {
            portal.vertices = [v1, v2, v3];
            return (Discovery::Separated { axis: n }, step);
        }
        // Listing 2: the ray passes outside the plane of v0, v1, v3: v3 takes v2's place.
        if v1.w.cross(v3.w).dot(v0) < 0.0 {
            v2 = v3;
        // Outside the plane of v0, v3, v2: v3 takes v1's place.
        } else if v3.w.cross(v2.w).dot(v0) < 0.0 {
            v1 = v3;
        } else {
            portal.vertices = [v1, v2, v3];
            let height = (v3.w - v0).dot(n);
            // NaN takes the failing branch.
            let high = height > 0.0 && height * height > flat * flat * n.length_squared();
            // The other two sides were tested just now. NaN takes the failing branch here.
            let pierced = v2.w.cross(v1.w).dot(v0) >= 0.0 && portal.faces_away(v0);
            let found = high && pierced && portal.normal().is_some();
            return (if found { Discovery::Portal } else { Discovery::Flat }, step);
        }
        n = (v1.w - v0).cross(v2.w - v0);
    }
    (Discovery::Limit, MAX_DISCOVERY)
}
