//! Interleaved timing of the three queries, ours and parry's.
//!
//! A round asks every engine every query on every pair of hulls, engines taking turns, in an order that changes from
//! round to round; so a slow spell of the machine hits all alike. Of each piece of a few queries the lower quartile
//! over the rounds counts. The mixed poses take turns by class, as a branch predictor meets them in a scene; the figures by
//! class are of passes of their own.
//!
//! All is in one thread and warm in memory: cold means that the solver remembers nothing, not that caches are empty.

use hullmap::{Cache, Settings, intersects};
use shapes::rng::SplitMix64;

use super::{
    engines::{Query, Samples, ours},
    errors::Differences,
    pairs::{Class, FAMILIES, Pair, Placed},
};
use crate::{measure::shuffled, subject::SEED};

/// How much to measure at one vertex count.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Poses of each class and family.
    pub poses: usize,
    /// Paths of each class and family.
    pub paths: usize,
    /// Poses of a path.
    pub frames: usize,
    /// Queries that are timed at once, ours and parry's.
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

    /// A short table in some seconds.
    pub const QUICK: Self = Self { poses: 30, paths: 4, frames: 9, pieces: [12, 4], rounds: 3 };
}

/// What is timed: all poses in turn, or those of one class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mix {
    /// A third of each class.
    All,
    /// One class.
    Only(Class),
}

impl Mix {
    /// All mixes, in the order of tables.
    pub const ALL: [Mix; 4] = [Mix::All, Mix::Only(Class::Deep), Mix::Only(Class::Touching), Mix::Only(Class::Apart)];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Mix::All => "all",
            Mix::Only(class) => class.name(),
        }
    }

    fn place(self) -> usize {
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
    /// What was asked.
    pub query: Query,
    /// Of which poses.
    pub mix: Mix,
    /// Ours, nanoseconds a query.
    pub ours_ns: f64,
    /// Parry's, nanoseconds a query.
    pub parry_ns: f64,
    /// Pairs of our support queries a query: the mean.
    pub support_calls: f64,
    /// Steps a query: the mean.
    pub iterations: f64,
    /// The most support calls of a query.
    pub most_support_calls: u32,
}

/// One query along the paths of one mix.
#[derive(Clone, Debug, PartialEq)]
pub struct Coherent {
    /// What was asked.
    pub query: Query,
    /// Of which paths.
    pub mix: Mix,
    /// With nothing remembered, nanoseconds a query.
    pub cold_ns: f64,
    /// With a cache kept for each path, nanoseconds a query.
    pub warm_ns: f64,
    /// Support calls a query, cold and warm.
    pub support_calls: [f64; 2],
}

/// All that was measured at one vertex count.
#[derive(Clone, Debug)]
pub struct Record {
    /// Points of a hull.
    pub n: usize,
    /// Vertices of a hull, in the mean.
    pub vertices: f64,
    /// Families that parry refused.
    pub refused: Vec<&'static str>,
    /// Share of the poses that overlap.
    pub hit_share: f64,
    /// Share of the paths' frames that overlap.
    pub coherent_hit_share: f64,
    /// Query by query, mix by mix.
    pub cold: Vec<Cold>,
    /// Query by query, mix by mix.
    pub coherent: Vec<Coherent>,
    /// Our answers against parry's.
    pub differences: Differences,
}

/// A pair of hulls and its poses, by mix in the order of [`Mix::ALL`].
struct Stage {
    pair: Pair,
    poses: [Vec<Placed>; 4],
    frames: [Vec<Placed>; 4],
}

impl Stage {
    fn new(pair: Pair, effort: Effort, seed: u64) -> Self {
        let mut rng = SplitMix64::new(seed);
        let poses = pair.poses(effort.poses, &mut rng);
        let frames = pair.frames(effort.paths, effort.frames, &mut rng);
        let by_mix = |all: Vec<Placed>| {
            Mix::ALL.map(|mix| all.iter().copied().filter(|placed| mix.holds(placed.class)).collect::<Vec<_>>())
        };
        Self { pair, poses: by_mix(poses), frames: by_mix(frames) }
    }
}

/// What takes turns: one query on the poses, or along the paths, of one mix and one pair of hulls.
struct Heat<'s> {
    stage: &'s Stage,
    query: Query,
    mix: Mix,
    /// Ours on the poses, parry's; ours along the paths, with nothing remembered and with a cache.
    samples: [Samples; 4],
}

