//! Runs the solver on any number of pairs, and verifies each answer by a certificate.

use std::{path::PathBuf, process::ExitCode, time::Instant};

use clap::Parser;
use hullmap_tests::{
    game_hulls,
    soak::{
        Queries,
        bodies::{Bodies, Stock},
        soak,
        tally::Tally,
    },
};

/// Queries intersects, contact and distance for pairs of hulls and shapes, most of them nearly
/// touching, and checks each answer by brute force.
///
/// Pairs are indexed and do not depend on the number of threads. Counts and wrong answers go to
/// standard output, progress to standard error. Exits with 1 if an answer is wrong.
#[derive(Parser)]
#[command(after_help = "Example:\n  HULLMAP_HULLS=game_hulls.bin cargo program solver-soak -- --pairs 100000000")]
struct Arguments {
    /// Queries to run
    #[arg(long, value_enum, default_value_t = Queries::Pairs)]
    queries: Queries,
    /// Number of pairs, or of rays, casts or points
    #[arg(long, default_value_t = 1_000_000)]
    pairs: u64,
    /// Index of the first pair: continues an interrupted run; with --pairs 1, that pair alone
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Seed of all pairs
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of threads [default: all processors]
    #[arg(long)]
    threads: Option<usize>,
    /// Use one game hull in N
    #[arg(long, default_value_t = 1)]
    stride: usize,
    /// Maximum number of wrong answers to print in full
    #[arg(long, default_value_t = 10)]
    report: usize,
}

/// Number of pairs between two lines of progress.
const BLOCK: u64 = 1_000_000;

fn main() -> ExitCode {
    let Arguments { queries, pairs, first, seed, threads, stride, report } = Arguments::parse();
    let threads = threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let file = std::env::var_os(game_hulls::VARIABLE).filter(|value| !value.is_empty()).map(PathBuf::from);
    let clouds = match file.as_ref().map(std::fs::read) {
        Some(Ok(bytes)) => game_hulls::read(&bytes),
        Some(Err(error)) => {
            eprintln!("{}: {error}", file.unwrap_or_default().display());
            return ExitCode::from(2);
        }
        None => {
            eprintln!("{} is not set: only generated shapes are used", game_hulls::VARIABLE);
            Vec::new()
        }
    };
    let stock = Stock::bake(&clouds, stride);
    stock.rejected.iter().for_each(|rejected| eprintln!("rejected by the baker: {rejected}"));
    let bodies = Bodies::new(&stock);
    eprintln!("bodies: {:?}", bodies.counts);
    let (start, end) = (Instant::now(), first.saturating_add(pairs));
    let mut tally = Tally::default();
    let (mut next, mut left) = (first, report);
    while next < end {
        let until = end.min(next + BLOCK);
        let block = soak(&bodies, queries, seed, next..until, threads);
        // Print immediately: a long run may be interrupted.
        for wrong in block.wrongs().take(left) {
            println!("{wrong}\n");
            left -= 1;
        }
        tally.add(block);
        next = until;
        let (seconds, wrong) = (start.elapsed().as_secs_f64(), tally.wrong.values().sum::<u64>());
        eprintln!("{seconds:7.1} s  {} pairs, {wrong} wrong; continue with --first {next}", tally.pairs);
    }
    println!("{queries:?}, seed {seed}, pairs {first} to {next}, bodies {:?}\n{tally}", bodies.counts);
    if tally.wrong.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) }
}
