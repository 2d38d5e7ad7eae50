//! Both phases of MPR as a state machine: it states a direction, and continues with the support
//! point in that direction.
//!
//! A batch keeps several searches in flight: while the memory that one of them needs is on its way,
//! the others compute. The steps and the arithmetic are those of [`discover_portal`] and of
//! [`refine_portal`] with [`Until::Decided`], which are the twin in tests. A single query uses
//! them, since a loop keeps its state in registers.
//!
//! [`discover_portal`]: super::discover_portal
//! [`refine_portal`]: super::refine_portal
//! [`Until::Decided`]: super::Until::Decided

use super::discovery::{FLATNESS, MAX_DISCOVERY_STEPS, Portal, is_clearly_negative};
use super::refinement::{MAX_REFINEMENT_STEPS, Side};
use crate::solver::minkowski::{Minkowski, Point};
use crate::support::SupportMap;
use crate::vector::{perpendicular, unit};
use glam::DVec3;

/// What a search found. The points belong to it: the portal, or those seen last.
#[derive(Clone, Copy, Debug)]
pub(in crate::solver) enum Found {
    /// A separating axis.
    Separated { axis: DVec3 },
    /// A portal, and where the origin is as far as it shows. Not [`Side::Separated`].
    Portal(Side),
    /// No portal: the difference is flat, or the limit on the steps was reached.
    Nothing,
}

/// What the next support point is for.
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
pub(in crate::solver) struct Search {
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
}

impl Search {
    /// A search that has not seen a support point.
    #[inline]
    pub(in crate::solver) fn new<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(m: &Minkowski<'_, A, B>) -> Self {
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
        }
    }

    /// The portal, or the points seen last if there is none.
    pub(in crate::solver) fn portal(&self) -> &Portal {
        &self.portal
    }

    /// The direction of the next support query.
    #[inline]
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

    #[inline(always)]
    fn after_first(&mut self, v1: Point) -> Option<Found> {
        self.portal.vertices = [v1; 3];
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

    #[inline(always)]
    fn after_third(&mut self, v3: Point, step: u32) -> Option<Found> {
        let (v0, n) = (self.v0, self.dir);
        let [v1, v2, _] = self.portal.vertices;
        if v1.w.cross(v3.w).dot(v0) < 0.0 {
            self.portal.vertices[1] = v3;
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
        let Some(n) = self.portal.normal() else { return Some(Found::Portal(Side::Undecided)) };
        self.dir = n;
        // The origin is behind the portal.
        let behind = is_clearly_negative(-n.dot(self.portal.vertices[0].w), n, self.rounding);
        behind.then_some(Found::Portal(Side::Overlapping))
    }

    #[inline(always)]
    fn after_fourth(&mut self, v4: Point, step: u32) -> Option<Found> {
        let n = self.dir;
        let [v1, v2, v3] = self.portal.vertices.map(|v| v.w);
        let value = v4.w.dot(n);
        // NaN counts as the surface, since no point is known to be farther out.
        if !is_clearly_negative(n.dot(v1) - value, n, self.rounding) {
            let touching = !is_clearly_negative(-value.abs(), n, 2.0 * self.rounding);
            let side = if touching { Side::Touching } else { Side::Undecided };
            return Some(Found::Portal(side));
        }
        let ray_normal = v4.w.cross(self.v0);
        let replaced = match (v1.dot(ray_normal) >= 0.0, v2.dot(ray_normal) >= 0.0, v3.dot(ray_normal) >= 0.0) {
            (true, true, _) | (false, _, false) => 0,
            (true, false, _) => 2,
            (false, _, true) => 1,
        };
        self.portal.vertices[replaced] = v4;
        if step == MAX_REFINEMENT_STEPS {
            return Some(Found::Portal(Side::Undecided));
        }
        self.await_fourth(step + 1)
    }
}
