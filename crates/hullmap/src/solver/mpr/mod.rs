//! MPR, Minkowski portal refinement (XenoCollide): does the Minkowski difference contain the
//! origin, and through which portal does the ray from the centre v0 through the origin leave it?
//!
//! # Reference
//! Kenwright, Algorithm 1 lines 1 to 9 and Listing 2; figures 8 and 9.
//!
//! # Steps
//! Phase one, portal discovery, finds a [`portal`]:
//! 1. v0 is the centre of the Minkowski difference (line 1).
//! 2. v1 is the support point towards the origin, v2 the support point perpendicular to the plane
//!    of v0, v1 and the origin, and v3 the support point perpendicular to the plane of v0, v1 and
//!    v2 (line 2).
//! 3. While the ray misses the triangle on one side, replace the vertex across that side (lines 3
//!    to 5).
//!
//! Phase two, portal refinement, moves the portal outward to the surface:
//! 4. n is the normal of the portal, away from v0. If the origin is behind the portal, the shapes
//!    overlap (line 9).
//! 5. v4 is the support point along n. If it is no farther out than the portal, the portal is on
//!    the surface (line 6).
//! 6. Of the three triangles of v4 and a side of the portal keep the one that the ray pierces
//!    (lines 7 and 8), and continue with step 4.
//!
//! # Deviations
//! - Each support point w in a direction n with w · n < 0 ends the search, since n is a separating
//!   axis. The paper continues with phase two although the origin cannot be inside.
//! - The paper's direction for v2, v0 × v1, is zero if centre, v1 and origin are on one line (the
//!   "line case"). Then any direction perpendicular to the line serves, and any direction at all if
//!   the centre is the origin.
//! - The sides are closed half-spaces, so a ray through an edge or a vertex does not loop for ever.
//!   The number of steps is limited, and reaching a limit is an outcome. A portal without area, or
//!   flat against v0, does not count as one.
//! - Directions of phase one are not normalised. Comparisons with a length are squared instead.
//! - The paper's absolute tolerance 0.001 is relative to the support value here, and rounding error
//!   is relative to the size of the query.
//! - Overlap is decided as soon as the origin is behind a portal and not at the last one. An
//!   intersection test ends there.
//! - The support value h(n) is kept, which is a true upper bound of the depth along n. The paper's
//!   n · v1 is too small until the surface is reached. As a depth, h(n) still depends on the centre
//!   ray; EPA improves it.
//! - Three signed volumes select one of the three triangles in step 6, instead of the six in
//!   Listing 2, and one is always selected. The paper's "should never get here" cannot happen.

mod portal;

use glam::DVec3;

pub(in crate::solver) use self::portal::{Portal, is_clearly_negative};

use self::portal::FLATNESS;
use crate::solver::bound::Bound;
use crate::solver::minkowski::{Minkowski, Point};
use crate::support::SupportMap;
use crate::vector::{perpendicular, unit};

/// Maximum number of replacements in portal discovery. Most pairs need 2 to 3; the worst pair found
/// needed 19.
const MAX_DISCOVERY_STEPS: u32 = 64;

/// Maximum number of portals. Polytopes need 2 to 20. Smooth shapes that touch halve their error in
/// each step, so 60 steps would exhaust the digits of an f64.
const MAX_REFINEMENT_STEPS: u32 = 100;

/// When to stop refining.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::solver) enum Until {
    /// As soon as it is known whether the origin is inside.
    Decided,
    /// When the portal is on the surface, within `tolerance` relative to the support value: the
    /// paper's phase two.
    Surface { tolerance: f64 },
}

/// Position of the origin behind or in front of a portal, as far as portal refinement found it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::solver) enum Side {
    /// Inside the tetrahedron of v0 and the portal.
    Overlapping,
    /// On the surface, within rounding error.
    Touching,
    /// Not known: the step limit was reached, or the portal has no area.
    Undecided,
}

/// Outcome of a search, with its points: the portal, or the last points queried.
#[derive(Clone, Copy, Debug)]
pub(in crate::solver) enum Found {
    /// A separating axis, from A to B and not of unit length.
    Separated { axis: DVec3 },
    /// A portal, and the position of the origin as far as it is known.
    Portal(Side),
    /// No portal: the difference is flat, or the limit on the steps was reached.
    Nothing,
}

/// Purpose of the next support point.
#[derive(Clone, Copy, Debug)]
enum Phase {
    /// v1, towards the origin.
    First,
    /// v2, perpendicular to the plane of v0, v1 and the origin.
    Second,
    /// v3, perpendicular to the plane of v0, v1 and v2; in this step of portal discovery.
    Third { step: u32 },
    /// v4, along the normal of the portal; in this step of portal refinement.
    Fourth { step: u32 },
}

/// A search that waits for a support point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MprSearch {
    v0: DVec3,
    rounding: f64,
    /// Lengths below this are rounding error of a tetrahedron's height.
    flat: f64,
    /// v1, v2 and v3, as far as they are known.
    portal: Portal,
    dir: DVec3,
    phase: Phase,
    /// Steps of portal discovery, when it has ended.
    discovery_steps: u32,
    until: Until,
    side: Side,
    /// With [`Until::Surface`]: the minimum support value along the normal of a portal.
    bound: Option<Bound>,
}

