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
//! - A cached portal (section 4.7) is tried first: three support calls, and if the ray pierces it phase one is over.

use crate::SupportMap;
use crate::minkowski::{Minkowski, Vertex, perpendicular, unit};
use glam::DVec3;

/// Most replacements of v3. Well-behaved pairs need 2 to 3, the worst seen 19.
const MAX_DISCOVERY: u32 = 64;

/// Heights of a tetrahedron below this share of the outer radius are none: the signs of volumes that decide where the
/// ray goes would be rounding.
pub(super) const FLAT: f64 = 1e-11;

/// A triangle that the ray from the centre through the origin pierces, with the centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portal {
    /// The centre v0.
    pub(super) center: Vertex,
    /// v1, v2, v3, counter-clockwise as seen from outside: (v2 − v1) × (v3 − v1) points away from v0.
    pub(super) vertices: [Vertex; 3],
}

impl Portal {
    /// The portal's normal, away from v0, of unit length; nothing when the portal has no area.
    pub(super) fn normal(&self) -> Option<DVec3> {
        let [v1, v2, v3] = self.vertices.map(|v| v.w);
        let (e2, e3) = (v2 - v1, v3 - v1);
        let n = e2.cross(e3);
        // NaN takes the failing branch.
        (n.length_squared() > FLAT * FLAT * e2.length_squared() * e3.length_squared()).then(|| unit(n)).flatten()
    }

    /// Distance of the origin from the nearest of the three planes through v0 and a side; negative outside.
    ///
    /// Where the centre is well inside the difference this does not matter, but a centre on the surface has surface points in
    /// these planes.
    pub(super) fn clearance(&self) -> f64 {
        let v0 = self.center.w;
        let [v1, v2, v3] = self.vertices.map(|v| v.w);
        let side = |p: DVec3, q: DVec3| p.cross(q).dot(v0) / (p - v0).cross(q - v0).length();
        side(v1, v3).min(side(v3, v2)).min(side(v2, v1))
    }

    /// Whether the ray pierces the portal and the normal points away from v0: all that phase one promises.
    pub(super) fn is_pierced(&self) -> bool {
        let v0 = self.center.w;
        let [v1, v2, v3] = self.vertices.map(|v| v.w);
        v1.cross(v3).dot(v0) >= 0.0
            && v3.cross(v2).dot(v0) >= 0.0
            && v2.cross(v1).dot(v0) >= 0.0
            && (v2 - v1).cross(v3 - v1).dot(v1 - v0) > 0.0
    }
}

/// Why phase one found no portal.
#[derive(Clone, Copy, Debug)]
pub(super) enum NoPortal {
    /// The origin is outside: a separating axis of unit length, from A to B.
    Separated { axis: DVec3 },
    /// The difference, or what was seen of it, is flat; somebody else must decide.
    Flat,
    /// The cap was reached.
    Limit,
}

/// Finds a portal. `warm` are directions whose support points may still be one. Returns the number of steps too.
pub(super) fn discover<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    warm: Option<[DVec3; 3]>,
) -> (Result<Portal, NoPortal>, u32) {
    let mut steps = 0;
    let found = match warm.map(|dirs| try_warm(m, dirs)) {
        Some(Ok(Some(portal))) => Ok(portal),
        Some(Err(none)) => Err(none),
        Some(Ok(None)) | None => discover_cold(m, &mut steps),
    };
    (found, steps.max(1))
}

/// Builds the portal of old directions under the new pose; nothing when the ray misses it.
fn try_warm<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    dirs: [DVec3; 3],
) -> Result<Option<Portal>, NoPortal> {
    let mut vertices = [Vertex::EMPTY; 3];
    for (vertex, dir) in vertices.iter_mut().zip(dirs) {
        *vertex = probe(m, dir)?;
    }
    let portal = Portal { center: m.center(), vertices };
    Ok((portal.is_pierced() && portal.normal().is_some()).then_some(portal))
}

/// The support point in the unit direction `n`, or the separating axis that `n` is then.
fn probe<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    n: DVec3,
) -> Result<Vertex, NoPortal> {
    let v = m.support(n);
    if v.w.dot(n) < -m.rounding() { Err(NoPortal::Separated { axis: n }) } else { Ok(v) }
}

fn discover_cold<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    steps: &mut u32,
) -> Result<Portal, NoPortal> {
    // Algorithm 1, line 1: v0, the centre of the Minkowski difference.
    let center = m.center();
    let v0 = center.w;
    let flat = FLAT * m.outer_radius();

    // Line 2: v1 towards the origin. Coincident centres: any direction is towards it.
    let towards = if v0.length() > m.rounding() { unit(-v0).unwrap_or(DVec3::X) } else { DVec3::X };
    let mut v1 = probe(m, towards)?;
    // v2 beside the line from v0 through the origin; in the line case beside the line from v0 through v1.
    let line = unit(v1.w - v0).ok_or(NoPortal::Flat)?;
    let beside = v1.w.cross(v0);
    let beside = if beside.length() > flat * (v1.w - v0).length() {
        unit(beside).unwrap_or_else(|| perpendicular(line))
    } else {
        perpendicular(line)
    };
    let mut v2 = probe(m, beside)?;
    // v3 beside the plane of v0, v1, v2, on the origin's side.
    let mut n = (v1.w - v0).cross(v2.w - v0);
    if n.dot(v0) > 0.0 {
        (v1, v2) = (v2, v1);
        n = -n;
    }

    // Lines 3 to 5: while the tetrahedron does not contain the origin, recalculate.
    for _ in 0..MAX_DISCOVERY {
        *steps += 1;
        let dir = unit(n).ok_or(NoPortal::Flat)?;
        let v3 = probe(m, dir)?;
        // Listing 2: the ray passes outside the plane of v0, v1, v3: v3 takes v2's place.
        if v1.w.cross(v3.w).dot(v0) < 0.0 {
            v2 = v3;
        // Outside the plane of v0, v3, v2: v3 takes v1's place.
        } else if v3.w.cross(v2.w).dot(v0) < 0.0 {
            v1 = v3;
        } else {
            let portal = Portal { center, vertices: [v1, v2, v3] };
            // NaN takes the failing branch.
            return if (v3.w - v0).dot(dir) > flat && portal.is_pierced() && portal.normal().is_some() {
                Ok(portal)
            } else {
                Err(NoPortal::Flat)
            };
        }
        n = (v1.w - v0).cross(v2.w - v0);
    }
    Err(NoPortal::Limit)
}
