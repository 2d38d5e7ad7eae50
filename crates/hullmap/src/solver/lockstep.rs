//! Contact in a fixed number of steps: the same work for every pair.
//!
//! For machines that run many pairs in lockstep (SIMD lanes, GPU threads) the slowest pair sets the pace, so a pair that is
//! done early gains nothing. Here no pair is: each takes exactly as many support calls as were asked for, in constant memory, and
//! each step chooses between values, not between ways. More steps narrow the interval; any number gives a true one.
//!
//! # Reference
//! Kenwright, section 4.7.
//!
//! # Steps
//! 1. v0 = the centre; a start for the portal: three support calls, or the last query's features under the new pose;
//! 2. a step: if the ray from v0 through the origin passes beside the portal, look for a vertex on that side (phase one);
//!    else look along the portal's normal, and replace a vertex by what is found (phase two);
//! 3. each direction looked along gives an upper bound of the depth, or separates; each tetrahedron of v0 and portal that
//!    holds the origin gives a lower bound;
//! 4. after half the steps, and after three quarters, the ray is turned to the best normal so far.
//!
//! # Deviations
//! - Step 4. The paper's ray stays, and with it a depth that is too large by up to 3.8 times. Turned, the ray goes to a local
//!   minimum of the depth, mostly the global one.
//! - The lower bound is that of a tetrahedron, and rough: what closes the interval is the expansion of
//!   [`contact`](crate::contact), which is as long as it is.

use super::contact::apart;
use super::discovery::{FLAT, is_beyond};
use super::expansion::{Bound, TOUCHING_ROUNDINGS};
use super::intersection::keep_miss;
use super::polytope::Polytope;
use crate::minkowski::{Minkowski, Point, perpendicular, unit};
use crate::{Cache, Contact, Pose, Status, SupportMap};
use glam::DVec3;

/// Fewest steps: a portal, and its normal.
const LEAST_STEPS: u32 = 4;

/// Where the turned ray starts, over the radius of the ball around the origin that is known to be inside.
const BEHIND: f64 = 0.5;

/// What a lane holds.
#[derive(Clone, Debug)]
struct Lane {
    /// A point inside the difference, from which the ray goes through the origin.
    v0: DVec3,
    /// Counter-clockwise as seen from outside.
    portal: [Point; 3],
    /// Least support value so far, along which unit normal, and the portal then.
    upper: f64,
    normal: DVec3,
    face: [Point; 3],
    /// A direction with a support value below zero, and what was seen there.
    separating: Option<(DVec3, [Point; 3])>,
    /// Radius of a ball about the origin inside the difference.
    lower: f64,
}

/// Contact of `a` and of `b` placed at `b_in_a`, in exactly `steps` support calls, or four if fewer are asked for.
///
/// The interval is true and, after few steps, wide; it is told as [`Status::IterationLimit`] unless rounding
/// is all that is left of it. `hit` is false only when a separating plane was found. `cache` belongs to this ordered pair: the last
/// portal is where the search starts, so that an interval gets narrower from frame to frame.
///
/// # Complexity
/// `steps` support calls, always. No allocation, and no memory that grows with `steps`.
///
/// # Reference
/// Kenwright, section 4.7.
pub fn contact_in_steps<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    steps: u32,
    cache: &mut Cache,
) -> Contact {
    let mut m = Minkowski::new(a, b, b_in_a);
    let steps = steps.max(LEAST_STEPS);
    let mut lane = Lane::start(&mut m, cache);
    while m.support_calls() < steps {
        let left = steps - m.support_calls();
        if left == steps / 2 || left == steps / 4 {
            lane.turn();
        }
        lane.step(&mut m);
    }
    let mut out = lane.finish(&m, cache);
    out.iterations = steps;
    out.support_calls = m.support_calls();
    out
}

impl Lane {
    fn start<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(m: &mut Minkowski<'_, A, B>, cache: &Cache) -> Self {
        let v0 = m.center_point().w;
        let mut lane = Self {
            v0,
            portal: [Point::EMPTY; 3],
            upper: f64::INFINITY,
            normal: DVec3::X,
            face: [Point::EMPTY; 3],
            separating: None,
            lower: m.inner_radius() - v0.length(),
        };
        if let Some(kept) = cache.portal()
            && let [Some(v1), Some(v2), Some(v3)] = kept.map(|features| m.recall(features))
        {
            lane.portal = [v1, v2, v3];
        } else {
            let towards = if v0.length() > m.rounding() { -v0 } else { DVec3::X };
            let v1 = lane.look(m, towards);
            let line = unit(v1.w - v0).unwrap_or(DVec3::X);
            let beside = unit(v1.w.cross(v0)).unwrap_or_else(|| perpendicular(line));
            let v2 = lane.look(m, beside);
            let n = (v1.w - v0).cross(v2.w - v0);
            let v3 = lane.look(m, if n.dot(v0) > 0.0 { -n } else { n });
            lane.portal = [v1, v2, v3];
        }
        lane.face_outwards();
        lane.face = lane.portal;
        lane
    }

