//! Methods of answering support queries, our index kinds and parry3d's scan, and their timing.
//!
//! For each mode every method is calibrated to a batch of about [`Effort::batch`]. Then the methods
//! take turns for [`Effort::rounds`] rounds, each round in a different order, so that a slow spell
//! of the machine affects all of them. The result is the median over the rounds, with quartiles.
//!
//! A batch runs twice and the second pass counts, since the other methods have evicted its tables
//! from the cache. Only the parts of the tables that up to [`DIRECTION_COUNT`] directions lead to
//! become hot. For a large index that is more than the second-level cache holds. Scenes of many
//! hulls show the time of cold queries.

use std::{
    hint::black_box,
    time::{Duration, Instant},
};

use glam::Vec3;
use hullmap::Pack;
use hullmap_bake::IndexKind;
use parry3d::shape::{ConvexPolyhedron, SupportMap};
use shapes::rng::SplitMix64;

use crate::{
    directions,
    subject::{Subject, first_hull, polyhedron},
};

/// Our index kinds, with their names in tables. A new one is one line.
pub const INDICES: [(&str, IndexKind); 5] = [
    ("hullmap none", IndexKind::None),
    ("hullmap binary", IndexKind::Binary),
    ("hullmap compact", IndexKind::Compact),
    ("hullmap cubemap 64", IndexKind::CubeMap { resolution: 64 }),
    ("hullmap tree", IndexKind::Tree),
];

/// Number of directions prepared for a mode: too many for branch predictors to learn.
pub const DIRECTION_COUNT: usize = 8192;

/// Number of queries in the calibration batch.
const CALIBRATION_QUERIES: usize = 16;

/// Factor of the last answer when it is added to the next direction. It is far below half an ulp of
/// any coordinate above 1e-12. So the direction does not change, but the processor has to wait for
/// the answer.
const DEPENDENCE: f32 = 1e-20;

/// A method of answering support queries on one hull.
pub struct Method {
    /// Its name in tables.
    pub name: &'static str,
    /// Bytes in addition to one copy of the coordinates (12 per vertex).
    pub index_bytes: usize,
    /// Time to build the index, if it was measured.
    pub build_time: Option<Duration>,
    tables: Tables,
}

/// The tables that a method searches.
enum Tables {
    /// `Hull::support`.
    Pack(Pack),
    /// `Hull::support_from`, with the last answer as the hint.
    Hinted(Pack),
    /// `ConvexPolyhedron::local_support_point`, a linear scan in f32.
    Parry(Box<ConvexPolyhedron>),
}

/// All methods that can answer for `subject`.
pub fn methods(subject: &Subject) -> Vec<Method> {
    let mut methods = Vec::new();
    for (name, kind) in INDICES {
        let (pack, build_time) = subject.pack(kind);
        let index_bytes = first_hull(&pack).index_byte_len();
        methods.push(Method { name, index_bytes, build_time: Some(build_time), tables: Tables::Pack(pack) });
    }
    let pack = subject.pack(IndexKind::Tree).0;
    let hull = first_hull(&pack);
    if let Some(polyhedron) = polyhedron(&hull) {
        let tables = Tables::Parry(Box::new(polyhedron));
        methods.push(Method { name: "parry3d", index_bytes: 0, build_time: None, tables });
    }
    let edges: usize = (0..hull.vertex_count() as u32).map(|v| hull.neighbours(v).len()).sum();
    let index_bytes = hull.index_byte_len() + size_of::<u32>() * hull.vertex_count() + size_of::<[i16; 3]>() * edges;
    let tables = Tables::Hinted(pack);
    methods.push(Method { name: "hullmap tree hinted", index_bytes, build_time: None, tables });
    methods
}

impl Method {
    /// The answers to `dirs`, in order.
    pub fn answers(&self, dirs: &[Vec3]) -> Vec<Vec3> {
        let mut answers = vec![Vec3::ZERO; dirs.len()];
        self.run(Mode::Throughput, dirs, &mut answers);
        answers
    }

