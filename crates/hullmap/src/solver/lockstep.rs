//! Lockstep contact: MPR in a fixed number of steps, the same work for every pair.
//!
//! On machines that run many pairs in lockstep (SIMD lanes, GPU threads) the slowest pair sets the
//! pace, so a pair that ends early saves nothing. Here no pair ends early. Each takes exactly the
//! requested number of support calls, in constant memory, and each step selects values instead of
//! branching. The interval contains the depth after any number of steps. More steps narrow it on
//! average up to about 24, when nearly all searches have come to an end.
//!
//! # Reference
//! Kenwright, section 4.7.
//!
//! # Steps
//! 1. v0 is the centre. The first portal comes from three support calls, or from the cached
//!    features under the new pose.
//! 2. In each step, if the ray from v0 through the origin misses the portal on one side, replace
//!    the vertex across that side by a support point (portal discovery). Otherwise query along the
//!    portal's normal and replace the vertex across the ray (portal refinement).
//! 3. Each direction gives an upper bound of the depth, or separates the shapes. Each tetrahedron
//!    of v0 and portal that contains the origin gives a lower bound.
//! 4. After half of the steps, and after three quarters, redirect the ray to the best normal so
//!    far.
//!
//! # Deviations
//! - Step 4. The ray of the paper stays the same, which makes the depth up to 3.8 times too large.
//!   The redirected ray leads to a local minimum of the depth, and usually to the global one.
//! - The lower bound is that of a tetrahedron, and coarse. Only the expansion of
//!   [`contact`](crate::contact()) closes the interval, and its length varies from pair to pair.

use super::bound::Bound;
use super::cache::Cache;
use super::contact::Contact;
use super::contact::separated_contact;
use super::epa::Polytope;
use super::epa::{FOOT_ROUNDINGS, TOUCHING_ROUNDINGS};
use super::intersection::store_separation;
use super::minkowski::{Minkowski, Point};
use super::mpr::{FLATNESS, is_clearly_negative};
use super::status::Status;
use crate::pose::Pose;
use crate::support::SupportMap;
use crate::vector::{perpendicular, unit};
use glam::DVec3;

/// Minimum number of steps: three for a portal, and one along its normal.
const MIN_STEPS: u32 = 4;

/// Start of the redirected ray, relative to the radius of a ball around the origin that is
/// certainly inside.
const RAY_START: f64 = 0.5;

/// The state of one lane, that is, of one pair.
#[derive(Clone, Debug)]
struct Lane {
    /// A point inside the Minkowski difference. The ray runs from it through the origin.
    v0: DVec3,
    /// Counter-clockwise as seen from outside.
    portal: [Point; 3],
    /// Minimum support value so far.
    upper: f64,
    /// The unit normal of that support value.
    normal: DVec3,
    /// The portal at that time.
    face: [Point; 3],
    /// The support point that has that value.
    deepest: Point,
    /// A separating axis, and the points seen last.
    separating: Option<(DVec3, [Point; 3])>,
    /// Radius of a ball around the origin inside the Minkowski difference; negative if none is
    /// known.
    lower: f64,
}

