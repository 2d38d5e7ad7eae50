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

use hullmap::{Cache, Settings, intersects};
use shapes::rng::SplitMix64;

use super::{
    engines::{self, PairQuery, Samples},
    errors::Differences,
    pairs::{BakedPair, Class, FAMILIES, Placed},
};
use crate::{measure::shuffled, subject::SEED};

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

/// Selection of poses: all, or one class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mix {
    /// All classes, a third each.
    All,
    /// One class.
    Only(Class),
}

impl Mix {
    /// All mixes, in the order of tables.
    pub const ALL: [Mix; 4] =
        [Mix::All, Mix::Only(Class::Penetrating), Mix::Only(Class::NearTouching), Mix::Only(Class::Separated)];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Mix::All => "all",
            Mix::Only(class) => class.name(),
        }
    }

    fn index(self) -> usize {
        match self {
            Mix::All => 0,
            Mix::Only(class) => 1 + class as usize,
        }
    }

    fn holds(self, class: Class) -> bool {
        self == Mix::All || self == Mix::Only(class)
    }
}

/// One query on the poses of one mix.
#[derive(Clone, Debug, PartialEq)]
pub struct Cold {
    /// Kind of the query.
    pub query: PairQuery,
    /// Selection of poses.
    pub mix: Mix,
    /// Time of hullmap, in nanoseconds per query.
    pub hullmap_ns: f64,
    /// Time of parry, in nanoseconds per query.
    pub parry_ns: f64,
    /// Mean number of pairs of support queries of hullmap.
    pub support_calls: f64,
    /// Mean number of steps of hullmap.
    pub iterations: f64,
    /// Maximum number of pairs of support queries.
    pub max_support_calls: u32,
}

/// One query along the paths of one mix.
#[derive(Clone, Debug, PartialEq)]
pub struct Coherent {
    /// Kind of the query.
    pub query: PairQuery,
    /// Selection of paths.
    pub mix: Mix,
    /// Time with empty caches, in nanoseconds per query.
    pub cold_ns: f64,
    /// Time with a cache for each path, in nanoseconds per query.
    pub warm_ns: f64,
    /// Mean number of pairs of support queries, cold and warm.
    pub support_calls: [f64; 2],
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
    /// Fraction of the poses that overlap.
    pub hit_share: f64,
    /// Fraction of the poses on paths that overlap.
    pub coherent_hit_share: f64,
    /// One entry for each query and selection.
    pub cold: Vec<Cold>,
    /// One entry for each query and selection.
    pub coherent: Vec<Coherent>,
    /// Comparison of the answers.
    pub differences: Differences,
}

/// A pair of hulls and its poses, by selection in the order of [`Mix::ALL`].
struct Stage {
    pair: BakedPair,
    poses: [Vec<Placed>; 4],
    frames: [Vec<Placed>; 4],
}

impl Stage {
    fn new(pair: BakedPair, effort: Effort, seed: u64) -> Self {
        let mut rng = SplitMix64::new(seed);
        let poses = pair.poses(effort.poses, &mut rng);
        let frames = pair.frames(effort.paths, effort.frames, &mut rng);
        let by_mix = |all: Vec<Placed>| {
            Mix::ALL.map(|mix| all.iter().copied().filter(|placed| mix.holds(placed.class)).collect::<Vec<_>>())
        };
        Self { pair, poses: by_mix(poses), frames: by_mix(frames) }
    }
}

/// Unit that takes turns: one query on the poses or paths of one selection and one pair of hulls.
struct Heat<'s> {
    stage: &'s Stage,
    query: PairQuery,
    mix: Mix,
    /// hullmap and parry on the poses; hullmap along the paths, cold and warm.
    samples: [Samples; 4],
}

impl<'s> Heat<'s> {
    fn new(stage: &'s Stage, query: PairQuery, mix: Mix, effort: Effort) -> Self {
        let [poses, frames] = [&stage.poses, &stage.frames].map(|all| all[mix.index()].len());
        let [hullmap, parry] = effort.pieces;
        let samples = [(poses, hullmap), (poses, parry), (frames, hullmap), (frames, hullmap)]
            .map(|(queries, piece)| Samples::new(queries, piece));
        Self { stage, query, mix, samples }
    }

    fn round(&mut self, effort: Effort, rng: &mut SplitMix64) {
        let (pair, hulls) = (&self.stage.pair, &self.stage.pair.hulls());
        let [poses, frames] = [&self.stage.poses, &self.stage.frames].map(|all| &all[self.mix.index()]);
        let paths = frames.len() / effort.frames;
        for engine in shuffled(self.samples.len(), rng) {
            let samples = &mut self.samples[engine];
            match engine {
                0 => samples.cold(self.query, hulls, poses),
                1 => samples.parry(self.query, pair, poses),
                2 => samples.cold(self.query, hulls, frames),
                _ => samples.warm(self.query, hulls, frames, paths),
            }
        }
    }
}

