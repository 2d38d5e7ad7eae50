//! The first time at which two moving bodies come within a distance of each other.
//!
//! # Steps
//! 1. Compute the distance of the bodies and its direction, at a time up to which they are
//!    certainly farther apart than the target.
//! 2. Take the longest step during which they certainly stay apart along that direction
//!    (`advance`).
//! 3. Repeat from the end of the step, until the end of the motion is reached, or the bodies are
//!    near each other. Then look for a time at which they are certainly within the distance.
//!
//! # Reference
//! Mirtich 1996 (conservative advancement); Catto, "Continuous collision", GDC 2013, for steps
//! along a separating direction.

use glam::DVec3;

use super::advance::{Approach, Frame, Moment, Step};
use super::time_of_impact::TimeOfImpact;
use crate::pose::Pose;
use crate::solver::{Contact, Distance, Settings, Status};
use crate::support::SupportMap;

/// Settings of the queries at one time.
pub(crate) const DIRECTIONS: Settings = Settings { tolerance: 1e-6, max_iterations: Settings::DEFAULT_MAX_ITERATIONS };

/// Multiples of the estimated time to the impact at which the shapes may certainly have met.
const ATTEMPTS: [f64; 3] = [1.0 + 1e-3, 2.0, 16.0];

/// The search ends where the distance exceeds the target by at most this many noises. Below one, no
/// step is sure; a step that starts here would lead to little more than that.
const LAST: f64 = 2.5;

/// Greatest share of the least distance that a clearance is proven for: at 1, there would be no
/// room for a step.
const MAX_SHARE: f64 = 0.95;

/// The goal of searches, and what they found so far, for one pair or for many pairs that share a
/// budget.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// Bodies meet when their distance is at most this.
    margin: f64,
    /// Bodies that certainly do not meet are to be farther apart than this share of `nearest`.
    share: f64,
    /// Whether the search also looks for a time at which the bodies certainly meet.
    seeks_meeting: bool,
    /// The least upper bound of a distance at any time that was tried.
    pub(crate) nearest: f64,
    /// The distance certainly exceeds this wherever the searches have passed.
    pub(crate) clearance: f64,
    /// Number of distance and contact queries that are left.
    pub(crate) budget: u32,
}

impl Goal {
    /// To find when bodies meet. NaN and negative margins count as 0.
    pub(crate) fn meeting(margin: f64, budget: u32) -> Self {
        let never = f64::INFINITY;
        Self { margin: margin.max(0.0), share: 0.0, seeks_meeting: true, nearest: never, clearance: never, budget }
    }

    /// To find until when bodies that contain the given ones certainly do not meet, by few queries.
    pub(crate) fn rough(&self, budget: u32) -> Self {
        Self { margin: self.target(), share: 0.0, seeks_meeting: false, budget: budget.min(self.budget), ..*self }
    }

    /// Takes over what a [`rough`](Self::rough) goal has found.
    pub(crate) fn add_rough(&mut self, rough: &Self, limit: u32) {
        self.budget = self.budget.saturating_sub(limit.min(self.budget) - rough.budget);
        self.clearance = rough.clearance;
    }

    /// To prove a better clearance of bodies that do not meet, with what is left of the budget.
    /// `None` if the clearance of the first searches is good enough. NaN and negative shares count
    /// as 0.
    pub(crate) fn better(&self, share: f64) -> Option<Self> {
        let share = share.clamp(0.0, MAX_SHARE).max(0.0);
        let is_open = self.clearance < share * self.nearest && self.margin < share * self.nearest;
        is_open.then_some(Self { share, seeks_meeting: false, clearance: f64::INFINITY, ..*self })
    }

    /// The distance that a step is to stay above. It never rises.
    pub(crate) fn target(&self) -> f64 {
        if self.share > 0.0 { self.margin.max(self.share * self.nearest) } else { self.margin }
    }
}

/// Distance and contact of two bodies at a pose of B in A's frame.
pub(crate) trait Queries {
    fn distance(&mut self, b_in_a: Pose) -> Distance;
    fn contact(&mut self, b_in_a: Pose) -> Contact;

    /// Whether it is certain without a search, from what the last distance query found at a pose
    /// nearby, that the bodies overlap by more than `depth`.
    fn overlap_near(&mut self, _b_in_a: Pose, _depth: f64) -> bool {
        false
    }
}

/// A search in a window of time.
pub(super) struct ImpactSearch<'s, 'g, A: ?Sized, B: ?Sized, Q> {
    pair: Approach<'s, A, B>,
    queries: Q,
    noise: f64,
    /// The separation may exceed the margin by this length.
    enough: f64,
    goal: &'g mut Goal,
    /// The time of the last distance query.
    here: Moment,
    /// The frame in which the direction of the last step was fixed.
    frame: Frame,
    /// The answer so far: until `t_lower`, the bodies are certainly farther apart than the target.
    found: TimeOfImpact,
}

