//! Queries one pair of hulls or baked files in many poses.

use glam::DVec3;
use hullmap::geometry::{Geometry, Visitor};
use hullmap::{Asset, Cache, Contact, Distance, Hull, Intersection, Overlap, Pose, Settings, Status};

use serde::Serialize;

use crate::args::Mode;

/// Answer of a query, by the names of JSON. Points and normal are in A's frame; fields that the
/// mode does not compute are `None`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PairAnswer {
    /// Whether the two overlap or touch; `None` if undecided.
    pub hit: Option<bool>,
    pub status: &'static str,
    pub depth: Option<f64>,
    pub depth_lower: Option<f64>,
    pub depth_upper: Option<f64>,
    pub distance: Option<f64>,
    pub distance_lower: Option<f64>,
    pub distance_upper: Option<f64>,
    pub normal: Option<[f64; 3]>,
    pub point_a: Option<[f64; 3]>,
    pub point_b: Option<[f64; 3]>,
    pub iterations: u32,
    /// Pairs of support queries, one on each of the two hulls.
    pub support_calls: u32,
    /// Indices of the hulls or triangles that decide the answer.
    #[serde(skip)]
    pub parts: Option<[u32; 2]>,
}

/// One side of a query.
#[derive(Debug)]
pub enum Side<'a> {
    /// A hull.
    Hull(Box<Hull<'a>>),
    /// All that a file holds.
    Asset(&'a Asset),
}

impl Side<'_> {
    /// Whether it has several parts.
    pub fn has_parts(&self) -> bool {
        !matches!(self, Self::Hull(_))
    }

    /// Name of a part: of a hull its own, of a triangle its index.
    pub fn part_name(&self, index: u32) -> Option<String> {
        match self {
            Self::Hull(hull) => Some(hull.name().to_owned()),
            Self::Asset(Asset::Pack(pack)) => Some(pack.hull(index as usize).ok()?.name().to_owned()),
            Self::Asset(_) => Some(index.to_string()),
        }
    }
}

impl Geometry for Side<'_> {
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        match self {
            Self::Hull(hull) => hull.visit(visitor),
            Self::Asset(asset) => asset.visit(visitor),
        }
    }
}

/// The cache carries over from pose to pose.
#[derive(Debug)]
pub struct PairSolver<'a> {
    sides: [&'a Side<'a>; 2],
    settings: Settings,
    cache: Cache,
}

impl<'a> PairSolver<'a> {
    /// A solver with an empty cache.
    pub fn new(a: &'a Side<'a>, b: &'a Side<'a>) -> Self {
        Self { sides: [a, b], settings: Settings::default(), cache: Cache::new() }
    }

    /// Answers for one pose of B in A's frame.
    pub fn query(&mut self, b_in_a: Pose, mode: Mode) -> PairAnswer {
        let Self { sides: [a, b], settings, cache } = self;
        match mode {
            Mode::Intersect => of_intersection(&hullmap::intersects(*a, *b, b_in_a, cache)),
            Mode::Distance => of_distance(&hullmap::distance(*a, *b, b_in_a, settings, cache)),
            Mode::Contact => of_contact(&hullmap::contact(*a, *b, b_in_a, settings, cache)),
        }
    }
}

fn of_intersection(found: &Intersection) -> PairAnswer {
    PairAnswer {
        hit: (found.status != Overlap::Undecided).then_some(found.is_hit()),
        status: found.status.as_str(),
        iterations: found.iterations,
        support_calls: found.support_calls,
        parts: found.is_hit().then_some(found.parts),
        ..PairAnswer::default()
    }
}

fn of_distance(found: &Distance) -> PairAnswer {
    let hit = match found.status {
        Status::Overlapping | Status::Touching => Some(true),
        _ if found.lower > 0.0 => Some(false),
        _ => None,
    };
    PairAnswer {
        hit,
        status: found.status.as_str(),
        distance: Some(found.distance),
        distance_lower: Some(found.lower),
        distance_upper: Some(found.upper),
        normal: Some(found.normal.to_array()),
        point_a: Some(found.point_a.to_array()),
        point_b: Some(found.point_b.to_array()),
        iterations: found.iterations,
        support_calls: found.support_calls,
        parts: Some(found.parts),
        ..PairAnswer::default()
    }
}

fn of_contact(found: &Contact) -> PairAnswer {
    // For separated hulls the points are not the nearest ones; --mode distance finds these.
    let if_hit = |point: DVec3| found.hit.then_some(point.to_array());
    PairAnswer {
        hit: Some(found.hit),
        status: found.status.as_str(),
        depth: Some(found.depth),
        depth_lower: Some(found.depth_lower),
        depth_upper: Some(found.depth_upper),
        // Separated parts have no common separating axis.
        normal: Some(found.normal.to_array()).filter(|_| !found.normal.is_nan()),
        point_a: if_hit(found.point_a),
        point_b: if_hit(found.point_b),
        iterations: found.iterations,
        support_calls: found.support_calls,
        parts: found.hit.then_some(found.parts),
        ..PairAnswer::default()
    }
}