/// Measures one vertex count. Panics if parry rejects the hulls of every family.
pub fn run(n: usize, effort: Effort) -> Record {
    let (mut stages, mut rejected) = (Vec::new(), Vec::new());
    for family in FAMILIES {
        match BakedPair::bake(family, n, SEED) {
            Some(pair) => stages.push(Stage::new(pair, effort, SEED)),
            None => rejected.push(family.name()),
        }
    }
    assert!(!stages.is_empty(), "parry rejects all hulls of {n} points");
    let cells: Vec<(PairQuery, Mix)> =
        PairQuery::ALL.into_iter().flat_map(|query| Mix::ALL.map(|mix| (query, mix))).collect();
    let mut heats: Vec<Heat<'_>> = cells
        .iter()
        .flat_map(|&(query, mix)| stages.iter().map(move |stage| Heat::new(stage, query, mix, effort)))
        .collect();
    let mut rng = SplitMix64::new(!SEED);
    for _ in 0..effort.rounds {
        heats.iter_mut().for_each(|heat| heat.round(effort, &mut rng));
    }
    // All families have the same number of poses, and so the same weight.
    let ns = |query: PairQuery, mix: Mix, engine: usize| {
        let samples =
            heats.iter().filter(|heat| (heat.query, heat.mix) == (query, mix)).map(|heat| &heat.samples[engine]);
        let (total, queries) = samples.fold((0.0, 0), |(t, q), s| (t + s.total_ns(), q + s.queries()));
        total / queries as f64
    };
    let cold = cells.iter().map(|&(query, mix)| Cold {
        hullmap_ns: ns(query, mix, 0),
        parry_ns: ns(query, mix, 1),
        ..counted(query, mix, &stages)
    });
    let coherent = cells.iter().map(|&(query, mix)| Coherent {
        query,
        mix,
        cold_ns: ns(query, mix, 2),
        warm_ns: ns(query, mix, 3),
        support_calls: counted_along_paths(query, mix, &stages, effort),
    });
    let mut differences = Differences::default();
    stages.iter().for_each(|stage| differences.add(&stage.pair, &stage.poses[0]));
    Record {
        n,
        vertices: stages.iter().map(|s| s.pair.vertices as f64).sum::<f64>() / (2 * stages.len()) as f64,
        rejected,
        hit_share: hit_share(&stages, |stage| &stage.poses[0]),
        coherent_hit_share: hit_share(&stages, |stage| &stage.frames[0]),
        cold: cold.collect(),
        coherent: coherent.collect(),
        differences,
    }
}

fn hit_share(stages: &[Stage], poses: impl Fn(&Stage) -> &[Placed]) -> f64 {
    let (mut hits, mut all) = (0_usize, 0_usize);
    for stage in stages {
        let [a, b] = &stage.pair.hulls();
        for placed in poses(stage) {
            all += 1;
            hits += usize::from(intersects(a, b, placed.b_in_a, &mut Cache::default()).is_hit());
        }
    }
    hits as f64 / all as f64
}

/// Counts of the queries of a cell, without times.
fn counted(query: PairQuery, mix: Mix, stages: &[Stage]) -> Cold {
    let settings = Settings::default();
    let (mut support_calls, mut iterations, mut max_support_calls, mut count) = (0, 0, 0, 0);
    for stage in stages {
        let hulls = stage.pair.hulls();
        for placed in &stage.poses[mix.index()] {
            let cost = engines::hullmap(query, &hulls, placed, &settings, &mut Cache::default());
            support_calls += cost.support_calls;
            iterations += cost.iterations;
            max_support_calls = max_support_calls.max(cost.support_calls);
            count += 1;
        }
    }
    let mean = |sum: u32| f64::from(sum) / f64::from(count);
    let (support_calls, iterations) = (mean(support_calls), mean(iterations));
    Cold { query, mix, hullmap_ns: 0.0, parry_ns: 0.0, support_calls, iterations, max_support_calls }
}

/// Mean number of pairs of support queries, cold and warm.
fn counted_along_paths(query: PairQuery, mix: Mix, stages: &[Stage], effort: Effort) -> [f64; 2] {
    let settings = Settings::default();
    let (mut support_calls, mut count) = ([0, 0], 0);
    for stage in stages {
        let (hulls, frames) = (stage.pair.hulls(), &stage.frames[mix.index()]);
        let mut caches = vec![Cache::default(); frames.len() / effort.frames];
        for paths in frames.chunks(caches.len()) {
            for (placed, kept) in paths.iter().zip(&mut caches) {
                support_calls[0] +=
                    engines::hullmap(query, &hulls, placed, &settings, &mut Cache::default()).support_calls;
                support_calls[1] += engines::hullmap(query, &hulls, placed, &settings, kept).support_calls;
                count += 1;
            }
        }
    }
    support_calls.map(|sum| f64::from(sum) / f64::from(count))
}
