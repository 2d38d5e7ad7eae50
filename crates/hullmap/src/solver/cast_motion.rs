//! Time of impact of two shapes that move and turn.
//!
//! # Steps
//! 1. The distance of the shapes at a time up to which they surely do not meet, and its direction.
//! 2. The longest step in which they surely stay apart along that direction (`advance`).
//! 3. Repeat from the end of the step, until the shapes are surely apart until the end, or near
//!    each other. Then look for a time at which they surely meet.
//!
//! # Reference
//! Mirtich 1996 (conservative advancement); Catto, "Continuous collision", GDC 2013, for steps
//! along a separating direction.

use glam::DVec3;

use super::advance::{Moving, MovingPair, Separation, Step};
use super::cache::Cache;
use super::distance::Distance;
use super::queries::{contact, distance};
use super::rigid_motion::RigidMotion;
use super::settings::Settings;
use super::status::Status;
use crate::pose::Pose;
use crate::support::SupportMap;

/// Settings of the queries at one time.
const DIRECTIONS: Settings = Settings { tolerance: 1e-6, max_iterations: Settings::DEFAULT_MAX_ITERATIONS };

/// Multiples of the estimated time to the impact at which the shapes may surely have met.
const ATTEMPTS: [f64; 3] = [1.0 + 1e-3, 2.0, 16.0];

/// Limits and accuracy of [`cast_motion`](crate::cast_motion()).
///
/// ```
/// use hullmap::MotionSettings;
///
/// // A skin of a millimetre.
/// let settings = MotionSettings { target_distance: 1e-3, ..MotionSettings::default() };
/// assert_eq!(settings.max_iterations, 200);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionSettings {
    /// The shapes meet when their distance is at most this: a length, 0 by default. NaN and
    /// negative values count as 0.
    pub target_distance: f64,
    /// At the lower bound of the time of impact, the distance of the shapes exceeds the target by
    /// at most this fraction of the sum of their outer radii. Dimensionless; the default is 1e-6.
    ///
    /// NaN and negative values count as 0: the interval becomes as narrow as rounding error allows.
    pub tolerance: f64,
    /// Maximum number of distance and contact queries. The default is 200. One query, at the start,
    /// is always made.
    ///
    /// A query that reaches it returns [`Status::IterationLimit`](crate::Status::IterationLimit),
    /// and its interval still contains the true value.
    pub max_iterations: u32,
}

impl Default for MotionSettings {
    fn default() -> Self {
        Self { target_distance: 0.0, tolerance: 1e-6, max_iterations: 200 }
    }
}

/// Answer of [`cast_motion`](crate::cast_motion()): when and where two moving shapes first meet.
///
/// Points and directions are in the common frame of the motions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeOfImpact {
    /// False only if it is certain that the shapes do not meet until time 1.
    pub hit: bool,
    /// How the query ended.
    ///
    /// - [`Separated`](Status::Separated): certainly no hit. All times are infinite.
    /// - [`Overlapping`](Status::Overlapping): the shapes meet at the start, in their poses as
    ///   computed there. All times are 0.
    /// - [`Within`](Status::Within): a hit in the interval. At `t_lower` the shapes are within the
    ///   tolerance of the target distance.
    /// - [`Touching`](Status::Touching): the shapes come as close as rounding error can tell, and
    ///   may graze each other without meeting. If they meet, they do so in the interval.
    /// - [`IterationLimit`](Status::IterationLimit), [`Stalled`](Status::Stalled): it is open
    ///   whether they meet. If they do, it is in the interval.
    pub status: Status,
    /// Time of impact, between 0 and 1; infinite if there is no hit.
    pub t: f64,
    /// Lower bound of the time of impact, with allowance for rounding error. Until then the shapes
    /// certainly are farther apart than the target distance.
    pub t_lower: f64,
    /// Upper bound: at this time the shapes certainly are within the target distance. Infinite if
    /// no such time was found.
    pub t_upper: f64,
    /// Unit vector from A to B at `t_lower`: normal of a plane that separates the shapes then.
    pub normal: DVec3,
    /// Point of A closest to B at `t_lower`.
    pub point_a: DVec3,
    /// Point of B closest to A at `t_lower`.
    pub point_b: DVec3,
    /// Number of distance and contact queries.
    pub iterations: u32,
    /// Number of support calls. One call queries both shapes once.
    pub support_calls: u32,
}