impl<'s, 'g, A, B, Q> ImpactSearch<'s, 'g, A, B, Q>
where
    A: SupportMap + ?Sized,
    B: SupportMap + ?Sized,
    Q: Queries,
{
    /// The first time in the `window` at which the distance is at most the goal's target. Before
    /// the window, the distance is certainly above it. A miss is one until the end of the window.
    pub(super) fn run(
        pair: Approach<'s, A, B>,
        queries: Q,
        tolerance: f64,
        goal: &'g mut Goal,
        window: [f64; 2],
    ) -> TimeOfImpact {
        let enough = tolerance.max(0.0) * (pair.a.shape.outer_radius() + pair.b.shape.outer_radius());
        let found = TimeOfImpact { t_lower: window[0], ..TimeOfImpact::default() };
        let (noise, here) = (pair.noise(), pair.moment_at(window[0]));
        let mut search = Self { noise, pair, queries, enough, goal, here, frame: Frame::default(), found };
        search.advance(window);
        search.found
    }

    fn advance(&mut self, [start, until]: [f64; 2]) {
        let mut gap = self.distance();
        if self.meet(&gap) {
            let status = if start == 0.0 { Status::Overlapping } else { Status::Within };
            self.found = TimeOfImpact { status, t: start, t_upper: start, ..self.found };
            return;
        }
        let mut has_tried = false;
        while self.goal.budget > 0 {
            let (t, normal, target) = (self.found.t_lower, self.found.normal, self.goal.target());
            let excess = gap.upper - target;
            let is_last = excess <= LAST * self.noise;
            // A clearance has no tolerance: the share of a small distance may be less than that.
            if !self.goal.seeks_meeting && self.goal.share == 0.0 && excess <= self.enough {
                return self.end(Status::Stalled);
            }
            // Flat shapes have no depth, so it is never sure that they meet.
            let is_near = is_last || (excess <= self.enough + self.noise && !has_tried);
            let tries = is_near && self.goal.seeks_meeting;
            if tries && self.find_meeting(until, gap.distance) {
                return self.found.status = Status::Within;
            }
            has_tried |= tries;
            let speed = self.speed(t);
            let meeting = if speed > 0.0 { t + excess / speed } else { f64::INFINITY };
            let plane = (normal, gap.lower);
            let hints = (&mut self.frame, &mut self.found.support_calls);
            let step = self.pair.step(&mut self.here, plane, until, meeting, target, hints);
            let (later, least) = match step {
                Step::Apart(least) => {
                    self.goal.clearance = self.goal.clearance.min(least);
                    return self.separated();
                }
                _ if is_last => return self.end(Status::Touching),
                // The distance query has no good direction.
                Step::Nowhere => return self.end(Status::Stalled),
                Step::To(later, least) => (later, least),
            };
            self.found.t_lower = later;
            self.goal.clearance = self.goal.clearance.min(least);
            gap = self.distance();
        }
        self.end(Status::IterationLimit);
    }

    fn end(&mut self, status: Status) {
        (self.found.status, self.found.t) = (status, self.found.t_lower);
    }

    /// Speed at which the closest points approach each other at time `t`.
    fn speed(&self, t: f64) -> f64 {
        let TimeOfImpact { normal, point_a, point_b, .. } = self.found;
        let Approach { a, b, .. } = &self.pair;
        (a.motion.velocity_at(t, point_a) - b.motion.velocity_at(t, point_b)).dot(normal)
    }

    /// The distance of the bodies where they are now. The answer takes its direction and points.
    fn distance(&mut self) -> Distance {
        let poses = self.here.poses();
        let gap = self.queries.distance(relative(poses));
        let place = |point: DVec3| poses[0].transform_point(point);
        self.found.normal = poses[0].transform_vector(gap.normal);
        (self.found.point_a, self.found.point_b) = (place(gap.point_a), place(gap.point_b));
        self.count(gap.support_calls);
        self.goal.nearest = self.goal.nearest.min(gap.upper + self.noise);
        gap
    }

    fn count(&mut self, support_calls: u32) {
        self.found.iterations += 1;
        self.found.support_calls += support_calls;
        self.goal.budget = self.goal.budget.saturating_sub(1);
    }

    /// Whether bodies with this distance are certainly within the margin.
    fn meet(&self, gap: &Distance) -> bool {
        gap.status == Status::Overlapping || gap.upper + self.noise <= self.goal.margin
    }

    /// Looks for a time after the lower bound, where they are at `distance`, at which the bodies
    /// certainly meet. Sets the answer and returns true if there is one.
    fn find_meeting(&mut self, until: f64, distance: f64) -> bool {
        let t = self.found.t_lower;
        let speed = self.speed(t);
        // NaN takes the failing branch.
        if !(speed > 0.0) {
            return false;
        }
        let excess = (distance - self.goal.margin).max(0.0);
        for attempt in ATTEMPTS {
            let later = (t + (excess + 4.0 * self.noise) / speed * attempt).min(until);
            if self.goal.budget > 0 && self.certainly_meet_at(later) {
                self.found.t = (t + excess / speed).min(later);
                self.found.t_upper = later;
                return true;
            }
            if later == until {
                return false;
            }
        }
        false
    }

    fn certainly_meet_at(&mut self, t: f64) -> bool {
        let b_in_a = relative(self.pair.moment_at(t).poses());
        if self.goal.margin == 0.0 {
            // The poses have rounding errors, too.
            if self.queries.overlap_near(b_in_a, self.noise) {
                return true;
            }
            let found = self.queries.contact(b_in_a);
            self.count(found.support_calls);
            return found.hit && found.depth_lower > self.noise;
        }
        let gap = self.queries.distance(b_in_a);
        self.count(gap.support_calls);
        self.meet(&gap)
    }

    fn separated(&mut self) {
        let TimeOfImpact { iterations, support_calls, normal, .. } = self.found;
        self.found = TimeOfImpact { iterations, support_calls, normal, ..TimeOfImpact::NEVER };
    }
}

/// The pose of B in A's frame, from the poses of both in a common frame, whose lengths are in
/// range.
fn relative([a, b]: [Pose; 2]) -> Pose {
    let back = a.rotation().conjugate();
    Pose::from_parts((back * b.rotation()).normalize(), back * (b.translation() - a.translation()))
}
