//! Interleaved timing of rivals.
//!
//! For each mode every rival is calibrated to a batch of about [`Effort::batch`]. Then the rivals
//! take turns for [`Effort::rounds`] rounds, each round in a different order, so that a slow spell
//! of the machine affects all of them. The result is the median over the rounds, with the
//! quartiles.
//!
//! All modes except the cold one are hot: a batch runs twice and the second pass counts, since the
//! other rivals have evicted its tables from the cache. Only the parts of the tables that up to
//! [`DIRECTION_COUNT`] directions lead to become hot. For a large index that is more than the
//! second-level cache holds.

use std::time::Duration;

use glam::Vec3;
use shapes::rng::SplitMix64;

use crate::{
    directions,
    eviction::Eviction,
    query::{Contestant, Flow},
};

/// Number of directions prepared for a mode: too many for branch predictors to learn.
pub const DIRECTION_COUNT: usize = 8192;

/// Number of queries in the calibration batch.
const CALIBRATION_QUERIES: usize = 16;

/// How the queries of a batch follow each other, and what is in the caches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Random directions, known in advance: queries per second.
    Throughput,
    /// Random directions, each depending on the last answer: the time of one query.
    Latency,
    /// Directions that turn by one degree per query, each depending on the last answer. Rivals may
    /// keep state.
    Coherent,
    /// Random directions, each to a copy of the rival that is in no cache, each depending on the
    /// last answer.
    Cold,
}

impl Mode {
    /// All modes, in the order of tables.
    pub const ALL: [Mode; 4] = [Mode::Throughput, Mode::Latency, Mode::Coherent, Mode::Cold];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Mode::Throughput => "throughput",
            Mode::Latency => "latency",
            Mode::Coherent => "coherent",
            Mode::Cold => "cold",
        }
    }

    fn flow(self) -> Flow {
        if self == Mode::Throughput { Flow::Independent } else { Flow::Dependent }
    }

    fn directions(self, seed: u64) -> Vec<Vec3> {
        if self == Mode::Coherent {
            directions::turning(DIRECTION_COUNT, seed)
        } else {
            directions::random(DIRECTION_COUNT, seed)
        }
    }
}

/// Measuring effort.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Approximate time of one batch.
    pub batch: Duration,
    /// Number of batches for each rival and mode.
    pub rounds: usize,
    /// Number of rounds of the cold mode, each of which empties the caches once for each rival.
    pub cold_rounds: usize,
}

impl Effort {
    /// The whole default table in less than five minutes.
    pub const FULL: Effort = Effort { batch: Duration::from_micros(1_000), rounds: 7, cold_rounds: 5 };

    /// A short table in less than half a minute.
    pub const QUICK: Effort = Effort { batch: Duration::from_micros(500), rounds: 5, cold_rounds: 3 };
}

/// Time of a query over the rounds, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// The median.
    pub median_ns: f64,
    /// The lower and upper quartile.
    pub quartiles_ns: [f64; 2],
}

impl Timing {
    /// Sorts `samples`, in nanoseconds. Panics without samples.
    pub fn new(mut samples: Vec<f64>) -> Self {
        samples.sort_unstable_by(f64::total_cmp);
        let at = |quarter: usize| samples[(samples.len() - 1) * quarter / 4];
        Self { median_ns: at(2), quartiles_ns: [at(1), at(3)] }
    }
}

/// Times all `rivals`; returns one timing each, in their order.
pub fn time(
    rivals: &mut [Box<dyn Contestant>],
    mode: Mode,
    effort: Effort,
    eviction: &mut Eviction,
    seed: u64,
) -> Vec<Timing> {
    let dirs = mode.directions(seed);
    let mut rng = SplitMix64::new(!seed);
    let mut samples: Vec<Vec<f64>> = vec![Vec::new(); rivals.len()];
    if mode == Mode::Cold {
        rivals.iter_mut().for_each(|rival| rival.stock_copies());
        for _ in 0..effort.cold_rounds {
            for index in shuffled(rivals.len(), &mut rng) {
                let at = rng.below(dirs.len() / 2);
                let (time, count) = rivals[index].run_cold(&dirs[at..], eviction, &mut rng);
                samples[index].push(nanos_per(time, count));
            }
        }
    } else {
        let batches: Vec<usize> = rivals.iter().map(|rival| calibrate(rival.as_ref(), mode, effort, &dirs)).collect();
        for _ in 0..effort.rounds {
            for index in shuffled(rivals.len(), &mut rng) {
                let at = rng.below(dirs.len() - batches[index] + 1);
                let time = rivals[index].run(mode.flow(), &dirs[at..at + batches[index]]);
                samples[index].push(nanos_per(time, batches[index]));
            }
        }
    }
    samples.into_iter().map(Timing::new).collect()
}

/// Number of queries that take about the time of a batch.
fn calibrate(rival: &dyn Contestant, mode: Mode, effort: Effort, dirs: &[Vec3]) -> usize {
    let time = rival.run(mode.flow(), &dirs[..CALIBRATION_QUERIES]);
    let count = effort.batch.as_secs_f64() * CALIBRATION_QUERIES as f64 / time.as_secs_f64().max(1e-9);
    (count as usize).clamp(CALIBRATION_QUERIES, dirs.len())
}

fn nanos_per(time: Duration, count: usize) -> f64 {
    time.as_secs_f64() * 1e9 / count as f64
}

/// The indices below `count`, in random order.
pub fn shuffled(count: usize, rng: &mut SplitMix64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        order.swap(last, rng.below(last + 1));
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timings_are_medians_and_quartiles() {
        let timing = Timing::new(vec![9.0, 1.0, 5.0, 3.0, 7.0]);
        assert_eq!(timing, Timing { median_ns: 5.0, quartiles_ns: [3.0, 7.0] });
    }

    #[test]
    fn shuffles_are_permutations() {
        let mut order = shuffled(20, &mut SplitMix64::new(1));
        assert_ne!(order, (0..20).collect::<Vec<_>>());
        order.sort_unstable();
        assert_eq!(order, (0..20).collect::<Vec<_>>());
    }
}
