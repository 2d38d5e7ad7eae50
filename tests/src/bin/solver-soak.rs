//! The solver on as many pairs as one likes, each answer judged by a certificate.

use std::{path::PathBuf, process::ExitCode, time::Instant};

use clap::Parser;
use hullmap_tests::{
    game_hulls,
    soak::{
        cast::{Cast, Stock},
        soak,
        tally::Tally,
    },
};

/// Asks intersects, contact and distance about pairs of hulls and shapes, most about touching, and tests each answer by brute force.
///
/// Pairs are numbered and the same on any number of threads. Counts and wrong answers go to standard output, progress to standard
/// error. Exits with 1 if an answer is wrong.
#[derive(Parser)]
#[command(after_help = "Example:\n  HULLMAP_HULLS=game_hulls.bin cargo run --release -p hullmap-tests --bin solver-soak -- --pairs 100000000")]
struct Arguments {
    /// How many pairs
    #[arg(long, default_value_t = 1_000_000)]
    pairs: u64,
    /// Number of the first pair: to go on after a run that was cut short, or with --pairs 1 that pair alone
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Seed of all pairs
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads; all processors by default
    #[arg(long)]
    threads: Option<usize>,
    /// Takes every so manieth of the game hulls
    #[arg(long, default_value_t = 1)]
    stride: usize,
    /// How many wrong answers to tell in full
    #[arg(long, default_value_t = 10)]
    told: usize,
}

/// Pairs between two lines of progress.
const BLOCK: u64 = 1_000_000;

fn main() -> ExitCode {
    let Arguments { pairs, first, seed, threads, stride, told } = Arguments::parse();
    let threads = threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let file = std::env::var_os(game_hulls::VARIABLE).filter(|value| !value.is_empty()).map(PathBuf::from);
    let clouds = match file.as_ref().map(std::fs::read) {
        Some(Ok(bytes)) => game_hulls::read(&bytes),
        Some(Err(error)) => {
            eprintln!("{}: {error}", file.unwrap_or_default().display());
            return ExitCode::from(2);
        }
        None => {
            eprintln!("{} is not set: generated shapes alone", game_hulls::VARIABLE);
            Vec::new()
        }
    };
    let stock = Stock::bake(&clouds, stride);
    stock.refused.iter().for_each(|refused| eprintln!("not baked: {refused}"));
    let cast = Cast::new(&stock);
    eprintln!("bodies: {:?}", cast.counts);
    let (start, end) = (Instant::now(), first.saturating_add(pairs));
    let mut tally = Tally::default();
    let mut next = first;
    while next < end {
        let until = end.min(next + BLOCK);
        tally.add(soak(&cast, seed, next..until, threads));
        next = until;
        let wrong: u64 = tally.wrong.values().sum();
        eprintln!("{:7.1} s  {} pairs, {wrong} wrong; go on with --first {next}", start.elapsed().as_secs_f64(), tally.pairs);
    }
    println!("seed {seed}, pairs {first} to {next}, bodies {:?}\n{tally}", cast.counts);
    tally.wrongs().take(told).for_each(|wrong| println!("\n{wrong}"));
    if tally.wrong.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) }
}
