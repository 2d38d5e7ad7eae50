//! MPR, Minkowski portal refinement (XenoCollide): does the Minkowski difference contain the
//! origin, and through which portal does the ray from the centre v0 through the origin leave it?
//!
//! # Reference
//! Kenwright, Algorithm 1 lines 1 to 9 and Listing 2; figures 8 and 9.
//!
//! # Steps
//! Portal discovery finds a triangle that the ray pierces:
//! 1. v0 is the centre of the Minkowski difference (line 1).
//! 2. v1 is the support point towards the origin, v2 the support point perpendicular to the plane
//!    of v0, v1 and the origin, and v3 the support point perpendicular to the plane of v0, v1 and
//!    v2 (line 2).
//! 3. While the ray misses the triangle on one side, replace the vertex across that side (lines 3
//!    to 5).
//!
//! Portal refinement moves the portal outward to the surface:
//! 4. n is the normal of the portal, away from v0. If the origin is behind the portal, the shapes
//!    overlap (line 9).
//! 5. v4 is the support point along n. If it is no farther out than the portal, the portal is on
//!    the surface (line 6).
//! 6. Keep the one of the three triangles of v4 and a side of the portal that the ray pierces
//!    (lines 7 and 8), and continue with step 4.
//!
//! # Deviations
//! - A support point w in a direction n with w · n < 0 ends the search at once, since n separates.
//! - The paper's direction for v2, v0 × v1, is zero if centre, v1 and origin are on one line. Then
//!   any direction perpendicular to the line serves, and any at all if the centre is the origin.
//! - The sides are closed half-spaces, so a ray through an edge or a vertex does not loop for ever.
//!   Reaching a limit on the steps is an outcome. A portal without area, or flat against v0, does
//!   not count as one.
//! - The paper's absolute tolerance 0.001 is relative to the support value here, and rounding error
//!   is relative to the size of the query.
//! - Overlap is decided as soon as the origin is behind a portal and not at the last one.
//! - The support value h(n) is kept, a true upper bound of the depth along n. The paper's n · v1 is
//!   too small until the surface is reached.
//! - Three signed volumes select one of the three triangles in step 6, instead of the six in
//!   Listing 2, and one is always selected.

use glam::DVec3;

use super::bound::Bound;
use super::minkowski::{Minkowski, Point};
use crate::support::SupportMap;
use crate::vector::{perpendicular, unit};

/// Maximum number of replacements in portal discovery. Most pairs need 2 to 3; the worst pair found
/// needed 19.
const MAX_DISCOVERY_STEPS: u32 = 64;

/// Maximum number of portals. Polytopes need 2 to 20. Smooth shapes that touch halve their error in
/// each step, so 60 steps would exhaust the digits of an f64.
const MAX_REFINEMENT_STEPS: u32 = 100;

/// Minimum height of a tetrahedron relative to the outer radius, and minimum sine of the angle
/// between two edges of a portal. Below it the signs of volumes, which decide where the ray goes,
/// are rounding error.
const FLATNESS: f64 = 1e-11;

/// A triangle that the ray from the centre v0 through the origin pierces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portal {
    /// Counter-clockwise as seen from outside: (v2 − v1) × (v3 − v1) points away from v0.
    pub(super) vertices: [Point; 3],
}

impl Portal {
    /// The portal of these features under this pose, without a support query.
    #[inline(always)]
    pub(super) fn recall<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        [v1, v2, v3]: [[u32; 2]; 3],
    ) -> Option<Self> {
        Some(Self { vertices: [m.recall(v1)?, m.recall(v2)?, m.recall(v3)?] })
    }

    /// Normal of the portal, away from v0 and not of unit length. `None` if the portal has no area.
    #[inline(always)]
    pub(super) fn normal(&self) -> Option<DVec3> {
        let [v1, v2, v3] = self.vertices.map(|v| v.w);
        let (e2, e3) = (v2 - v1, v3 - v1);
        let n = e2.cross(e3);
        // NaN takes the failing branch.
        (n.length_squared() > FLATNESS * FLATNESS * e2.length_squared() * e3.length_squared()).then_some(n)
    }

    pub(super) fn tetrahedron<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &self,
        m: &Minkowski<'_, A, B>,
    ) -> [Point; 4] {
        let [v1, v2, v3] = self.vertices;
        [m.center_point(), v1, v2, v3]
    }

    /// Whether the origin is certainly in the convex hull of the portal and the ball of
    /// `inner_radius` around v0: in their tetrahedron, or beside it by less than the room that the
    /// ball leaves.
    ///
    /// `rounding` is the error of the points. The error of a height over a face is that over the
    /// sine of the angle between two edges of the face.
    pub(super) fn holds_origin(&self, v0: DVec3, inner_radius: f64, rounding: f64) -> bool {
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

    /// Whether portal discovery could end here: the ray from `v0` pierces the portal, which faces
    /// away.
    #[inline]
    pub(super) fn is_pierced(&self, v0: DVec3) -> bool {
        let [v1, v2, v3] = self.vertices.map(|v| v.w);
        v1.cross(v3).dot(v0) >= 0.0 && v3.cross(v2).dot(v0) >= 0.0 && v2.cross(v1).dot(v0) >= 0.0 && self.faces_away(v0)
    }

    #[inline(always)]
    pub(super) fn faces_away(&self, v0: DVec3) -> bool {
        let [v1, v2, v3] = self.vertices.map(|v| v.w);
        (v2 - v1).cross(v3 - v1).dot(v1 - v0) > 0.0
    }
}

