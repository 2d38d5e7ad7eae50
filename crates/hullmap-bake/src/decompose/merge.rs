//! Convex parts that are better one part: V-HACD cuts by halves, and its number of parts is what it aims at, not what it keeps to.
//!
//! # Steps
//! 1. The cost of a merger is the volume that the hull of two parts has beyond the parts that V-HACD made of it.
//! 2. The cheapest merger is made, and what it costs to merge its outcome is computed; again, as long as a merger costs next to nothing,
//!    or there are too many parts.
//!
//! Parts whose boxes are apart are merged only where no others are left and there are too many.
//!
//! # Reference
//! Mamou's V-HACD 2 merges likewise, down to its number of parts; parry3d's does not.

use glam::DVec3;
use rayon::prelude::*;

use crate::{
    BakeError, PointSet,
    hull::{self, Hull},
    mass,
};

/// Boxes that are nearer to each other than this share of the whole touch: the grid that clipped points stand on is finer.
const TOUCHING: f64 = 1e-5;

/// When to merge.
#[derive(Clone, Copy, Debug)]
pub struct Until {
    /// Volume that a part may gain by mergers that nothing else asks for.
    pub free: f64,
    /// Most parts that may be left, at least 1.
    pub max_parts: usize,
    /// Size of the whole.
    pub size: f64,
}

/// A part, by its extreme points.
struct Part {
    hull: Hull,
    bounds: [DVec3; 2],
    /// Volume of what V-HACD made of it.
    own: f64,
    /// Numbers of the parts it was.
    members: Vec<usize>,
}

impl Part {
    fn new(points: &PointSet, own: Option<f64>, members: Vec<usize>) -> Result<Self, BakeError> {
        let hull = hull::build(points)?;
        let positions = hull.positions();
        let bounds = [
            positions.iter().copied().fold(DVec3::INFINITY, DVec3::min),
            positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max),
        ];
        let own = own.unwrap_or_else(|| volume(&hull));
        Ok(Self { hull, bounds, own, members })
    }

    /// Both as one.
    fn with(&self, other: &Self) -> Result<Self, BakeError> {
        let positions: Vec<[f32; 3]> = self.hull.vertices.iter().chain(&other.hull.vertices).copied().collect();
        let source_vertices = (0..positions.len() as u32).collect();
        let points = PointSet { positions, source_vertices, ..PointSet::default() };
        let members = self.members.iter().chain(&other.members).copied().collect();
        Self::new(&points, Some(self.own + other.own), members)
    }

    fn touches(&self, other: &Self, margin: f64) -> bool {
        let [low, high] = [self.bounds[0].max(other.bounds[0]), self.bounds[1].min(other.bounds[1])];
        (high - low).min_element() >= -margin
    }
}

fn volume(hull: &Hull) -> f64 {
    if hull.rank == 3 { mass::mass(hull).volume } else { 0.0 }
}

/// A merger of two parts by their numbers, and what it costs. The outcome is made again when it is wanted: there may be half a million.
#[derive(Clone, Copy)]
struct Merger {
    cost: f64,
    pair: [usize; 2],
}

