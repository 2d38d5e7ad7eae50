//! Merging of convex parts, where a cover has more than the maximum number.
//!
//! # Steps
//! 1. Compute the cost of each merger: the volume of the merged hull minus the volume of the
//!    original parts in it.
//! 2. Make the cheapest merger, and compute the costs of merging its result with the other parts.
//! 3. Repeat while there are too many parts.
//!
//! Parts with separated boxes are merged only if no others are left to merge.

use glam::DVec3;
use rayon::prelude::*;

use super::partition::{Part as Found, body, piece::Scale, wrap};
use crate::{
    BakeError, PointSet,
    fit::{Accuracy, protrusion, solid::Solid},
    hull::{self, Hull},
    mass,
};

/// Maximum gap between boxes that counts as touching, relative to the diagonal of the mesh.
const TOUCHING: f64 = 1e-5;

/// Number of parts above which neighbours are joined before the best mergers are sought.
const MANY_PARTS: usize = 256;

/// A part, as the hull of its points.
struct Part {
    hull: Hull,
    bounds: [DVec3; 2],
    /// Total volume of the original parts in it.
    own: f64,
    /// Indices of the original parts in it.
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

    /// The merged part.
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

/// A merger of two parts, by their indices, and its cost. The merged hull is not stored but
/// computed again when needed, because there may be half a million mergers.
#[derive(Clone, Copy)]
struct Merger {
    cost: f64,
    pair: [usize; 2],
}

/// Groups the parts to be merged, in at most `max_parts` groups, which must be one or more. Each
/// group is an ascending list of part indices, and the groups are ordered by their first index.
/// `diagonal` is the diagonal of the whole mesh.
///
/// # Errors
/// The errors of [`hull::build`].
///
/// # Complexity
/// One hull per pair of touching parts, including merged parts. If no touching parts are left and
/// there are still more than `max_parts`, one hull per pair.
fn merge(parts: &[PointSet], max_parts: usize, diagonal: f64) -> Result<Vec<Vec<usize>>, BakeError> {
    let first: Result<Vec<Part>, BakeError> =
        parts.par_iter().enumerate().map(|(index, points)| Part::new(points, None, vec![index])).collect();
    let mut alive: Vec<Option<Part>> = first?.into_iter().map(Some).collect();
    let mut count = alive.len();
    let mut margin = TOUCHING * diagonal;
    let mut mergers = mergers_of(&alive, &all_pairs(alive.len()), margin)?;
    while count > max_parts {
        // Of mergers with equal cost, take the first, so that the order does not depend on threads.
        let by_cost = |a: &&Merger, b: &&Merger| a.cost.total_cmp(&b.cost).then(a.pair.cmp(&b.pair));
        let Some(&Merger { pair: [kept, gone], .. }) = mergers.iter().min_by(by_cost) else {
            if margin == f64::INFINITY {
                break;
            }
            margin = f64::INFINITY;
            mergers = mergers_of(&alive, &all_pairs(alive.len()), margin)?;
            continue;
        };
        let [Some(a), Some(b)] = [&alive[kept], &alive[gone]] else { unreachable!("mergers refer to existing parts") };
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

/// The mergers of those `pairs` whose parts still exist and touch.
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

/// Groups of `parts`, at most `max_parts`, each with its hull. Groups grow by the mergers that add
/// the least volume.
pub fn merged(
    parts: Vec<Found>,
    solid: &Solid,
    max_parts: usize,
    max_vertices: usize,
) -> Result<Vec<Found>, BakeError> {
    let mut sets: Vec<(PointSet, Vec<usize>)> =
        parts.iter().enumerate().map(|(index, part)| (points_of(&part.hull.vertices), vec![index])).collect();
    if sets.len() > MANY_PARTS.max(max_parts) {
        sets = clustered(sets, MANY_PARTS.max(max_parts));
    }
    let points: Vec<PointSet> = sets.iter().map(|(set, _)| set.clone()).collect();
    let groups = merge(&points, max_parts, solid.diagonal())?;
    let diagonal = solid.diagonal();
    let part_of = |group: &Vec<usize>| -> Result<Found, BakeError> {
        let points: Vec<[f32; 3]> = group.iter().flat_map(|set| sets[*set].0.positions.iter().copied()).collect();
        let hull = wrap::within_vertices(hull::build(&points_of(&points))?, max_vertices);
        let bound = protrusion(solid, &hull, &Accuracy::tight(diagonal)).bound;
        let members = group.iter().flat_map(|set| &sets[*set].1);
        let atoms = members.flat_map(|part| parts[*part].piece.atoms.iter().cloned()).collect();
        let piece = Scale { limit: bound, diagonal }.piece(atoms, Vec::new(), &[]);
        Ok(Found { piece, hull, bound })
    };
    groups.par_iter().map(part_of).collect()
}

fn points_of(positions: &[[f32; 3]]) -> PointSet {
    let source_vertices = (0..positions.len() as u32).collect();
    PointSet { positions: positions.to_vec(), source_vertices, ..PointSet::default() }
}

/// Sets of points joined to at most `count` sets: the largest group is halved along the longest
/// side of its box, until there are that many groups.
fn clustered(sets: Vec<(PointSet, Vec<usize>)>, count: usize) -> Vec<(PointSet, Vec<usize>)> {
    let centres: Vec<DVec3> = sets
        .iter()
        .map(|(set, _)| {
            set.positions.iter().map(|p| DVec3::from_array(p.map(f64::from))).sum::<DVec3>()
                / set.positions.len() as f64
        })
        .collect();
    let mut groups: Vec<Vec<usize>> = vec![(0..sets.len()).collect()];
    while groups.len() < count {
        let Some(largest) = (0..groups.len()).max_by_key(|group| (groups[*group].len(), usize::MAX - group)) else {
            break;
        };
        let mut group = groups.swap_remove(largest);
        let (low, high) = body::bounds(&group.iter().map(|set| centres[*set]).collect::<Vec<_>>());
        let axis = body::longest(high - low);
        group.sort_by(|a, b| centres[*a][axis].total_cmp(&centres[*b][axis]).then(a.cmp(b)));
        let second = group.split_off(group.len() / 2);
        groups.extend([group, second]);
    }
    groups
        .iter()
        .filter(|group| !group.is_empty())
        .map(|group| {
            let points: Vec<[f32; 3]> = group.iter().flat_map(|set| sets[*set].0.positions.iter().copied()).collect();
            (points_of(&points), group.iter().flat_map(|set| sets[*set].1.iter().copied()).collect())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corners of a box.
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

    fn merged(max_parts: usize) -> Vec<Vec<usize>> {
        merge(&blocks(), max_parts, 6.0).unwrap()
    }

    #[test]
    fn parts_with_a_convex_union_are_merged_first() {
        assert_eq!(merged(5).len(), 5);
        assert_eq!(merged(3), [vec![0, 2, 3], vec![1], vec![4]]);
    }

    /// Merging the block across with the row costs 2 (the hull of the L has volume 7, its parts 5).
    /// Merging the distant block costs more.
    #[test]
    fn distant_parts_are_merged_last() {
        assert_eq!(merged(2), [vec![0, 2, 3, 4], vec![1]]);
        assert_eq!(merged(1), [vec![0, 1, 2, 3, 4]]);
    }
}
