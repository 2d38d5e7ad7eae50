//! Mergers of parts, cheapest first, within the limit, until there are few enough parts.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::{
    body::Body,
    context::PartitionSearch,
    piece::{Cloud, Piece},
    shape::Part,
};
use crate::{decompose::parameters::OVERLAP, spread::spread};
use hullmap_geometry::planes::HalfSpace;

/// Number of points by which the common volume of two bodies is estimated.
const COMMON_POINTS: usize = 512;

/// Error of an estimated overlap, relative to the volume of the union: it counts as no larger.
const SAME: f64 = 2e-3;

/// Number of parts above which none are merged, since the time grows with its square.
pub const MANY: usize = 512;

/// Number of parts up to which parts that are far from each other are merged, too: across others.
const FEW: usize = 48;

/// Number of mergers that may fail to be proven, in addition to one for each part.
pub const FAILURES: usize = 16;

/// A merger is free if it adds at most this share of its volume: parts that are convex together are
/// no tighter apart.
const FREE: f64 = 1e-4;

struct Merger {
    cost: f64,
    body: Body,
}

/// Merges parts while merged parts are within the limit and all parts overlap by at most 5 % of
/// their union's volume, down to `wanted` parts; free mergers go on. Builds one hull for each pair
/// of nearby parts, including merged parts.
pub fn merge(search: &PartitionSearch, parts: Vec<Part>, forbidden: &mut Vec<DVec3>, wanted: usize) -> Vec<Part> {
    if parts.len() > MANY {
        return parts;
    }
    let mut left: Vec<Option<Part>> = parts.into_iter().map(Some).collect();
    let mut count = left.len();
    let mut shared = Overlap::new(left.iter().flatten().map(|part| &part.piece.body));
    let mut failures = FAILURES + left.len();
    // Each pair is tried once.
    let mut mergers: BTreeMap<(usize, usize), Option<Merger>> = BTreeMap::new();
    while failures > 0 && !search.is_over() {
        let gap = if count <= FEW { f64::INFINITY } else { search.scale.limit };
        let pairs: Vec<(usize, usize)> = near_pairs(&left, gap).filter(|p| !mergers.contains_key(p)).collect();
        let new: Vec<_> = pairs.into_par_iter().map(|pair| (pair, merger(search, &left, pair, forbidden))).collect();
        mergers.extend(new);
        let possible = mergers.iter().filter_map(|(pair, merger)| Some((*pair, merger.as_ref()?.cost)));
        let Some((pair, _)) = possible.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0))) else { break };
        let Some(Some(Merger { cost, body })) = mergers.insert(pair, None) else { break };
        if count <= wanted && !is_free(cost, &body) {
            break;
        }
        let others = left.iter().enumerate().filter(|(k, _)| *k != pair.0 && *k != pair.1);
        let others = others.filter_map(|(_, part)| part.as_ref()).map(|part| &part.piece.body);
        let own = [pair.0, pair.1].into_iter().filter_map(|i| left[i].as_ref()).map(|part| &part.piece.body);
        let Some(after) = shared.after(&own.collect::<Vec<_>>(), &body, others) else { continue };
        let beyond = search.points_beyond(&body);
        if !beyond.is_empty() {
            forbidden.extend(beyond);
            continue;
        }
        let [Some(a), Some(b)] = [pair.0, pair.1].map(|i| left[i].as_ref()) else { continue };
        match search.shaped(&united(search, &a.piece, &b.piece, &body)) {
            Ok(part) => {
                let part = Part { component: a.component, ..part };
                shared = after;
                (left[pair.0], left[pair.1]) = (None, None);
                left.push(Some(part));
                count -= 1;
                mergers.retain(|(i, j), _| [i, j].iter().all(|k| ![pair.0, pair.1].contains(k)));
            }
            Err(point) => {
                failures -= 1;
                forbidden.extend(point);
            }
        }
    }
    left.into_iter().flatten().collect()
}

/// Whether a merger adds next to no volume to its parts.
pub fn is_free(cost: f64, body: &Body) -> bool {
    cost <= FREE * body.volume()
}