/// Which of `parts` are one part: lists of their numbers, ascending, by the first of each.
///
/// # Errors
/// Points that no hull can be made of.
///
/// # Complexity
/// A hull for each two parts that touch, and for each two that a merger makes touch; all pairs where more than `max_parts` are apart.
pub fn merge(parts: &[PointSet], until: Until) -> Result<Vec<Vec<usize>>, BakeError> {
    let first: Result<Vec<Part>, BakeError> =
        parts.par_iter().enumerate().map(|(number, points)| Part::new(points, None, vec![number])).collect();
    let mut alive: Vec<Option<Part>> = first?.into_iter().map(Some).collect();
    let mut count = alive.len();
    let mut margin = TOUCHING * until.size;
    let mut mergers = mergers_of(&alive, &all_pairs(alive.len()), margin)?;
    loop {
        // Of mergers that cost the same, the first: the order does not depend on threads.
        let by_cost = |a: &&Merger, b: &&Merger| a.cost.total_cmp(&b.cost).then(a.pair.cmp(&b.pair));
        let Some(&Merger { cost, pair: [kept, gone] }) = mergers.iter().min_by(by_cost) else {
            if count <= until.max_parts || margin == f64::INFINITY {
                break;
            }
            margin = f64::INFINITY;
            mergers = mergers_of(&alive, &all_pairs(alive.len()), margin)?;
            continue;
        };
        if count <= until.max_parts && !(cost <= until.free) {
            break;
        }
        let [Some(a), Some(b)] = [&alive[kept], &alive[gone]] else {
            unreachable!("mergers are of parts that are there")
        };
        alive[kept] = Some(a.with(b)?);
        alive[gone] = None;
        count -= 1;
        mergers.retain(|merger| !merger.pair.iter().any(|part| [kept, gone].contains(part)));
        let pairs: Vec<[usize; 2]> =
            (0..alive.len()).filter(|&i| i != kept).map(|i| [i.min(kept), i.max(kept)]).collect();
        mergers.extend(mergers_of(&alive, &pairs, margin)?);
    }
    Ok(alive
        .into_iter()
        .flatten()
        .map(|mut part| {
            part.members.sort_unstable();
            part.members
        })
        .collect())
}

fn all_pairs(count: usize) -> Vec<[usize; 2]> {
    (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b])).collect()
}

/// The mergers of those of `pairs` whose parts are there and touch.
fn mergers_of(alive: &[Option<Part>], pairs: &[[usize; 2]], margin: f64) -> Result<Vec<Merger>, BakeError> {
    let merger = |&pair: &[usize; 2]| {
        let [Some(a), Some(b)] = pair.map(|part| alive[part].as_ref()) else { return None };
        a.touches(b, margin).then(|| {
            let outcome = a.with(b)?;
            Ok(Merger { cost: volume(&outcome.hull) - outcome.own, pair })
        })
    };
    pairs.par_iter().filter_map(merger).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of points by its corners.
    fn block(low: [f32; 3], high: [f32; 3]) -> PointSet {
        let corner = |i: usize| std::array::from_fn(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] });
        PointSet { positions: (0..8).map(corner).collect(), source_vertices: (0..8).collect(), ..PointSet::default() }
    }

    /// A row of blocks, one across its end, and one far away.
    fn blocks() -> Vec<PointSet> {
        vec![
            block([0.0; 3], [1.0; 3]),
            block([5.0; 3], [6.0; 3]),
            block([2.0, 0.0, 0.0], [3.0, 1.0, 1.0]),
            block([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]),
            block([2.0, 1.0, 0.0], [3.0, 3.0, 1.0]),
        ]
    }

    fn merged(free: f64, max_parts: usize) -> Vec<Vec<usize>> {
        merge(&blocks(), Until { free, max_parts, size: 6.0 }).unwrap()
    }

    #[test]
    fn what_is_convex_together_is_one_part() {
        assert_eq!(merged(1e-9, 100), [vec![0, 2, 3], vec![1], vec![4]]);
        // Negative: nothing is free.
        assert_eq!(merged(-1.0, 100).len(), 5);
    }

    /// The block across costs 2 with the row (an L's hull has 7 where it has 5); the one far away costs more with anything.
    #[test]
    fn the_number_of_parts_is_kept_to() {
        assert_eq!(merged(0.0, 2), [vec![0, 2, 3, 4], vec![1]]);
        assert_eq!(merged(0.0, 1), [vec![0, 1, 2, 3, 4]]);
        assert_eq!(merged(2.5, 100), [vec![0, 2, 3, 4], vec![1]]);
        for max_parts in 1..5 {
            assert!(merged(-1.0, max_parts).len() <= max_parts);
        }
    }
}
