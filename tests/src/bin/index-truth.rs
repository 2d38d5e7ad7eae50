//! Proves the direction indices of random hulls, queries them in millions of directions, and
//! damages them.
//!
//! ```text
//! cargo program index-truth -- --hulls 1000 --directions 48000000
//! ```
//!
//! Ends with status 1 if an index is not proven, an answer is not exact, or a removed candidate is
//! missed although a direction needs it.

use std::process::ExitCode;

use clap::Parser;
use hullmap_tests::index_truth::{Answers, Mutations, subject};
use rayon::prelude::*;
use shapes::rng::SplitMix64;

/// Direction indices of random hulls, proven, queried and damaged.
#[derive(Parser)]
struct Arguments {
    /// Number of hulls
    #[arg(long, default_value_t = 100)]
    hulls: u64,
    /// Number of directions over all hulls, spread evenly over the vertices of each
    #[arg(long, default_value_t = 1_000_000)]
    directions: usize,
    /// Maximum number of candidates that are removed from each index, one at a time
    #[arg(long, default_value_t = 100)]
    mutations: usize,
    /// Seed of the first hull; the others count up from it
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

struct Found {
    name: String,
    unproven: Option<String>,
    regret: f64,
    answers: Answers,
    mutations: Mutations,
}

fn judge(arguments: &Arguments, seed: u64) -> Found {
    let mut rng = SplitMix64::new(seed);
    let subject = subject(&mut rng);
    let vertices = subject.baked.hull.vertices.len();
    // Each direction is queried in f32 and in f64.
    let per_vertex = (arguments.directions / arguments.hulls as usize).div_ceil(2 * vertices);
    let proof = subject.proof();
    let replaced =
        subject.baked.index.replaces.as_ref().map(|(kind, reason)| format!("{kind} is not proven: {reason}"));
    Found {
        unproven: proof.as_ref().err().map(ToString::to_string).or(replaced),
        regret: proof.map_or(f64::NAN, |proof| proof.regret),
        answers: subject.query(per_vertex, &mut rng),
        mutations: subject.mutate(arguments.mutations, &mut rng),
        name: subject.name,
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let all: Vec<Found> = (arguments.seed..arguments.seed + arguments.hulls)
        .into_par_iter()
        .map(|seed| judge(&arguments, seed))
        .collect();
    let mut faults = 0;
    for found in &all {
        let (wrong, missed) = (found.answers.wrong, found.mutations.missed);
        if found.unproven.is_some() || wrong + missed > 0 {
            faults += 1;
            let proof = found.unproven.as_deref().unwrap_or("proven");
            println!("{}: {proof}; {wrong} wrong answers, {missed} missed mutations", found.name);
        }
    }
    let sum = |of: fn(&Found) -> usize| all.iter().map(of).sum::<usize>();
    let max = |of: fn(&Found) -> f64| all.iter().map(of).fold(0.0, f64::max);
    println!("{} hulls, {faults} with faults; greatest proven regret {:.1e}", all.len(), max(|found| found.regret));
    println!(
        "{} directions, {} wrong; greatest regret {:.1e}",
        sum(|found| found.answers.count),
        sum(|found| found.answers.wrong),
        max(|found| found.answers.worst)
    );
    println!(
        "{} candidates removed: {} found, {} not needed, {} missed",
        sum(|found| found.mutations.found + found.mutations.harmless + found.mutations.missed),
        sum(|found| found.mutations.found),
        sum(|found| found.mutations.harmless),
        sum(|found| found.mutations.missed)
    );
    if faults == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