/// Whether `value` < −`length` |`n`|, where `value` is a dot product with `n`. False for NaN.
#[inline(always)]
pub(super) fn is_clearly_negative(value: f64, n: DVec3, length: f64) -> bool {
    value < 0.0 && value * value > length * length * n.length_squared()
}

/// When to stop refining.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Until {
    /// As soon as it is known whether the origin is inside.
    Decided,
    /// When the portal is on the surface, within `tolerance` relative to the support value: the
    /// paper's phase two.
    Surface { tolerance: f64 },
}

/// Outcome of a search. Its points are the portal, or the last points queried.
#[derive(Clone, Copy, Debug)]
pub(super) enum Found {
    /// A separating axis, from A to B and not of unit length.
    Separated { axis: DVec3 },
    /// A portal, and whether the origin is behind it for certain.
    Portal { is_behind: bool },
    /// No portal: the difference is flat, or the limit on the steps was reached.
    Nothing,
}

/// Which vertex the next support point is.
#[derive(Clone, Copy, Debug)]
enum Phase {
    First,
    Second,
    /// In this step of portal discovery.
    Third {
        step: u32,
    },
    /// In this step of portal refinement.
    Fourth {
        step: u32,
    },
}

/// A search that waits for a support point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MprSearch {
    v0: DVec3,
    rounding: f64,
    /// Lengths below this are rounding error of a tetrahedron's height.
    flat: f64,
    portal: Portal,
    dir: DVec3,
    phase: Phase,
    discovery_steps: u32,
    until: Until,
    is_behind: bool,
    /// With [`Until::Surface`]: the minimum support value along the normal of a portal.
    bound: Option<Bound>,
}

impl MprSearch {
    #[inline(always)]
    pub(super) fn new<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(m: &Minkowski<'_, A, B>, until: Until) -> Self {
        let v0 = m.center_point().w;
        let rounding = m.rounding_error();
        Self {
            v0,
            rounding,
            flat: FLATNESS * m.outer_radius(),
            portal: Portal { vertices: [Point::EMPTY; 3] },
            dir: if v0.length_squared() > rounding * rounding { -v0 } else { DVec3::X },
            phase: Phase::First,
            discovery_steps: 0,
            until,
            is_behind: false,
            bound: None,
        }
    }

    pub(super) fn portal(&self) -> &Portal {
        &self.portal
    }

    /// The upper bound of the depth that [`Until::Surface`] finds; infinite otherwise.
    pub(super) fn bound(&self) -> Bound {
        self.bound.unwrap_or(Bound::none())
    }

    #[inline(always)]
    pub(super) fn direction(&self) -> DVec3 {
        self.dir
    }

    pub(super) fn iterations(&self) -> u32 {
        match self.phase {
            Phase::First | Phase::Second => 1,
            Phase::Third { step } => step,
            Phase::Fourth { step } => self.discovery_steps + step,
        }
    }

    /// Continues with the support point `w` in the last direction. `None` if another one is needed.
    #[inline(always)]
    pub(super) fn continue_with(&mut self, w: Point) -> Option<Found> {
        let n = self.dir;
        if is_clearly_negative(w.w.dot(n), n, self.rounding) {
            let [v1, v2, v3] = self.portal.vertices;
            self.portal.vertices = match self.phase {
                Phase::First => [w; 3],
                Phase::Second => [v1, w, w],
                Phase::Third { .. } => [v1, v2, w],
                Phase::Fourth { .. } => [w, v2, v3],
            };
            return Some(Found::Separated { axis: n });
        }
        match self.phase {
            // v2 is perpendicular to the plane of v0, v1 and the origin, or to their line.
            Phase::First => {
                let line = w.w - self.v0;
                (self.portal.vertices[0], self.phase, self.dir) = (w, Phase::Second, w.w.cross(self.v0));
                let spans_plane = self.dir.length_squared() > self.flat * self.flat * line.length_squared();
                if !spans_plane {
                    let Some(line) = unit(line) else { return Some(Found::Nothing) };
                    self.dir = perpendicular(line);
                }
                None
            }
            // v3 is perpendicular to the plane of v0, v1 and v2, on the origin's side.
            Phase::Second => {
                let v1 = self.portal.vertices[0];
                let n = (v1.w - self.v0).cross(w.w - self.v0);
                (self.portal.vertices[0], self.portal.vertices[1], self.dir) =
                    if n.dot(self.v0) > 0.0 { (w, v1, -n) } else { (v1, w, n) };
                self.phase = Phase::Third { step: 1 };
                (self.dir == DVec3::ZERO).then_some(Found::Nothing)
            }
            Phase::Third { step } => self.discover(w, step),
            Phase::Fourth { step } => self.refine(w, step),
        }
    }