    /// Answers all `dirs` twice, and times the second pass.
    fn run(&self, mode: Mode, dirs: &[Vec3], answers: &mut [Vec3]) -> Duration {
        match &self.tables {
            Tables::Pack(pack) => {
                let hull = first_hull(pack);
                timed(mode, dirs, answers, |dir| hull.support(dir).point)
            }
            Tables::Hinted(pack) => {
                let (hull, mut last) = (first_hull(pack), 0);
                timed(mode, dirs, answers, |dir| {
                    let found = hull.support_from(dir, last);
                    last = found.index;
                    found.point
                })
            }
            Tables::Parry(polyhedron) => timed(mode, dirs, answers, |dir| polyhedron.local_support_point(dir)),
        }
    }
}

/// Inlined for each method, as in a caller's own loop.
fn timed(mode: Mode, dirs: &[Vec3], answers: &mut [Vec3], mut support: impl FnMut(Vec3) -> Vec3) -> Duration {
    let dirs = black_box(dirs);
    let mut elapsed = Duration::ZERO;
    for _ in 0..2 {
        let (start, mut last) = (Instant::now(), Vec3::ZERO);
        if mode == Mode::Throughput {
            dirs.iter().zip(&mut *answers).for_each(|(&dir, answer)| *answer = support(dir));
        } else {
            dirs.iter().for_each(|&dir| last = support(dir + last * DEPENDENCE));
        }
        black_box((&mut *answers, last));
        elapsed = start.elapsed();
    }
    elapsed
}

/// How the queries of a batch follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Random directions, known in advance, so that the processor overlaps queries.
    Throughput,
    /// Random directions, each depending on the last answer: the time of one query.
    Latency,
    /// Directions that turn by one degree per query, each depending on the last answer.
    Coherent,
}

impl Mode {
    /// All modes and their names, in the order of tables.
    pub const ALL: [(&str, Mode); 3] =
        [("throughput", Mode::Throughput), ("latency", Mode::Latency), ("coherent", Mode::Coherent)];
}

/// Measuring effort.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Approximate time of one batch.
    pub batch: Duration,
    /// Number of batches for each method and mode.
    pub rounds: usize,
}

impl Effort {
    /// The whole default table in less than five minutes.
    pub const FULL: Effort = Effort { batch: Duration::from_micros(1_000), rounds: 7 };

    /// A short table in less than half a minute.
    pub const QUICK: Effort = Effort { batch: Duration::from_micros(500), rounds: 5 };
}

/// Times all `methods`. Returns the lower quartile, median and upper quartile over the rounds of
/// each, in nanoseconds per query.
pub fn time(methods: &[Method], mode: Mode, effort: Effort, seed: u64) -> Vec<[f64; 3]> {
    let turns = if mode == Mode::Coherent { directions::turning } else { directions::random };
    let (dirs, mut rng) = (turns(DIRECTION_COUNT, seed), SplitMix64::new(!seed));
    let mut answers = vec![Vec3::ZERO; dirs.len()];
    let calibrated = |method: &Method| {
        let time = method.run(mode, &dirs[..CALIBRATION_QUERIES], &mut [Vec3::ZERO; CALIBRATION_QUERIES]);
        let count = effort.batch.as_secs_f64() * CALIBRATION_QUERIES as f64 / time.as_secs_f64().max(1e-9);
        (count as usize).clamp(CALIBRATION_QUERIES, dirs.len())
    };
    let batches: Vec<usize> = methods.iter().map(calibrated).collect();
    let mut samples = vec![Vec::new(); methods.len()];
    for _ in 0..effort.rounds {
        for index in shuffled(methods.len(), &mut rng) {
            let count = batches[index];
            let at = rng.below(dirs.len() - count + 1);
            let time = methods[index].run(mode, &dirs[at..at + count], &mut answers[..count]);
            samples[index].push(time.as_secs_f64() * 1e9 / count as f64);
        }
    }
    samples.into_iter().map(quartiles).collect()
}

/// The indices below `count`, in random order.
pub fn shuffled(count: usize, rng: &mut SplitMix64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        order.swap(last, rng.below(last + 1));
    }
    order
}

/// Lower quartile, median and upper quartile. Panics without samples.
fn quartiles(mut samples: Vec<f64>) -> [f64; 3] {
    samples.sort_unstable_by(f64::total_cmp);
    [1, 2, 3].map(|quarter| samples[(samples.len() - 1) * quarter / 4])
}

#[cfg(test)]
mod tests {
    use super::quartiles;

    #[test]
    fn samples_have_quartiles() {
        assert_eq!(quartiles(vec![9.0, 1.0, 5.0, 3.0, 7.0]), [3.0, 5.0, 7.0]);
    }
}