impl MprSearch {
    /// A search that has not seen a support point.
    #[inline(always)]
    pub(in crate::solver) fn new<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        until: Until,
    ) -> Self {
        let v0 = m.center_point().w;
        let rounding = m.rounding_error();
        Self {
            v0,
            rounding,
            flat: FLATNESS * m.outer_radius(),
            portal: Portal::EMPTY,
            dir: if v0.length_squared() > rounding * rounding { -v0 } else { DVec3::X },
            phase: Phase::First,
            discovery_steps: 0,
            until,
            side: Side::Undecided,
            bound: None,
        }
    }

    /// The portal, or the last points queried if there is none.
    pub(in crate::solver) fn portal(&self) -> &Portal {
        &self.portal
    }

    /// The upper bound of the depth that [`Until::Surface`] finds; infinite otherwise.
    pub(in crate::solver) fn bound(&self) -> Bound {
        self.bound.unwrap_or(Bound::none())
    }

    /// The direction of the next support query.
    #[inline(always)]
    pub(in crate::solver) fn direction(&self) -> DVec3 {
        self.dir
    }

    /// Number of steps so far.
    pub(in crate::solver) fn iterations(&self) -> u32 {
        match self.phase {
            Phase::First | Phase::Second => 1,
            Phase::Third { step } => step,
            Phase::Fourth { step } => self.discovery_steps + step,
        }
    }

    /// Continues with the support point `w` in the stated direction. Returns what was found, or
    /// `None` if another support point is needed.
    #[inline(always)]
    pub(in crate::solver) fn continue_with(&mut self, w: Point) -> Option<Found> {
        let n = self.dir;
        let is_separated = is_clearly_negative(w.w.dot(n), n, self.rounding);
        if is_separated {
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
            Phase::First => self.after_first(w),
            Phase::Second => self.after_second(w),
            Phase::Third { step } => self.after_third(w, step),
            Phase::Fourth { step } => self.after_fourth(w, step),
        }
    }

    /// Line 2: v2 is perpendicular to the plane of v0, v1 and the origin; in the line case
    /// perpendicular to the line.
    #[inline(always)]
    fn after_first(&mut self, v1: Point) -> Option<Found> {
        self.portal.vertices[0] = v1;
        let line = v1.w - self.v0;
        self.dir = v1.w.cross(self.v0);
        let spans_plane = self.dir.length_squared() > self.flat * self.flat * line.length_squared();
        if !spans_plane {
            let Some(line) = unit(line) else { return Some(Found::Nothing) };
            self.dir = perpendicular(line);
        }
        self.phase = Phase::Second;
        None
    }

    /// v3 is perpendicular to the plane of v0, v1 and v2, on the origin's side.
    #[inline(always)]
    fn after_second(&mut self, v2: Point) -> Option<Found> {
        let v1 = self.portal.vertices[0];
        let n = (v1.w - self.v0).cross(v2.w - self.v0);
        if n.dot(self.v0) > 0.0 {
            (self.portal.vertices[0], self.portal.vertices[1], self.dir) = (v2, v1, -n);
        } else {
            (self.portal.vertices[0], self.portal.vertices[1], self.dir) = (v1, v2, n);
        }
        self.await_third(1)
    }

    #[inline(always)]
    fn await_third(&mut self, step: u32) -> Option<Found> {
        self.phase = Phase::Third { step };
        (self.dir == DVec3::ZERO).then_some(Found::Nothing)
    }

    /// Lines 3 to 5: while the tetrahedron does not contain the origin, recalculate.
    #[inline(always)]
    fn after_third(&mut self, v3: Point, step: u32) -> Option<Found> {
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
            return self.await_fourth(1);
        }
        if step == MAX_DISCOVERY_STEPS {
            return Some(Found::Nothing);
        }
        let [v1, v2, _] = self.portal.vertices;
        self.dir = (v1.w - v0).cross(v2.w - v0);
        self.await_third(step + 1)
    }

    #[inline(always)]
    fn await_fourth(&mut self, step: u32) -> Option<Found> {
        self.phase = Phase::Fourth { step };
        let Some(mut n) = self.portal.normal() else { return Some(Found::Portal(self.side)) };
        if self.until != Until::Decided {
            n /= n.length();
        }
        self.dir = n;
        // Line 9: the origin is behind the portal.
        if is_clearly_negative(-n.dot(self.portal.vertices[0].w), n, self.rounding) {
            self.side = Side::Overlapping;
            if self.until == Until::Decided {
                return Some(Found::Portal(self.side));
            }
        }
        None
    }

    #[inline(always)]
    fn after_fourth(&mut self, v4: Point, step: u32) -> Option<Found> {
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
            if self.side == Side::Undecided && !is_clearly_negative(-value.abs(), n, 2.0 * self.rounding) {
                self.side = Side::Touching;
            }
            return Some(Found::Portal(self.side));
        }
        // Lines 7 and 8, Listing 2: v4 replaces one vertex, so that the ray pierces the new portal.
        let ray_normal = v4.w.cross(self.v0);
        let replaced = match (v1.dot(ray_normal) >= 0.0, v2.dot(ray_normal) >= 0.0, v3.dot(ray_normal) >= 0.0) {
            (true, true, _) | (false, _, false) => 0,
            (true, false, _) => 2,
            (false, _, true) => 1,
        };
        self.portal.vertices[replaced] = v4;
        if step == MAX_REFINEMENT_STEPS {
            return Some(Found::Portal(self.side));
        }
        self.await_fourth(step + 1)
    }
}
