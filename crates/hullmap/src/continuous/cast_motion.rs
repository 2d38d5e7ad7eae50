//! Time of impact of two shapes that move and turn (continuous collision detection).

use super::advance::{Approach, Moving};
use super::rigid_motion::RigidMotion;
use super::search::{DIRECTIONS, Goal, ImpactSearch, Queries};
use super::time_of_impact::TimeOfImpact;
use crate::pose::Pose;
use crate::solver::queries::{contact, distance, overlap_by_simplex};
use crate::solver::{Cache, Contact, Distance, Settings};
use crate::support::SupportMap;

/// Limits and accuracy of [`cast_motion`](crate::cast_motion()).
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
    /// Maximum number of distance and contact queries for each turn of 360 degrees. The default is
    /// 200. Turns of both shapes are added and rounded up: less than a turn counts as one, and more
    /// than [`MAX_TURNS`](Self::MAX_TURNS) as that many. One query, at the start, is always made.
    ///
    /// A query that reaches it returns [`Status::IterationLimit`](crate::Status::IterationLimit),
    /// and its interval still contains the true value. All pairs of parts share it, so compounds on
    /// triangles may need 1,000 or more.
    pub max_iterations: u32,
}

impl Default for MotionSettings {
    fn default() -> Self {
        Self { target_distance: 0.0, tolerance: 1e-6, max_iterations: 200 }
    }
}

/// [`cast_motion`](crate::cast_motion()) of two convex shapes.
pub(crate) fn cast_motion<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    motions: [&RigidMotion; 2],
    settings: &MotionSettings,
    cache: &mut Cache,
) -> TimeOfImpact {
    // Coordinates relative to A's start have more digits than coordinates far from the origin.
    let origin = motions[0].start();
    let motions = motions.map(|motion| motion.relative_to(origin));
    let mut goal = settings.goal(motions);
    search_pair((a, b), motions, &DIRECTIONS, settings.tolerance, &mut goal, [0.0, 1.0], cache).relative_to(origin)
}

impl MotionSettings {
    /// The limit of queries grows up to this number of turns.
    pub const MAX_TURNS: u32 = 100;

    pub(crate) fn goal(&self, motions: [RigidMotion; 2]) -> Goal {
        let angle: f64 = motions.iter().map(RigidMotion::angle).sum();
        let turns = (angle / std::f64::consts::TAU).ceil().clamp(1.0, f64::from(Self::MAX_TURNS));
        Goal::meeting(self.target_distance, self.max_iterations.saturating_mul(turns as u32))
    }
}

/// The search of a pair of shapes in a `window` of time. Coordinates are relative to A's start.
pub(crate) fn search_pair<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    (a, b): (&A, &B),
    [motion_a, motion_b]: [RigidMotion; 2],
    settings: &Settings,
    tolerance: f64,
    goal: &mut Goal,
    window: [f64; 2],
    cache: &mut Cache,
) -> TimeOfImpact {
    let moving = (Moving { shape: a, motion: motion_a }, Moving { shape: b, motion: motion_b });
    let pair = Approach::new(moving.0, moving.1, false);
    ImpactSearch::run(pair, ShapeQueries { a, b, settings, cache }, tolerance, goal, window)
}

struct ShapeQueries<'q, A: ?Sized, B: ?Sized> {
    a: &'q A,
    b: &'q B,
    settings: &'q Settings,
    cache: &'q mut Cache,
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> Queries for ShapeQueries<'_, A, B> {
    fn distance(&mut self, b_in_a: Pose) -> Distance {
        distance(self.a, self.b, b_in_a, self.settings, self.cache)
    }

    fn contact(&mut self, b_in_a: Pose) -> Contact {
        contact(self.a, self.b, b_in_a, self.settings, self.cache)
    }

    fn overlap_near(&mut self, b_in_a: Pose, depth: f64) -> bool {
        overlap_by_simplex(self.a, self.b, b_in_a, depth, self.cache)
    }
}