impl<'s> Heat<'s> {
    fn new(stage: &'s Stage, query: Query, mix: Mix, effort: Effort) -> Self {
        let [poses, frames] = [&stage.poses, &stage.frames].map(|all| all[mix.place()].len());
        let [ours, parry] = effort.pieces;
        let samples = [(poses, ours), (poses, parry), (frames, ours), (frames, ours)]
            .map(|(queries, piece)| Samples::new(queries, piece));
        Self { stage, query, mix, samples }
    }

    fn round(&mut self, effort: Effort, rng: &mut SplitMix64) {
        let (pair, hulls) = (&self.stage.pair, &self.stage.pair.hulls());
        let [poses, frames] = [&self.stage.poses, &self.stage.frames].map(|all| &all[self.mix.place()]);
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

/// Measures one vertex count.
///
/// # Panics
/// If parry refuses the hulls of every family.
pub fn run(n: usize, effort: Effort) -> Record {
    let (mut stages, mut refused) = (Vec::new(), Vec::new());
    for family in FAMILIES {
        match Pair::bake(family, n, SEED) {
            Some(pair) => stages.push(Stage::new(pair, effort, SEED)),
            None => refused.push(family.name()),
        }
    }
    assert!(!stages.is_empty(), "parry refuses all hulls of {n} points");
    let cells: Vec<(Query, Mix)> = Query::ALL.into_iter().flat_map(|query| Mix::ALL.map(|mix| (query, mix))).collect();
    let mut heats: Vec<Heat<'_>> = cells
        .iter()
        .flat_map(|&(query, mix)| stages.iter().map(move |stage| Heat::new(stage, query, mix, effort)))
        .collect();
    let mut rng = SplitMix64::new(!SEED);
    for _ in 0..effort.rounds {
        heats.iter_mut().for_each(|heat| heat.round(effort, &mut rng));
    }
    // The families count alike, as each has as many poses.
    let ns = |query: Query, mix: Mix, engine: usize| {
        let samples =
            heats.iter().filter(|heat| (heat.query, heat.mix) == (query, mix)).map(|heat| &heat.samples[engine]);
        let (total, queries) = samples.fold((0.0, 0), |(t, q), s| (t + s.total_ns(), q + s.queries()));
        total / queries as f64
    };
    let cold = cells.iter().map(|&(query, mix)| Cold {
        ours_ns: ns(query, mix, 0),
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
        refused,
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

/// What the queries of a cell take besides time.
fn counted(query: Query, mix: Mix, stages: &[Stage]) -> Cold {
    let settings = Settings::default();
    let (mut support_calls, mut iterations, mut most_support_calls, mut count) = (0, 0, 0, 0);
    for stage in stages {
        let hulls = stage.pair.hulls();
        for placed in &stage.poses[mix.place()] {
            let cost = ours(query, &hulls, placed, &settings, &mut Cache::default());
            support_calls += cost.support_calls;
            iterations += cost.iterations;
            most_support_calls = most_support_calls.max(cost.support_calls);
            count += 1;
        }
    }
    let mean = |sum: u32| f64::from(sum) / f64::from(count);
    let (support_calls, iterations) = (mean(support_calls), mean(iterations));
    Cold { query, mix, ours_ns: 0.0, parry_ns: 0.0, support_calls, iterations, most_support_calls }
}

/// Support calls a query, cold and warm.
fn counted_along_paths(query: Query, mix: Mix, stages: &[Stage], effort: Effort) -> [f64; 2] {
    let settings = Settings::default();
    let (mut support_calls, mut count) = ([0, 0], 0);
    for stage in stages {
        let (hulls, frames) = (stage.pair.hulls(), &stage.frames[mix.place()]);
        let mut caches = vec![Cache::default(); frames.len() / effort.frames];
        for paths in frames.chunks(caches.len()) {
            for (placed, kept) in paths.iter().zip(&mut caches) {
                support_calls[0] += ours(query, &hulls, placed, &settings, &mut Cache::default()).support_calls;
                support_calls[1] += ours(query, &hulls, placed, &settings, kept).support_calls;
                count += 1;
            }
        }
    }
    support_calls.map(|sum| f64::from(sum) / f64::from(count))
}
