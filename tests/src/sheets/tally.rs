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
    /// Counts a query with an outcome.
    pub(super) fn note(&mut self, query: &'static str, outcome: &'static str) {
        *self.counts.entry((query, outcome)).or_default() += 1;
    }

    /// Number of queries with an outcome.
    pub fn of(&self, query: &'static str, outcome: &'static str) -> u64 {
        self.counts.get(&(query, outcome)).copied().unwrap_or_default()
    }

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
