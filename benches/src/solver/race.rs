//! Interleaved timing of the three queries of both engines.
//!
//! A round runs every query of every engine on every pair of hulls. Engines take turns in an order
//! that changes from round to round, so that a slow spell of the machine affects all of them. The
//! result of a piece of a few queries is the lower quartile over the rounds. In the mixed poses the
//! classes alternate, as a branch predictor meets them in a scene. The figures by class come from
//! separate passes.
//!
//! Everything runs in one thread and from warm memory. *Cold* means that the solver's cache is
//! empty, not the processor's.

use hullmap::{Cache, intersects};
use shapes::rng::SplitMix64;

use super::{
    answers::Differences,
    engines::{self, PairQuery, Samples},
    pairs::{BakedPair, FAMILIES, Mix, Placed},
};
use crate::{subject::SEED, support::shuffled};

/// Measuring effort at one vertex count.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Number of poses of each class and family.
    pub poses: usize,
    /// Number of paths of each class and family.
    pub paths: usize,
    /// Number of poses of a path.
    pub frames: usize,
    /// Number of queries in a timed piece, for hullmap and for parry.
    pub pieces: [usize; 2],
    /// Rounds.
    pub rounds: usize,
}

impl Effort {
    /// The whole table in less than five minutes.
    pub const fn full(n: usize) -> Self {
        match n {
            0..=1_024 => Self { poses: 400, paths: 20, frames: 33, pieces: [24, 24], rounds: 15 },
            1_025..=4_096 => Self { poses: 200, paths: 20, frames: 33, pieces: [24, 4], rounds: 9 },
            4_097..=16_384 => Self { poses: 100, paths: 12, frames: 33, pieces: [12, 1], rounds: 7 },
            _ => Self { poses: 70, paths: 8, frames: 33, pieces: [12, 1], rounds: 7 },
        }
    }

    /// A short table in a few seconds.
    pub const QUICK: Self = Self { poses: 30, paths: 4, frames: 9, pieces: [12, 4], rounds: 3 };
}

/// One query on the poses and paths of one mix.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Kind of the query.
    pub query: PairQuery,
    /// Selection of poses, and of paths.
    pub mix: Mix,
    /// Nanoseconds per query: hullmap and parry on the poses; hullmap along the paths with empty
    /// caches, and with a cache for each path.
    pub ns: [f64; 4],
    /// Work of hullmap on the poses.
    pub cold: Work,
    /// Work along the paths with empty caches, and with a cache for each path.
    pub paths: [Work; 2],
}

/// Work of hullmap's queries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Mean number of pairs of support queries.
    pub support_calls: f64,
    /// Maximum number of pairs of support queries.
    pub max_support_calls: u32,
    /// Mean number of steps.
    pub iterations: f64,
}

/// Measurements at one vertex count.
#[derive(Clone, Debug)]
pub struct Record {
    /// Points of a hull.
    pub n: usize,
    /// Mean number of vertices of a hull.
    pub vertices: f64,
    /// Families that parry rejected.
    pub rejected: Vec<&'static str>,
    /// Fraction of the poses on paths that overlap.
    pub path_hit_share: f64,
    /// One for each query and mix.
    pub cells: Vec<Cell>,
    /// Comparison of the answers.
    pub differences: Differences,
}

/// A pair of hulls, and the poses and paths of a mix.
struct Stage<'s> {
    pair: &'s BakedPair,
    poses: Vec<Placed>,
    frames: Vec<Placed>,
    effort: Effort,
    /// In the order of [`Cell::ns`].
    samples: [Samples; 4],
}

impl<'s> Stage<'s> {
    fn new(pair: &'s BakedPair, mix: Mix, effort: Effort) -> Self {
        let mut rng = SplitMix64::new(SEED);
        let poses = mix.select(&pair.poses(effort.poses, &mut rng));
        let frames = mix.select(&pair.frames(effort.paths, effort.frames, &mut rng));
        let [hullmap, parry] = effort.pieces;
        let samples = [(&poses, hullmap), (&poses, parry), (&frames, hullmap), (&frames, hullmap)]
            .map(|(items, piece)| Samples::new(items.len(), piece));
        Self { pair, samples, poses, frames, effort }
    }

