//! Queries one pair of hulls, packs or triangle meshes in many poses.

use glam::DVec3;
use hullmap::{Compound, CompoundCache, Contact, Hull, Overlap, Pose, Settings, Status, TriangleMesh, compound};

use crate::args::Mode;

/// Answer of a query. Points and normal are in A's frame; fields that the mode does not compute are
/// `None`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PairAnswer {
    /// Whether the two overlap or touch; `None` if undecided.
    pub hit: Option<bool>,
    pub status: &'static str,
    /// Penetration depth, with lower and upper bound.
    pub depth: Option<[f64; 3]>,
    /// Distance, with lower and upper bound.
    pub distance: Option<[f64; 3]>,
    pub normal: Option<[f64; 3]>,
    pub point_a: Option<[f64; 3]>,
    pub point_b: Option<[f64; 3]>,
    pub iterations: u32,
    /// Pairs of support queries, one on each of the two hulls.
    pub support_calls: u32,
    /// Indices of the hulls or triangles that decide the answer, if a side has several.
    pub hulls: Option<[usize; 2]>,
}

pub trait Side: compound::Parts {
    fn single_hull(&self) -> Option<Hull<'_>>;
    fn has_parts(&self) -> bool;
    fn part_name(&self, index: usize) -> Option<String>;
}

impl Side for Compound<'_> {
    fn single_hull(&self) -> Option<Hull<'_>> {
        if self.hull_count() == 1 { self.hull(0) } else { None }
    }

    fn has_parts(&self) -> bool {
        self.hull_count() > 1
    }

    fn part_name(&self, index: usize) -> Option<String> {
        Some(self.hull(index)?.name().to_owned())
    }
}

impl Side for TriangleMesh {
    fn single_hull(&self) -> Option<Hull<'_>> {
        None
    }

    fn has_parts(&self) -> bool {
        true
    }

    fn part_name(&self, index: usize) -> Option<String> {
        Some(index.to_string())
    }
}

/// The cache carries over from pose to pose.
#[derive(Debug)]
pub struct PairSolver<'a, A, B> {
    a: &'a A,
    b: &'a B,
    settings: Settings,
    cache: CompoundCache,
}

impl<'a, A: Side, B: Side> PairSolver<'a, A, B> {
    pub fn new(a: &'a A, b: &'a B) -> Self {
        Self { a, b, settings: Settings::default(), cache: CompoundCache::default() }
    }

    /// Answers for one pose of B in A's frame.
    pub fn query(&mut self, b_in_a: Pose, mode: Mode) -> PairAnswer {
        match mode {
            Mode::Intersect => self.intersect(b_in_a),
            Mode::Distance => self.distance(b_in_a),
            Mode::Contact => self.contact(b_in_a),
        }
    }

    fn named(&self, hulls: [usize; 2]) -> Option<[usize; 2]> {
        (self.a.has_parts() || self.b.has_parts()).then_some(hulls)
    }

    fn intersect(&mut self, b_in_a: Pose) -> PairAnswer {
        let found = compound::intersects(self.a, self.b, b_in_a, &mut self.cache);
        let is_hit = found.answer.is_hit();
        PairAnswer {
            hit: (found.answer.status != Overlap::Undecided).then_some(is_hit),
            status: found.answer.status.as_str(),
            iterations: found.answer.iterations,
            support_calls: found.answer.support_calls,
            hulls: self.named(found.hulls).filter(|_| is_hit),
            ..PairAnswer::default()
        }
    }

    fn distance(&mut self, b_in_a: Pose) -> PairAnswer {
        let whole = compound::distance(self.a, self.b, b_in_a, &self.settings, &mut self.cache);
        let found = whole.answer;
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
            hulls: self.named(whole.hulls),
            ..PairAnswer::default()
        }
    }

    fn contact(&mut self, b_in_a: Pose) -> PairAnswer {
        if let (Some(a), Some(b)) = (self.a.single_hull(), self.b.single_hull()) {
            // One hull each: the solver returns a separating axis, which a compound does not.
            let found = hullmap::contact(&a, &b, b_in_a, &self.settings, self.cache.pair([0, 0]));
            return of_contact(&found, None);
        }
        match compound::contact(self.a, self.b, b_in_a, &self.settings, &mut self.cache) {
            Some(whole) => of_contact(&whole.answer, self.named(whole.hulls)),
            None => PairAnswer {
                hit: Some(false),
                status: Status::Separated.as_str(),
                depth: Some([0.0; 3]),
                ..PairAnswer::default()
            },
        }
    }
}

fn of_contact(found: &Contact, hulls: Option<[usize; 2]>) -> PairAnswer {
    // For separated hulls the points are not the nearest ones; --mode distance finds these.
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
        hulls,
        ..PairAnswer::default()
    }
}