    /// Support along `n`, with what it says of the depth. A zero direction looks along the ray instead.
    fn look<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(&mut self, m: &mut Minkowski<'_, A, B>, n: DVec3) -> Point {
        let n = unit(n).or_else(|| unit(-self.v0)).unwrap_or(DVec3::X);
        let point = m.point(n);
        let value = point.w.dot(n);
        // NaN is no bound.
        if value < self.upper {
            (self.upper, self.normal, self.face) = (value, n, self.portal);
        }
        if is_beyond(value, n, m.rounding()) {
            let [v1, v2, _] = self.portal;
            self.separating = Some((n, [point, v1, v2]));
        }
        point
    }

    /// Exchanges two vertices if the portal is clockwise as seen from the ray's end.
    fn face_outwards(&mut self) {
        let [v1, v2, v3] = self.portal.map(|v| v.w);
        if (v2 - v1).cross(v3 - v1).dot(v1 - self.v0) < 0.0 {
            self.portal.swap(0, 1);
        }
    }

    fn step<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(&mut self, m: &mut Minkowski<'_, A, B>) {
        let v0 = self.v0;
        let [v1, v2, v3] = self.portal.map(|v| v.w);
        // Listing 2, phase 1: the side that the ray passes, if any, and the vertex across it.
        let passed = if v1.cross(v3).dot(v0) < 0.0 {
            Some(1)
        } else if v3.cross(v2).dot(v0) < 0.0 {
            Some(0)
        } else if v2.cross(v1).dot(v0) < 0.0 {
            Some(2)
        } else {
            None
        };
        if let Some(across) = passed {
            let (from, to) = (self.portal[(across + 1) % 3], self.portal[(across + 2) % 3]);
            // Away from the vertex across: the ray is there.
            self.portal[across] = self.look(m, -(from.w - v0).cross(to.w - v0));
            self.face_outwards();
        } else {
            // Phase 2.
            let (e2, e3) = (v2 - v1, v3 - v1);
            let n = e2.cross(e3);
            let thin = !(n.length_squared() > FLAT * FLAT * e2.length_squared() * e3.length_squared());
            let v4 = self.look(m, if thin { -v0 } else { n });
            if is_beyond((v1 - v4.w).dot(n), n, m.rounding()) {
                let beside = v4.w.cross(v0);
                let across = match (v1.dot(beside) >= 0.0, v2.dot(beside) >= 0.0, v3.dot(beside) >= 0.0) {
                    (true, true, _) | (false, _, false) => 0,
                    (true, false, _) => 2,
                    (false, _, true) => 1,
                };
                self.portal[across] = v4;
            }
        }
        // What the tetrahedron of v0 and portal says of the depth.
        let [v1, v2, v3] = self.portal;
        let mut tetrahedron = Polytope::<4, 8>::empty(m.noise());
        let solid = tetrahedron.start([Point { w: v0, ..Point::EMPTY }, v1, v2, v3], 0.0);
        let (_, _, offset) = tetrahedron.plane(tetrahedron.nearest_face());
        if solid && tetrahedron.encloses() && offset > self.lower {
            self.lower = offset;
        }
    }

    /// Turns the ray to the best normal so far, if the origin is known to be inside.
    fn turn(&mut self) {
        if self.lower > 0.0 {
            self.v0 = -self.normal * (self.lower * BEHIND);
            self.portal = self.face;
            self.face_outwards();
        }
    }

    fn finish<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        self,
        m: &Minkowski<'_, A, B>,
        cache: &mut Cache,
    ) -> Contact {
        if let Some((axis, seen)) = self.separating {
            keep_miss(cache, axis, &seen);
            return apart(m, cache, axis, 0);
        }
        if m.outer_balls_apart() {
            return apart(m, cache, -m.center_point().w, 0);
        }
        cache.forget_axis();
        cache.set_portal(&self.face);
        let (noise, rounding) = (m.noise(), m.rounding());
        let status = if self.upper <= TOUCHING_ROUNDINGS * rounding {
            Status::Touching
        } else if self.upper - self.lower <= rounding {
            Status::Exact
        } else {
            Status::IterationLimit
        };
        let bound = Bound::at(self.upper, self.normal, self.face.each_ref());
        Contact {
            hit: true,
            status,
            depth: if status == Status::Touching { 0.0 } else { self.upper },
            depth_lower: (self.lower - noise).max(0.0),
            depth_upper: self.upper.max(0.0) + rounding,
            normal: self.normal,
            point_a: bound.point_a,
            point_b: bound.point_b,
            iterations: 0,
            support_calls: 0,
        }
    }
}
