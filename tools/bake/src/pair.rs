//! One pair of hulls in pose after pose: the solver's answers in the words of the command's JSON.

use glam::DVec3;
use hullmap::{Cache, Hull, Overlap, Pose, Settings, Status};

use crate::args::Mode;

/// Answer of a query between two hulls; points and normal in A's frame. `None` where the mode does not compute it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PairAnswer {
    /// Whether they overlap or touch; `None` where that was not decided.
    pub hit: Option<bool>,
    /// How the solver ended, in one word.
    pub status: &'static str,
    /// Depth and its bounds.
    pub depth: Option<[f64; 3]>,
    /// Distance and its bounds.
    pub distance: Option<[f64; 3]>,
    /// Of unit length, from A to B.
    pub normal: Option<[f64; 3]>,
    /// On A.
    pub point_a: Option<[f64; 3]>,
    /// On B.
    pub point_b: Option<[f64; 3]>,
    /// Iterations of the solver.
    pub iterations: u32,
    /// Pairs of support queries, one on each of the two hulls.
    pub support_calls: u32,
}

/// A solver for one pair of hulls, with the cache that carries over from pose to pose.
#[derive(Debug)]
pub struct PairSolver<'a> {
    a: Hull<'a>,
    b: Hull<'a>,
    settings: Settings,
    cache: Cache,
}

impl<'a> PairSolver<'a> {
    /// A solver with an empty cache.
    pub fn new(a: Hull<'a>, b: Hull<'a>) -> Self {
        Self { a, b, settings: Settings::default(), cache: Cache::default() }
    }

    /// Answers for one pose of B in A's frame.
    pub fn query(&mut self, b_in_a: Pose, mode: Mode) -> PairAnswer {
        match mode {
            Mode::Intersect => self.intersect(b_in_a),
            Mode::Distance => self.distance(b_in_a),
            Mode::Contact => self.contact(b_in_a),
        }
    }

    fn intersect(&mut self, b_in_a: Pose) -> PairAnswer {
        let found = hullmap::intersects(&self.a, &self.b, b_in_a, &mut self.cache);
        PairAnswer {
            hit: (found.status != Overlap::Undecided).then_some(found.is_hit()),
            status: found.status.as_str(),
            iterations: found.iterations,
            support_calls: found.support_calls,
            ..PairAnswer::default()
        }
    }

    fn distance(&mut self, b_in_a: Pose) -> PairAnswer {
        let found = hullmap::distance(&self.a, &self.b, b_in_a, &self.settings, &mut self.cache);
        let hit = match found.status {
            Status::Overlapping | Status::Touching => Some(true),
            _ if found.lower > 0.0 => Some(false),
            _ => None,
        };
        PairAnswer {
            hit,
            status: found.status.as_str(),
            distance: Some([found.distance, found.lower, found.upper]),
            normal: Some(found.normal.to_array()),
            point_a: Some(found.point_a.to_array()),
            point_b: Some(found.point_b.to_array()),
            iterations: found.iterations,
            support_calls: found.support_calls,
            ..PairAnswer::default()
        }
    }

    fn contact(&mut self, b_in_a: Pose) -> PairAnswer {
        let found = hullmap::contact(&self.a, &self.b, b_in_a, &self.settings, &mut self.cache);
        // Apart, the points are not the nearest ones: --mode distance tells those.
        let if_hit = |point: DVec3| found.hit.then_some(point.to_array());
        PairAnswer {
            hit: Some(found.hit),
            status: found.status.as_str(),
            depth: Some([found.depth, found.depth_lower, found.depth_upper]),
            normal: Some(found.normal.to_array()),
            point_a: if_hit(found.point_a),
            point_b: if_hit(found.point_b),
            iterations: found.iterations,
            support_calls: found.support_calls,
            ..PairAnswer::default()
        }
    }
}
