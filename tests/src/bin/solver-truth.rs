//! The solver's intervals against truth, on as many pairs as one likes.

use std::{process::ExitCode, time::Instant};

use clap::Parser;
use hullmap_tests::truth::{
    scene::{Detail, Scene},
    verdict::{Answers, Tally},
};

/// Compares contact, distance and intersects with truth in f64, on hulls of many kinds.
///
/// Counts and misses go to standard output, progress to standard error. Exits with 1 if an answer is wrong.
#[derive(Parser)]
#[command(
    after_help = "Example:\n  cargo run --release -p hullmap-tests --bin solver-truth -- --pairs 100000 --seed 1"
)]
struct Arguments {
    /// How many pairs
    #[arg(long, default_value_t = 10_000)]
    pairs: u64,
    /// Number of the first pair: with --pairs 1, that pair alone
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Seed of all pairs
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Hulls of 512 to 2000 vertices instead of 4 to 400: a pair takes a hundred times as long
    #[arg(long)]
    detailed: bool,
    /// How many misses to tell in full
    #[arg(long, default_value_t = 20)]
    told: usize,
}

/// Lines of progress.
const LINES: u64 = 10;

fn main() -> ExitCode {
    let Arguments { pairs, first, seed, detailed, told } = Arguments::parse();
    let (mut scene, mut tally, start) =
        (Scene::new(seed, if detailed { Detail::Many } else { Detail::Few }), Tally::default(), Instant::now());
    for number in first..first.saturating_add(pairs) {
        let (pair, bodies) = scene.pair(number);
        tally.judge(&pair, bodies, &Answers::to(&pair, bodies));
        if (number + 1 - first).is_multiple_of(pairs.div_ceil(LINES)) {
            let seconds = start.elapsed().as_secs_f64();
            eprintln!("{seconds:5.1} s  {} pairs, {} misses", number + 1 - first, tally.misses.len());
        }
    }
    println!("seed {seed}\n{tally}");
    tally.misses.iter().take(told).for_each(|miss| println!("\n{miss}"));
    if tally.misses.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) }
}