impl Default for TimeOfImpact {
    /// An answer that claims nothing.
    fn default() -> Self {
        Self {
            hit: true,
            status: Status::IterationLimit,
            t: 0.0,
            t_lower: 0.0,
            t_upper: f64::INFINITY,
            normal: DVec3::X,
            point_a: DVec3::ZERO,
            point_b: DVec3::ZERO,
            iterations: 0,
            support_calls: 0,
        }
    }
}

/// When `a`, which moves by `motion_a`, and `b`, which moves by `motion_b`, first meet.
///
/// Motions are in a common frame, over the times 0 to 1. `cache` belongs to this ordered pair; the
/// query reads and updates it.
///
/// # Complexity
/// 2 to 8 distance queries for most pairs, and about four times as many support queries; bounded by
/// `settings`. No allocation.
///
/// # Reference
/// Mirtich 1996 (conservative advancement). docs/intervals.md proves the interval.
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Cuboid;
/// use hullmap::{Cache, MotionSettings, Pose, RigidMotion, Status, cast_motion};
/// use std::f64::consts::FRAC_PI_2;
///
/// // A rod of length 2 turns by 90 degrees, towards a wall whose side is at y = 0.6.
/// let rod = Cuboid::new(DVec3::new(1.0, 0.01, 0.01))?;
/// let wall = Cuboid::new(DVec3::new(5.0, 0.1, 5.0))?;
/// let quarter = DVec3::Z * FRAC_PI_2;
/// let turning = RigidMotion::screw(Pose::IDENTITY, DVec3::ZERO, quarter, DVec3::ZERO)?;
/// let still = RigidMotion::still(Pose::from_translation(DVec3::new(0.0, 0.7, 0.0))?);
/// let settings = MotionSettings::default();
/// let found = cast_motion(&rod, &turning, &wall, &still, &settings, &mut Cache::new());
/// // The corner at (1, 0.01) reaches y = 0.6.
/// let angle = (0.6 / 1.0001_f64.sqrt()).asin() - 0.01_f64.atan();
/// assert_eq!(found.status, Status::Within);
/// assert!((found.t - angle / FRAC_PI_2).abs() < 1e-5 && found.iterations < 20);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn cast_motion<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    motion_a: &RigidMotion,
    b: &B,
    motion_b: &RigidMotion,
    settings: &MotionSettings,
    cache: &mut Cache,
) -> TimeOfImpact {
    // Coordinates relative to A's start have more digits than those of a far place.
    let origin = motion_a.at(0.0).translation();
    let [motion_a, motion_b] = [motion_a, motion_b].map(|motion| motion.relative_to(origin));
    let pair = MovingPair { a: Moving { shape: a, motion: motion_a }, b: Moving { shape: b, motion: motion_b } };
    let mut search = Search {
        noise: pair.noise(),
        target: settings.target_distance.max(0.0),
        enough: settings.tolerance.max(0.0) * (a.outer_radius() + b.outer_radius()),
        found: TimeOfImpact::default(),
        pair,
        cache,
    };
    search.run(settings.max_iterations);
    let mut found = search.found;
    found.point_a += origin;
    found.point_b += origin;
    found
}