    /// Times each engine once.
    fn round(&mut self, query: PairQuery, rng: &mut SplitMix64) {
        let (hulls, polyhedra) = (&self.pair.hulls(), self.pair.polyhedra());
        let cold = |placed: &Placed| _ = engines::hullmap(query, hulls, placed, &mut Cache::default());
        for engine in shuffled(self.samples.len(), rng) {
            let samples = &mut self.samples[engine];
            match engine {
                0 => samples.round(&self.poses, cold),
                1 => samples.round(&self.poses, |placed| engines::parrys(query, polyhedra, placed)),
                2 => samples.round(&self.frames, cold),
                _ => {
                    let mut caches = vec![Cache::default(); self.frames.len() / self.effort.frames];
                    let mut path = 0;
                    samples.round(&self.frames, |placed| {
                        engines::hullmap(query, hulls, placed, &mut caches[path]);
                        path = if path + 1 == caches.len() { 0 } else { path + 1 };
                    });
                }
            }
        }
    }
}

/// Measures one vertex count. Panics if parry rejects the hulls of every family.
pub fn run(n: usize, effort: Effort) -> Record {
    let baked = FAMILIES.map(|family| (family, BakedPair::bake(family, n, SEED)));
    let pairs: Vec<&BakedPair> = baked.iter().filter_map(|(_, pair)| pair.as_ref()).collect();
    assert!(!pairs.is_empty(), "parry rejects all hulls of {n} points");
    let cells = PairQuery::ALL.into_iter().flat_map(|query| Mix::ALL.map(|mix| (query, mix)));
    let mut heats: Vec<(PairQuery, Mix, Vec<Stage<'_>>)> = cells
        .map(|(query, mix)| (query, mix, pairs.iter().map(|pair| Stage::new(pair, mix, effort)).collect()))
        .collect();
    let mut rng = SplitMix64::new(!SEED);
    for _ in 0..effort.rounds {
        for (query, _, stages) in &mut heats {
            stages.iter_mut().for_each(|stage| stage.round(*query, &mut rng));
        }
    }
    let all = &heats[0].2;
    let mut differences = Differences::default();
    all.iter().for_each(|stage| differences.add(stage.pair, &stage.poses));
    let (mut hits, mut frames) = (0, 0);
    for stage in all {
        let [a, b] = &stage.pair.hulls();
        let hit = |placed: &&Placed| intersects(a, b, placed.b_in_a, &mut Cache::default()).is_hit();
        hits += stage.frames.iter().filter(hit).count();
        frames += stage.frames.len();
    }
    Record {
        n,
        vertices: all.iter().flat_map(|stage| stage.pair.hulls()).map(|hull| hull.vertex_count() as f64).sum::<f64>()
            / (2 * all.len()) as f64,
        rejected: baked.iter().filter(|(_, pair)| pair.is_none()).map(|(family, _)| family.name()).collect(),
        path_hit_share: hits as f64 / frames as f64,
        cells: heats.iter().map(|(query, mix, stages)| cell(*query, *mix, stages)).collect(),
        differences,
    }
}

/// Sums over the families, which all have the same number of poses, and so the same weight.
fn cell(query: PairQuery, mix: Mix, stages: &[Stage<'_>]) -> Cell {
    let ns = std::array::from_fn(|engine| {
        let samples = stages.iter().map(|stage| &stage.samples[engine]);
        let (total, queries) = samples.fold((0.0, 0), |(t, q), s| (t + s.total_ns(), q + s.queries()));
        total / queries as f64
    });
    let work = |on_paths: bool, is_warm: bool| {
        let (mut sums, mut count) = (Work::default(), 0.0);
        for stage in stages {
            let (hulls, frames) = (stage.pair.hulls(), if on_paths { &stage.frames } else { &stage.poses });
            let mut caches = vec![Cache::default(); stage.frames.len() / stage.effort.frames];
            for (placed, path) in frames.iter().zip((0..caches.len()).cycle()) {
                if !is_warm {
                    caches[path] = Cache::default();
                }
                let cost = engines::hullmap(query, &hulls, placed, &mut caches[path]);
                sums.support_calls += f64::from(cost.support_calls);
                sums.max_support_calls = sums.max_support_calls.max(cost.support_calls);
                sums.iterations += f64::from(cost.iterations);
                count += 1.0;
            }
        }
        Work { support_calls: sums.support_calls / count, iterations: sums.iterations / count, ..sums }
    };
    let along_paths = [false, true].map(|is_warm| work(true, is_warm));
    Cell { query, mix, ns, cold: work(false, false), paths: along_paths }
}