    /// Step 3: while the tetrahedron does not contain the origin, replaces a vertex.
    #[inline(always)]
    fn discover(&mut self, v3: Point, step: u32) -> Option<Found> {
        let (v0, n) = (self.v0, self.dir);
        let [v1, v2, _] = self.portal.vertices;
        // Listing 2: the ray is outside the plane of v0, v1, v3, so v3 replaces v2.
        if v1.w.cross(v3.w).dot(v0) < 0.0 {
            self.portal.vertices[1] = v3;
        // The ray is outside the plane of v0, v3, v2, so v3 replaces v1.
        } else if v3.w.cross(v2.w).dot(v0) < 0.0 {
            self.portal.vertices[0] = v3;
        } else {
            self.portal.vertices[2] = v3;
            let portal = &self.portal;
            let height = (v3.w - v0).dot(n);
            // NaN takes the failing branch.
            let high = height > 0.0 && height * height > self.flat * self.flat * n.length_squared();
            // The other two sides have passed their tests. NaN takes the failing branch.
            let pierced = v2.w.cross(v1.w).dot(v0) >= 0.0 && portal.faces_away(v0);
            if !(high && pierced && portal.normal().is_some()) {
                return Some(Found::Nothing);
            }
            self.discovery_steps = step;
            return self.aim_outward(1);
        }
        if step == MAX_DISCOVERY_STEPS {
            return Some(Found::Nothing);
        }
        let [v1, v2, _] = self.portal.vertices;
        self.dir = (v1.w - v0).cross(v2.w - v0);
        self.phase = Phase::Third { step: step + 1 };
        (self.dir == DVec3::ZERO).then_some(Found::Nothing)
    }

    /// Step 4: aims along the normal of the portal, unless the origin is known to be behind it.
    #[inline(always)]
    fn aim_outward(&mut self, step: u32) -> Option<Found> {
        self.phase = Phase::Fourth { step };
        let Some(mut n) = self.portal.normal() else { return Some(Found::Portal { is_behind: self.is_behind }) };
        if self.until != Until::Decided {
            n /= n.length();
        }
        self.dir = n;
        if is_clearly_negative(-n.dot(self.portal.vertices[0].w), n, self.rounding) {
            self.is_behind = true;
            if self.until == Until::Decided {
                return Some(Found::Portal { is_behind: self.is_behind });
            }
        }
        None
    }

    /// Steps 5 and 6.
    #[inline(always)]
    fn refine(&mut self, v4: Point, step: u32) -> Option<Found> {
        let n = self.dir;
        let [v1, v2, v3] = self.portal.vertices.map(|v| v.w);
        let value = v4.w.dot(n);
        let mut enough = 0.0;
        if let Until::Surface { tolerance } = self.until {
            if value < self.bound().upper {
                self.bound = Some(Bound::on_face(value, n, self.portal.vertices.each_ref()));
            }
            enough = tolerance * value;
        }
        // NaN counts as the surface, since no point is known to be farther out.
        if !is_clearly_negative(n.dot(v1) - value + enough, n, self.rounding) {
            return Some(Found::Portal { is_behind: self.is_behind });
        }
        // Listing 2: v4 replaces one vertex, so that the ray pierces the new portal.
        let ray_normal = v4.w.cross(self.v0);
        let [p1, p2, p3] = &mut self.portal.vertices;
        match (v1.dot(ray_normal) >= 0.0, v2.dot(ray_normal) >= 0.0, v3.dot(ray_normal) >= 0.0) {
            (true, true, _) | (false, _, false) => *p1 = v4,
            (true, false, _) => *p3 = v4,
            (false, _, true) => *p2 = v4,
        }
        if step == MAX_REFINEMENT_STEPS {
            return Some(Found::Portal { is_behind: self.is_behind });
        }
        self.aim_outward(step + 1)
    }
}
