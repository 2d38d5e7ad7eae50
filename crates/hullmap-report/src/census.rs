//! Census of query costs over evenly spread directions.

use std::collections::{BTreeMap, HashMap};

use glam::{DVec3, Vec3};
use hullmap_format::IndexKind;
use serde::Serialize;

use crate::index_reader::{IndexReader, Leaf};

/// Maximum directions per hull. Histograms of this many directions agree to one per cent.
const MAX_DIRECTIONS: usize = 40_000;

const MIN_DIRECTIONS: usize = 2_000;

const DIRECTION_BUDGET: usize = 400_000;

/// Cosine and sine of the golden angle, π (3 − √5). Repeated rotation by it needs no sine, whose
/// last digits differ between machines.
const GOLDEN: [f64; 2] = [-0.737_368_878_078_320_1, 0.675_490_294_261_523_8];

#[derive(Clone, Debug, Default, Serialize)]
pub struct Census {
    pub directions: usize,
    /// Pairs of a number of candidates and the number of queries with it.
    pub candidates: Vec<[u64; 2]>,
    /// Pairs of a number of nodes and the number of queries that read it.
    pub nodes: Vec<[u64; 2]>,
    /// Mean number of dot products, including padding lanes.
    pub mean_dots: f64,
}

pub fn mean(histogram: &[[u64; 2]]) -> f64 {
    let queries: u64 = histogram.iter().map(|[_, count]| count).sum();
    let sum: u64 = histogram.iter().map(|[value, count]| value * count).sum();
    sum as f64 / queries as f64
}

pub fn direction_count(hull_count: usize) -> usize {
    (DIRECTION_BUDGET / hull_count.max(1)).clamp(MIN_DIRECTIONS, MAX_DIRECTIONS)
}

/// Evenly spread unit directions: a spiral from pole to pole (the Fibonacci lattice).
pub fn even_directions(count: usize) -> Vec<Vec3> {
    let mut around = [1.0, 0.0];
    let direction = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let [x, y] = around;
        let [cosine, sine] = GOLDEN;
        let turned = [x * cosine - y * sine, x * sine + y * cosine];
        // Normalised again, because rounding errors accumulate.
        let length = (turned[0] * turned[0] + turned[1] * turned[1]).sqrt();
        around = turned.map(|c| c / length);
        let ring = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(ring * around[0], ring * around[1], z).as_vec3()
    };
    (0..count).map(direction).collect()
}

pub fn census(index: &IndexReader, directions: &[Vec3]) -> Census {
    let mut leaves: HashMap<Leaf, u64> = HashMap::new();
    if index.kind == IndexKind::None {
        // All directions have the same leaf.
        leaves.extend(directions.first().map(|dir| (index.leaf(dir.to_array()), directions.len() as u64)));
    } else {
        directions.iter().for_each(|dir| *leaves.entry(index.leaf(dir.to_array())).or_default() += 1);
    }
    let (mut candidates, mut nodes) = (BTreeMap::<u64, u64>::new(), BTreeMap::<u64, u64>::new());
    let mut dots = 0;
    for (leaf, queries) in leaves {
        *candidates.entry(index.candidates(leaf).len() as u64).or_default() += queries;
        *nodes.entry(u64::from(leaf.nodes)).or_default() += queries;
        dots += u64::from(leaf.dots()) * queries;
    }
    let pairs = |histogram: BTreeMap<u64, u64>| histogram.into_iter().map(|(value, count)| [value, count]).collect();
    Census {
        directions: directions.len(),
        candidates: pairs(candidates),
        nodes: pairs(nodes),
        mean_dots: dots as f64 / directions.len().max(1) as f64,
    }
}

#[cfg(test)]
mod tests {
    use hullmap_bake::IndexKind;

    use super::*;
    use crate::test_packs::{KINDS, baked, cloud};

    #[test]
    fn directions_are_even() {
        let directions = even_directions(10_000);
        assert!(directions.iter().all(|dir| (dir.length() - 1.0).abs() < 1e-6));
        assert!(directions.iter().sum::<Vec3>().length() < 5.0);
        for signs in 0..8 {
            let share = directions.iter().filter(|dir| dir.is_negative_bitmask() == signs).count();
            assert!(share.abs_diff(1250) < 25, "{signs}: {share}");
        }
        for axis in Vec3::AXES {
            let share = directions.iter().filter(|dir| dir.dot(axis) > 0.8).count();
            assert!(share.abs_diff(1000) < 25, "{axis}: {share}");
        }
        let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        assert!((golden.cos() - GOLDEN[0]).abs() < 1e-15 && (golden.sin() - GOLDEN[1]).abs() < 1e-15);
    }

    #[test]
    fn a_census_counts_every_query() {
        for kind in KINDS {
            let (pack, contents) = baked(cloud(200), kind);
            let hull = pack.hull(0).unwrap();
            let directions = even_directions(3000);
            let census = census(&contents.indices[0], &directions);
            for histogram in [&census.candidates, &census.nodes] {
                assert_eq!(histogram.iter().map(|[_, count]| count).sum::<u64>(), 3000);
            }
            let dots: u32 = directions.iter().map(|&dir| hull.support_cost(dir).dots).sum();
            assert_eq!(census.mean_dots, f64::from(dots) / 3000.0);
            let nodes: u32 = directions.iter().map(|&dir| hull.support_cost(dir).nodes).sum();
            assert_eq!(mean(&census.nodes), f64::from(nodes) / 3000.0);
            if kind == IndexKind::None {
                assert_eq!(census.candidates, [[hull.vertex_count() as u64, 3000]]);
            }
        }
    }
}
