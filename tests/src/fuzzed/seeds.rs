//! Inputs to start from: without them nearly all inputs die at the first check.

use shapes::rng::SplitMix64;

use crate::hostile::samples;

/// Inputs drawn for each target that reads numbers.
const DRAWN: usize = 64;

/// Longest of these.
const LONGEST: usize = 400;

/// Most bytes of a pack.
const MOST: usize = 4096;

/// Names and bytes of the first inputs of a target; none for a target that is not known.
pub fn seeds(target: &str) -> Vec<(String, Vec<u8>)> {
    let numbers = |seed: u64| {
        let mut rng = SplitMix64::new(seed);
        let drawn = |number: usize| {
            let bytes = (0..8 + rng.below(LONGEST)).map(|_| rng.next_u64() as u8).collect();
            (format!("drawn-{number:02}"), bytes)
        };
        (0..DRAWN).map(drawn).collect()
    };
    match target {
        "open_and_query" => samples::small()
            .into_iter()
            .filter(|sample| sample.file.len() <= MOST)
            .map(|sample| (sample.name.replace([' ', ','], "-"), sample.file))
            .collect(),
        "solver" => numbers(1),
        "build_open_verify" => numbers(2),
        _ => Vec::new(),
    }
}