struct Search<'s, 'c, A: ?Sized, B: ?Sized> {
    pair: MovingPair<'s, A, B>,
    noise: f64,
    /// The target distance.
    target: f64,
    /// The separation may exceed the target by this length.
    enough: f64,
    /// The answer so far: until `t_lower`, the shapes surely do not meet.
    found: TimeOfImpact,
    cache: &'c mut Cache,
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> Search<'_, '_, A, B> {
    fn run(&mut self, max_iterations: u32) {
        let mut gap = self.distance_at(0.0);
        if self.meet(&gap) {
            (self.found.status, self.found.t_upper) = (Status::Overlapping, 0.0);
            return;
        }
        let mut has_tried = false;
        while self.found.iterations < max_iterations {
            let (t, normal) = (self.found.t_lower, self.found.normal);
            let here = self.pair.separation(normal, t, &mut self.found.support_calls);
            let excess = gap.upper - self.target;
            let is_last = excess <= 4.0 * self.noise;
            // Flat shapes have no depth, so it is never sure that they meet.
            let tries = is_last || (excess <= self.enough + self.noise && !has_tried);
            if tries && self.find_meeting(&here, max_iterations) {
                return self.found.status = Status::Within;
            }
            has_tried |= tries;
            let step = self.pair.step(normal, &here, self.target, &mut self.found.support_calls);
            self.found.t_lower = match step {
                Step::Apart => return self.separated(),
                _ if is_last => return self.end(Status::Touching),
                // The distance query has no good direction.
                Step::Nowhere => return self.end(Status::Stalled),
                Step::To(later) => later,
            };
            gap = self.distance_at(self.found.t_lower);
        }
        self.end(Status::IterationLimit);
    }

    /// Ends the search where it is.
    fn end(&mut self, status: Status) {
        (self.found.status, self.found.t) = (status, self.found.t_lower);
    }

    /// Speed at which the closest points approach each other at time `t`.
    fn speed(&self, t: f64) -> f64 {
        let TimeOfImpact { normal, point_a, point_b, .. } = self.found;
        let MovingPair { a, b } = &self.pair;
        (a.motion.velocity_at(t, point_a) - b.motion.velocity_at(t, point_b)).dot(normal)
    }

    /// The distance of the shapes at time `t`. Its direction and points become those of the answer.
    fn distance_at(&mut self, t: f64) -> Distance {
        let poses = self.pair.poses(t);
        let gap = distance(self.pair.a.shape, self.pair.b.shape, relative(poses), &DIRECTIONS, self.cache);
        let place = |point: DVec3| poses[0].transform_point(point);
        self.found.normal = poses[0].transform_vector(gap.normal);
        (self.found.point_a, self.found.point_b) = (place(gap.point_a), place(gap.point_b));
        self.found.iterations += 1;
        self.found.support_calls += gap.support_calls;
        gap
    }

    /// Whether shapes with this distance surely are within the target distance.
    fn meet(&self, gap: &Distance) -> bool {
        gap.status == Status::Overlapping || gap.upper + self.noise <= self.target
    }

    /// Looks for a time after that of `here` at which the shapes surely meet. Sets the answer and
    /// returns true if there is one.
    fn find_meeting(&mut self, here: &Separation, max_iterations: u32) -> bool {
        let speed = self.speed(here.t);
        // NaN takes the failing branch.
        if !(speed > 0.0) {
            return false;
        }
        let excess = (here.gap - self.target).max(0.0);
        for attempt in ATTEMPTS {
            let later = (here.t + (excess + 4.0 * self.noise) / speed * attempt).min(1.0);
            if self.found.iterations < max_iterations && self.surely_meet_at(later) {
                self.found.t = (here.t + excess / speed).min(later);
                self.found.t_upper = later;
                return true;
            }
            if later == 1.0 {
                return false;
            }
        }
        false
    }

    fn surely_meet_at(&mut self, t: f64) -> bool {
        let [a, b] = self.pair.poses(t);
        let (shape_a, shape_b, b_in_a) = (self.pair.a.shape, self.pair.b.shape, relative([a, b]));
        self.found.iterations += 1;
        if self.target == 0.0 {
            // The poses have rounding errors, too.
            let found = contact(shape_a, shape_b, b_in_a, &DIRECTIONS, self.cache);
            self.found.support_calls += found.support_calls;
            return found.hit && found.depth_lower > self.noise;
        }
        let gap = distance(shape_a, shape_b, b_in_a, &DIRECTIONS, self.cache);
        self.found.support_calls += gap.support_calls;
        self.meet(&gap)
    }

    fn separated(&mut self) {
        let never = f64::INFINITY;
        let TimeOfImpact { iterations, support_calls, normal, .. } = self.found;
        let miss = TimeOfImpact { hit: false, status: Status::Separated, normal, ..TimeOfImpact::default() };
        self.found = TimeOfImpact { t: never, t_lower: never, t_upper: never, iterations, support_calls, ..miss };
    }
}

/// The pose of B in A's frame, from those of both in a common frame, whose lengths are in range.
fn relative([a, b]: [Pose; 2]) -> Pose {
    let back = a.rotation().conjugate();
    Pose::from_parts((back * b.rotation()).normalize(), back * (b.translation() - a.translation()))
}