/// Contact of `a` and `b`, with `b` at `b_in_a`, in exactly `steps` support calls (at least four).
///
/// Lengths are in the shapes' unit, points and directions in A's frame. After few steps the
/// interval of the depth is wide, and the status is [`Status::IterationLimit`] unless only rounding
/// error is left. [`Contact::hit`] is false only if a separating plane was found. `cache` belongs
/// to this ordered pair. The search starts from its last portal, so the interval narrows from frame
/// to frame.
///
/// # Complexity
/// `steps` support calls, always. No allocation; the memory does not depend on `steps`.
///
/// # Reference
/// Kenwright, section 4.7.
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::{Cache, Pose, contact_lockstep, shapes::Cuboid};
///
/// let cube = Cuboid::new(DVec3::ONE)?;
/// let b_in_a = Pose::from_translation(DVec3::new(0.3, 1.75, 0.2))?;
/// let c = contact_lockstep(&cube, &cube, b_in_a, 12, &mut Cache::new());
/// assert!(c.hit && c.support_calls == 12);
/// assert!(c.depth_lower <= 0.25 && 0.25 <= c.depth_upper);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn contact_lockstep<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    steps: u32,
    cache: &mut Cache,
) -> Contact {
    let mut m = Minkowski::new(a, b, b_in_a);
    let steps = steps.max(MIN_STEPS);
    let mut lane = Lane::start(&mut m, cache);
    while m.support_calls() < steps {
        let remaining = steps - m.support_calls();
        if remaining == steps / 2 || remaining == steps / 4 {
            lane.redirect_ray();
        }
        lane.step(&mut m);
    }
    let mut out = lane.finish(&m, cache);
    out.iterations = steps;
    out.support_calls = m.support_calls();
    out
}

impl Lane {
    /// Finds the first portal, from the cache or by three support calls.
    fn start<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(m: &mut Minkowski<'_, A, B>, cache: &Cache) -> Self {
        let v0 = m.center_point().w;
        let mut lane = Self {
            v0,
            portal: [Point::EMPTY; 3],
            upper: f64::INFINITY,
            normal: DVec3::X,
            face: [Point::EMPTY; 3],
            deepest: Point::EMPTY,
            separating: None,
            lower: m.inner_radius() - v0.length(),
        };
        if let Some(kept) = cache.portal()
            && let [Some(v1), Some(v2), Some(v3)] = kept.map(|features| m.recall(features))
        {
            lane.portal = [v1, v2, v3];
        } else {
            let towards = if v0.length() > m.rounding_error() { -v0 } else { DVec3::X };
            let v1 = lane.query(m, towards);
            let line = unit(v1.w - v0).unwrap_or(DVec3::X);
            let beside = unit(v1.w.cross(v0)).unwrap_or_else(|| perpendicular(line));
            let v2 = lane.query(m, beside);
            let n = (v1.w - v0).cross(v2.w - v0);
            let v3 = lane.query(m, if n.dot(v0) > 0.0 { -n } else { n });
            lane.portal = [v1, v2, v3];
        }
        lane.orient_outwards();
        lane.face = lane.portal;
        lane
    }

