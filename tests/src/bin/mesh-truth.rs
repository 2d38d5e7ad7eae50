//! Compares queries of triangle meshes with brute force over all triangles.

use std::{process::ExitCode, time::Instant};

use clap::Parser;
use hullmap_tests::sheets::Tally;
use rayon::prelude::*;

/// Queries intersects, distance, contacts, rays, casts and signed distances of triangle meshes:
/// random, flat, of needles, with ties, far, tiny, with triangles of 10 km, and closed ones.
///
/// Counts and wrong answers go to standard output, progress to standard error. Exits with 1 if an
/// answer is wrong.
#[derive(Parser)]
#[command(after_help = "Example:\n  cargo program mesh-truth -- --queries 1000000 --seed 1")]
struct Arguments {
    /// Minimum number of queries
    #[arg(long, default_value_t = 1_000_000)]
    queries: u64,
    /// Judge contact manifolds instead, of bodies of all kinds
    #[arg(long)]
    manifolds: bool,
    /// Index of the first mesh; with --queries 1, that mesh alone
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Seed of all meshes
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only rays at edges, vertices and seams of meshes, height fields and packs
    #[arg(long)]
    joints: bool,
    /// Maximum number of wrong answers to print in full
    #[arg(long, default_value_t = 20)]
    report: usize,
}

/// Number of meshes between two lines of progress.
const BLOCK: u64 = 1_000;

fn main() -> ExitCode {
    let Arguments { queries, manifolds, joints, first, seed, report } = Arguments::parse();
    let (mut tally, start, mut next) = (Tally::default(), Instant::now(), first);
    while tally.queries() < queries {
        let until = next + if queries == 1 { 1 } else { BLOCK };
        let judged: Vec<Tally> = (next..until)
            .into_par_iter()
            .map(|index| {
                let mut tally = Tally::default();
                if joints {
                    tally.judge_joints(seed, index)
                } else if manifolds {
                    tally.judge_manifolds(seed, index)
                } else {
                    tally.judge(seed, index)
                }
                tally
            })
            .collect();
        for part in judged {
            part.counts.into_iter().for_each(|(key, count)| *tally.counts.entry(key).or_default() += count);
            for wrong in part.wrong {
                if tally.wrong.len() < report {
                    println!("{wrong}\n");
                }
                tally.wrong.push(wrong);
            }
        }
        next = until;
        let (seconds, wrong) = (start.elapsed().as_secs_f64(), tally.wrong.len());
        eprintln!("{seconds:7.1} s  {} queries, {wrong} wrong; continue with --first {next}", tally.queries());
    }
    println!("seed {seed}, meshes {first} to {next}\n{tally}");
    if tally.wrong.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) }
}
