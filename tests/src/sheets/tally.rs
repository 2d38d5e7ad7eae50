//! Counts of queries of triangle meshes, and the wrong answers.

use std::collections::BTreeMap;
use std::fmt;

/// Counts over all scenes.
#[derive(Debug, Default)]
pub struct Tally {
    /// Number of queries of each kind, with a short outcome.
    pub counts: BTreeMap<(&'static str, &'static str), u64>,
    /// Wrong answers, in words.
    pub wrong: Vec<String>,
}

impl Tally {
    /// Number of queries judged.
    pub fn queries(&self) -> u64 {
        self.counts.values().sum()
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for ((query, outcome), count) in &self.counts {
            writeln!(f, "{query:>16} {outcome:<12} {count:>9}")?;
        }
        write!(f, "{} queries, {} wrong", self.queries(), self.wrong.len())
    }
}