fn near_pairs(parts: &[Option<Part>], gap: f64) -> impl Iterator<Item = (usize, usize)> + '_ {
    let gap = DVec3::splat(gap);
    let parts: Vec<(usize, &Part)> =
        parts.iter().enumerate().filter_map(|(i, part)| Some((i, part.as_ref()?))).collect();
    let is_near = move |a: &Part, b: &Part| {
        let [own, other] = [&a.piece.body, &b.piece.body];
        a.component == b.component && own.low.cmple(other.high + gap).all() && other.low.cmple(own.high + gap).all()
    };
    (0..parts.len()).flat_map(move |j| {
        let (others, b) = (parts[..j].to_vec(), parts[j]);
        others.into_iter().filter(move |a| is_near(a.1, b.1)).map(move |a| (a.0, b.0))
    })
}

fn merger(
    search: &PartitionSearch,
    parts: &[Option<Part>],
    (i, j): (usize, usize),
    forbidden: &[DVec3],
) -> Option<Merger> {
    if search.is_over() {
        return None;
    }
    let (a, b) = (&parts[i].as_ref()?.piece.body, &parts[j].as_ref()?.piece.body);
    let points = Cloud::of_points([a.points.as_slice(), &b.points].concat());
    search.scale.is_free(&points, forbidden).then(|| {
        let body = search.scale.body_of(&points);
        Merger { cost: body.volume() - a.volume() - b.volume(), body }
    })
}

fn united(search: &PartitionSearch, a: &Piece, b: &Piece, body: &Body) -> Piece {
    let holds = |plane: &&HalfSpace| body.points.iter().all(|p| plane.height(*p) <= search.scale.tolerance());
    let planes = a.planes.iter().chain(&b.planes).filter(holds).copied().collect();
    let corners = [a.corners.as_slice(), &b.corners].concat();
    search.scale.piece([a.atoms.as_slice(), &b.atoms].concat(), corners, planes, &[])
}

/// How much bodies overlap. The sum of what pairs have in common is at least the sum of all volumes
/// less the volume of the union.
#[derive(Clone, Copy, Debug)]
pub struct Overlap {
    volume: f64,
    common: f64,
}

impl Overlap {
    /// The overlap of bodies.
    pub fn new<'a>(bodies: impl Iterator<Item = &'a Body>) -> Self {
        let bodies: Vec<&Body> = bodies.collect();
        let with_earlier = |j: usize| bodies[..j].iter().map(|a| common_volume(a, bodies[j])).sum::<f64>();
        let common = (0..bodies.len()).into_par_iter().map(with_earlier).collect::<Vec<f64>>().into_iter().sum();
        Self { volume: bodies.iter().map(|body| body.volume()).sum(), common }
    }

    /// The overlap after `own` bodies become `merged`; `None` if it grows beyond what is allowed.
    pub fn after<'a>(&self, own: &[&Body], merged: &Body, others: impl Iterator<Item = &'a Body>) -> Option<Self> {
        let mut after = *self;
        for (i, body) in own.iter().enumerate() {
            after.volume -= body.volume();
            after.common -= own[..i].iter().map(|other| common_volume(other, body)).sum::<f64>();
        }
        after.volume += merged.volume();
        for other in others {
            after.common += common_volume(merged, other);
            after.common -= own.iter().map(|body| common_volume(body, other)).sum::<f64>();
        }
        // Sums and differences of estimates.
        after.common = after.common.max(0.0);
        let union = (after.volume - after.common).max(0.0);
        (after.common <= OVERLAP * union || after.common <= self.common + SAME * union).then_some(after)
    }
}

fn common_volume(a: &Body, b: &Body) -> f64 {
    let (low, high) = (a.low.max(b.low), a.high.min(b.high));
    let size = high - low;
    if size.min_element() <= 0.0 {
        return 0.0;
    }
    let points = (0..COMMON_POINTS).map(|k| low + size * DVec3::from_array(spread(k)));
    let share = points.filter(|p| a.holds(*p, 0.0) && b.holds(*p, 0.0)).count() as f64 / COMMON_POINTS as f64;
    share * size.x * size.y * size.z
}
