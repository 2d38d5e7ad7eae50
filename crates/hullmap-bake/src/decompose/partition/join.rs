//! Mergers of parts, cheapest first, within the limit, until there are few enough parts.
//!
//! [`halves`](super::halves) merges parts with mirror images by the same loop, [`merge_units`].

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
const FAILURES: usize = 16;

/// A merger is free if it adds at most this share of its volume: parts that are convex together are
/// no tighter apart.
const FREE: f64 = 1e-4;

/// A part, and the body of its mirror image if it stands for that, too.
pub struct Unit {
    /// The part.
    pub part: Part,
    /// The body of its image.
    pub image: Option<Body>,
}

impl Unit {
    /// The number of parts.
    pub fn count(&self) -> usize {
        1 + usize::from(self.image.is_some())
    }

    /// The bodies of its parts.
    pub fn bodies(&self) -> impl Iterator<Item = &Body> {
        std::iter::once(&self.part.piece.body).chain(&self.image)
    }
}

/// Indices of two units, or of one that is merged with its image.
pub type Pair = (usize, usize);

/// The body of a merged pair, and the volume that it adds.
pub struct Merger {
    /// The volume that is added.
    pub cost: f64,
    /// The body.
    pub body: Body,
}

/// Which units are merged, and what becomes of them.
pub trait Rules: Sync {
    /// Pairs that may be merged, while there are `count` parts.
    fn pairs(&self, units: &[Option<Unit>], count: usize) -> Vec<Pair>;

    /// The merger of a pair, if it contains no forbidden point.
    fn merger(&self, units: &[Option<Unit>], pair: Pair, forbidden: &[DVec3]) -> Option<Merger>;

    /// The piece of a merger, with its body.
    fn united(&self, units: &[Option<Unit>], pair: Pair, body: &Body) -> Piece;
}

/// Merges parts while merged parts are within the limit and all parts overlap by at most 5 % of
/// their union's volume, down to `wanted` parts; free mergers go on. Builds one hull for each pair
/// of nearby parts, including merged parts.
pub fn merge(search: &PartitionSearch, parts: Vec<Part>, forbidden: &mut Vec<DVec3>, wanted: usize) -> Vec<Part> {
    if parts.len() > MANY {
        return parts;
    }
    let units = parts.into_iter().map(|part| Unit { part, image: None }).collect();
    merge_units(search, units, forbidden, wanted, search).into_iter().map(|unit| unit.part).collect()
}

/// As [`merge`], by rules.
pub fn merge_units(
    search: &PartitionSearch,
    units: Vec<Unit>,
    forbidden: &mut Vec<DVec3>,
    wanted: usize,
    rules: &impl Rules,
) -> Vec<Unit> {
    let mut count: usize = units.iter().map(Unit::count).sum();
    let mut shared = Overlap::new(units.iter().flat_map(Unit::bodies));
    let mut failures = FAILURES + units.len();
    let mut units: Vec<Option<Unit>> = units.into_iter().map(Some).collect();
    // Each pair is tried once.
    let mut mergers: BTreeMap<Pair, Option<Merger>> = BTreeMap::new();
    while failures > 0 && !search.is_over() {
        let mut new = rules.pairs(&units, count);
        new.retain(|pair| !mergers.contains_key(pair));
        let new: Vec<_> = new.into_par_iter().map(|pair| (pair, rules.merger(&units, pair, forbidden))).collect();
        mergers.extend(new);
        let possible = mergers.iter().filter_map(|(pair, merger)| Some((*pair, merger.as_ref()?.cost)));
        let Some((pair, _)) = possible.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0))) else { break };
        let Some(Some(Merger { cost, body })) = mergers.insert(pair, None) else { break };
        if count <= wanted && !is_free(cost, &body) {
            break;
        }
        let others = units.iter().enumerate().filter(|(k, _)| *k != pair.0 && *k != pair.1);
        let others = others.filter_map(|(_, unit)| unit.as_ref()).flat_map(Unit::bodies);
        let own = merged(&units, pair).into_iter().flat_map(Unit::bodies);
        let Some(after) = shared.after(&own.collect::<Vec<_>>(), &body, others) else { continue };
        let beyond = search.points_beyond(&body);
        if !beyond.is_empty() {
            forbidden.extend(beyond);
            continue;
        }
        let component = units[pair.0].as_ref().map(|unit| unit.part.component).unwrap_or_default();
        match search.shaped(&rules.united(&units, pair, &body)) {
            Ok(part) => {
                let part = Part { component, ..part };
                shared = after;
                let merged = [pair.0, pair.1].map(|i| units[i].take().map_or(0, |unit| unit.count()));
                count = count + 1 - merged.iter().sum::<usize>();
                units.push(Some(Unit { part, image: None }));
                mergers.retain(|(i, j), _| [i, j].iter().all(|k| ![pair.0, pair.1].contains(k)));
            }
            Err(point) => {
                failures -= 1;
                forbidden.extend(point);
            }
        }
    }
    units.into_iter().flatten().collect()
}

/// The units of a pair.
pub fn merged(units: &[Option<Unit>], (i, j): Pair) -> Vec<&Unit> {
    [i, j][..if i == j { 1 } else { 2 }].iter().filter_map(|i| units[*i].as_ref()).collect()
}

/// Whether a merger adds next to no volume to its parts.
fn is_free(cost: f64, body: &Body) -> bool {
    cost <= FREE * body.volume()
}

/// Parts that are near each other are merged.
impl Rules for PartitionSearch<'_> {
    fn pairs(&self, units: &[Option<Unit>], count: usize) -> Vec<Pair> {
        let gap = DVec3::splat(if count <= FEW { f64::INFINITY } else { self.scale.limit });
        let parts: Vec<(usize, &Part)> =
            units.iter().enumerate().filter_map(|(i, unit)| Some((i, &unit.as_ref()?.part))).collect();
        let is_near = |a: &Part, b: &Part| {
            let [own, other] = [&a.piece.body, &b.piece.body];
            a.component == b.component && own.low.cmple(other.high + gap).all() && other.low.cmple(own.high + gap).all()
        };
        let of_last = |j: usize| {
            let (others, b) = (&parts[..j], parts[j]);
            others.iter().filter(move |a| is_near(a.1, b.1)).map(move |a| (a.0, b.0))
        };
        (0..parts.len()).flat_map(of_last).collect()
    }

    fn merger(&self, units: &[Option<Unit>], (i, j): Pair, forbidden: &[DVec3]) -> Option<Merger> {
        if self.is_over() {
            return None;
        }
        let [a, b] = [&units[i].as_ref()?.part.piece.body, &units[j].as_ref()?.part.piece.body];
        let points = Cloud::of_points([a.points.as_slice(), &b.points].concat());
        self.scale.is_free(&points, forbidden).then(|| {
            let body = self.scale.body_of(&points);
            Merger { cost: body.volume() - a.volume() - b.volume(), body }
        })
    }

    fn united(&self, units: &[Option<Unit>], pair: Pair, body: &Body) -> Piece {
        let (mut atoms, mut corners, mut planes) = (Vec::new(), Vec::new(), Vec::new());
        for Unit { part: Part { piece, .. }, .. } in merged(units, pair) {
            atoms.extend(piece.atoms.iter().cloned());
            corners.extend_from_slice(&piece.corners);
            planes.extend_from_slice(&piece.planes);
        }
        planes.retain(|plane: &HalfSpace| body.points.iter().all(|p| plane.height(*p) <= self.scale.tolerance()));
        self.scale.piece(atoms, corners, planes, &[])
    }
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
