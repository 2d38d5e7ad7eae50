//! Compares contacts of small hulls in degenerate poses with their depth in exact arithmetic.

use std::{process::ExitCode, time::Instant};

use clap::Parser;
use hullmap_tests::degenerate::Tally;

/// Compares contact and intersects with the exact depth: nearly parallel features, thin plates,
/// aligned boxes, concentric and touching pairs.
///
/// Every path of the solver is judged: cold, warm, with tolerance 0, by separating axes, and the
/// general path. Counts and misses go to standard output, progress to standard error. Exits with 1
/// if an answer is wrong.
#[derive(Parser)]
#[command(after_help = "Example:\n  cargo program degenerate-truth -- --pairs 16000 --seed 1")]
struct Arguments {
    /// Number of pairs
    #[arg(long, default_value_t = 16_000)]
    pairs: u64,
    /// Index of the first pair; with --pairs 1, that pair alone
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Seed of all pairs
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Maximum number of vertices of random hulls, 24 to 128
    #[arg(long, default_value_t = 24, value_parser = clap::value_parser!(u16).range(24..=128))]
    vertices: u16,
    /// Maximum number of misses to print in full
    #[arg(long, default_value_t = 20)]
    report: usize,
}

/// Number of progress lines.
const LINES: u64 = 10;

fn main() -> ExitCode {
    let Arguments { pairs, first, seed, vertices, report } = Arguments::parse();
    let (mut tally, start) = (Tally::default(), Instant::now());
    for index in first..first.saturating_add(pairs) {
        tally.judge(seed, index, vertices.into());
        if (index + 1 - first).is_multiple_of(pairs.div_ceil(LINES)) {
            let seconds = start.elapsed().as_secs_f64();
            eprintln!("{seconds:5.1} s  {} pairs, {} misses", index + 1 - first, tally.misses.len());
        }
    }
    println!("seed {seed}\n{tally}");
    tally.misses.iter().take(report).for_each(|miss| println!("\n{miss}"));
    if tally.misses.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) }
}
