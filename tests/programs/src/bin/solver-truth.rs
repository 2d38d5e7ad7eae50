//! Compares the solver's intervals with the truth, on any number of pairs.

use std::{process::ExitCode, time::Instant};

use clap::Parser;
use hullmap_tests::truth::{
    scene::{Detail, Scene},
    verdict::{Answers, Tally},
};

/// Compares contact, distance and intersects with the truth in f64, on hulls of many kinds.
///
/// Counts and misses go to standard output, progress to standard error. Exits with 1 on a miss.
#[derive(Parser)]
#[command(
    after_help = "Example:\n  cargo run --release -p hullmap-programs --bin solver-truth -- --pairs 100000 --seed 1"
)]
struct Arguments {
    /// Number of pairs
    #[arg(long, default_value_t = 10_000)]
    pairs: u64,
    /// Index of the first pair; with --pairs 1, that pair alone
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Seed of all pairs
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Hulls of 512 to 2000 vertices instead of 4 to 400: a pair takes a hundred times as long
    #[arg(long)]
    detailed: bool,
    /// Maximum number of misses to print in full
    #[arg(long, default_value_t = 20)]
    report: usize,
}

/// Number of progress lines.
const LINES: u64 = 10;

fn main() -> ExitCode {
    let Arguments { pairs, first, seed, detailed, report } = Arguments::parse();
    let (mut scene, mut tally, start) =
        (Scene::new(seed, if detailed { Detail::Many } else { Detail::Few }), Tally::default(), Instant::now());
    for index in first..first.saturating_add(pairs) {
        let (pair, bodies) = scene.pair(index);
        tally.judge(&pair, bodies, &Answers::to(&pair, bodies));
        if (index + 1 - first).is_multiple_of(pairs.div_ceil(LINES)) {
            let seconds = start.elapsed().as_secs_f64();
            eprintln!("{seconds:5.1} s  {} pairs, {} misses", index + 1 - first, tally.misses.len());
        }
    }
    println!("seed {seed}\n{tally}");
    tally.misses.iter().take(report).for_each(|miss| println!("\n{miss}"));
    if tally.misses.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) }
}