    /// Support point along `n`, or along the ray if `n` is zero. Updates the bound and the
    /// separating axis.
    fn query<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &mut self,
        m: &mut Minkowski<'_, A, B>,
        n: DVec3,
    ) -> Point {
        let n = unit(n).or_else(|| unit(-self.v0)).unwrap_or(DVec3::X);
        let point = m.point(n);
        let value = point.w.dot(n);
        // NaN is no bound.
        if value < self.upper {
            (self.upper, self.normal, self.face, self.deepest) = (value, n, self.portal, point);
        }
        if is_clearly_negative(value, n, m.rounding_error()) {
            let [v1, v2, _] = self.portal;
            self.separating = Some((n, [point, v1, v2]));
        }
        point
    }

    /// Swaps two vertices if the portal is clockwise as seen from outside.
    fn orient_outwards(&mut self) {
        let [v1, v2, v3] = self.portal.map(|v| v.w);
        if (v2 - v1).cross(v3 - v1).dot(v1 - self.v0) < 0.0 {
            self.portal.swap(0, 1);
        }
    }

    /// One support call.
    fn step<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(&mut self, m: &mut Minkowski<'_, A, B>) {
        let v0 = self.v0;
        let [v1, v2, v3] = self.portal.map(|v| v.w);
        // Portal discovery (Listing 2, phase 1): the vertex across the side where the ray misses
        // the portal.
        let missed = if v1.cross(v3).dot(v0) < 0.0 {
            Some(1)
        } else if v3.cross(v2).dot(v0) < 0.0 {
            Some(0)
        } else if v2.cross(v1).dot(v0) < 0.0 {
            Some(2)
        } else {
            None
        };
        if let Some(across) = missed {
            let (from, to) = (self.portal[(across + 1) % 3], self.portal[(across + 2) % 3]);
            // Away from the vertex that is replaced: the ray is on that side.
            self.portal[across] = self.query(m, -(from.w - v0).cross(to.w - v0));
            self.orient_outwards();
        } else {
            // Portal refinement (Listing 2, phase 2).
            let (e2, e3) = (v2 - v1, v3 - v1);
            let n = e2.cross(e3);
            let thin = !(n.length_squared() > FLATNESS * FLATNESS * e2.length_squared() * e3.length_squared());
            let v4 = self.query(m, if thin { -v0 } else { n });
            if is_clearly_negative((v1 - v4.w).dot(n), n, m.rounding_error()) {
                let ray_normal = v4.w.cross(v0);
                let across = match (v1.dot(ray_normal) >= 0.0, v2.dot(ray_normal) >= 0.0, v3.dot(ray_normal) >= 0.0) {
                    (true, true, _) | (false, _, false) => 0,
                    (true, false, _) => 2,
                    (false, _, true) => 1,
                };
                self.portal[across] = v4;
            }
        }
        self.raise_lower_bound(m.noise());
    }

    /// Raises the lower bound by the tetrahedron of v0 and the portal, if it contains the origin.
    #[inline(always)]
    fn raise_lower_bound(&mut self, noise: f64) {
        let [v1, v2, v3] = self.portal;
        let mut tetrahedron = Polytope::<4, 8>::empty(noise);
        let solid = tetrahedron.start([Point { w: self.v0, ..Point::EMPTY }, v1, v2, v3], 0.0);
        let (_, _, offset) = tetrahedron.plane(tetrahedron.nearest_face());
        if solid && tetrahedron.encloses() && offset > self.lower {
            self.lower = offset;
        }
    }

    /// Redirects the ray to the best normal so far, if the origin is certainly inside.
    fn redirect_ray(&mut self) {
        if self.lower > 0.0 {
            self.v0 = -self.normal * (self.lower * RAY_START);
            self.portal = self.face;
            self.orient_outwards();
        }
    }

    /// The answer. Stores the portal, or the separating axis, in the cache.
    fn finish<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        self,
        m: &Minkowski<'_, A, B>,
        cache: &mut Cache,
    ) -> Contact {
        if let Some((axis, seen)) = self.separating {
            store_separation(cache, axis, &seen);
            return separated_contact(m, cache, axis, 0);
        }
        if m.outer_balls_separated() {
            return separated_contact(m, cache, -m.center_point().w, 0);
        }
        cache.forget_axis();
        cache.set_portal(&self.face);
        let (noise, rounding) = (m.noise(), m.rounding_error());
        let mut bound = Bound::at(self.upper, self.normal, self.face.each_ref());
        let lower = (self.lower - noise).max(0.0);
        bound.deepen(lower, |_| self.deepest);
        // The witness points are opposite each other. There is no step left to search for others.
        let is_settled = |width: f64| bound.off() <= width.max(0.0) + FOOT_ROUNDINGS * rounding;
        let status = if self.upper <= TOUCHING_ROUNDINGS * rounding && lower == 0.0 && is_settled(self.upper) {
            Status::Touching
        } else if self.upper - self.lower <= rounding && is_settled(self.upper - self.lower) {
            Status::Exact
        } else {
            Status::IterationLimit
        };
        Contact {
            hit: true,
            status,
            depth: if status == Status::Touching { 0.0 } else { self.upper.max(lower) },
            depth_lower: lower,
            depth_upper: self.upper.max(0.0) + rounding,
            normal: self.normal,
            point_a: bound.point_a,
            point_b: bound.point_b,
            iterations: 0,
            support_calls: 0,
        }
    }
}
