//! The counts over all pairs, and the wrong answers.

use std::{collections::BTreeMap, fmt};

use hullmap::{Contact, Distance, Intersection};

use super::{body::Kind, meeting::Meeting};

/// Number of wrong answers of each kind that are kept in full.
const KEPT: usize = 5;

/// A wrong answer.
#[derive(Clone, Debug)]
pub struct Wrong {
    /// Index of the pair.
    pub index: u64,
    /// The failed check.
    pub what: &'static str,
    /// The pair and the answers.
    pub details: String,
}

impl fmt::Display for Wrong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "pair {}: {}\n  {}", self.index, self.what, self.details)
    }
}

/// The counts: only sums and maxima, so that they do not depend on the order of the pairs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Pairs judged.
    pub pairs: u64,
    /// Triples of answers judged: a pair's own, mirrored, warm.
    pub judged: u64,
    /// Triples whose depth was compared with all facets of the Minkowski difference.
    pub facets: u64,
    /// Triples whose depth was compared with all face normals.
    pub normals: u64,
    /// Numbers of pairs and of contacts that hit, by intended pose.
    pub meetings: BTreeMap<Meeting, [u64; 2]>,
    /// Bodies by kind.
    pub kinds: BTreeMap<Kind, u64>,
    /// Statuses of `intersects`, `contact` and `distance`.
    pub statuses: [BTreeMap<&'static str, u64>; 3],
    /// Statuses of rays, casts or points.
    pub lines: BTreeMap<&'static str, u64>,
    /// Maximum number of iterations of each.
    pub iterations: [u32; 3],
    /// Maximum number of support calls of each.
    pub support_calls: [u32; 3],
    /// Maximum violation of a bound, as a fraction of the tolerance. Above 1 an answer is wrong.
    pub tightest: f64,
    /// Sum of the hashes of all answers. It does not depend on their order.
    pub fingerprint: u64,
    /// Number of failures of each check.
    pub wrong: BTreeMap<&'static str, u64>,
    /// The first failures of each kind: index of the pair, and the details.
    pub kept: BTreeMap<&'static str, Vec<(u64, String)>>,
}

impl Tally {
    /// Adds the counts of another tally.
    pub fn add(&mut self, other: Self) {
        fn sum<K: Ord>(into: &mut BTreeMap<K, u64>, from: BTreeMap<K, u64>) {
            from.into_iter().for_each(|(key, count)| *into.entry(key).or_default() += count);
        }
        self.pairs += other.pairs;
        self.judged += other.judged;
        self.facets += other.facets;
        self.normals += other.normals;
        for (meeting, [pairs, hits]) in other.meetings {
            let counts = self.meetings.entry(meeting).or_default();
            *counts = [counts[0] + pairs, counts[1] + hits];
        }
        sum(&mut self.kinds, other.kinds);
        for (into, from) in self.statuses.iter_mut().zip(other.statuses) {
            sum(into, from);
        }
        sum(&mut self.lines, other.lines);
        for which in 0..3 {
            self.iterations[which] = self.iterations[which].max(other.iterations[which]);
            self.support_calls[which] = self.support_calls[which].max(other.support_calls[which]);
        }
        self.tightest = self.tightest.max(other.tightest);
        self.fingerprint = self.fingerprint.wrapping_add(other.fingerprint);
        sum(&mut self.wrong, other.wrong);
        for (what, others) in other.kept {
            let kept = self.kept.entry(what).or_default();
            kept.extend(others);
            keep_first(kept);
        }
    }

    /// Counts a wrong answer.
    pub fn take_wrong(&mut self, wrong: Wrong) {
        *self.wrong.entry(wrong.what).or_default() += 1;
        let kept = self.kept.entry(wrong.what).or_default();
        kept.push((wrong.index, wrong.details));
        keep_first(kept);
    }

    /// The first wrong answers of each kind, in order of the pairs' indices.
    pub fn wrongs(&self) -> impl Iterator<Item = Wrong> {
        let kept = self.kept.iter().flat_map(|(what, kept)| kept.iter().map(move |kept| (*what, kept.clone())));
        kept.map(|(what, (index, details))| Wrong { index, what, details })
    }

    pub(super) fn count(&mut self, yes: &Intersection, deep: &Contact, near: &Distance) {
        let names = [yes.status.as_str(), deep.status.as_str(), near.status.as_str()];
        let iterations = [yes.iterations, deep.iterations, near.iterations];
        let calls = [yes.support_calls, deep.support_calls, near.support_calls];
        for which in 0..3 {
            *self.statuses[which].entry(names[which]).or_default() += 1;
            self.iterations[which] = self.iterations[which].max(iterations[which]);
            self.support_calls[which] = self.support_calls[which].max(calls[which]);
        }
    }

    /// Counts an outcome of an answer about a line, a manifold or a motion.
    pub(super) fn note(&mut self, what: &'static str) {
        *self.lines.entry(what).or_default() += 1;
    }

    /// Number of answers with an outcome.
    pub fn of(&self, what: &str) -> u64 {
        self.lines.get(what).copied().unwrap_or(0)
    }

    /// Share of the pairs whose contacts hit.
    pub fn hits(&self) -> f64 {
        self.meetings.values().map(|[_, hits]| hits).sum::<u64>() as f64 / self.pairs as f64
    }
}

impl Tally {
    fn write_pairs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} pairs, {:.1} % hit; {} triples of answers judged, {} of them against all face normals, {} against all facets",
            self.pairs,
            100.0 * self.hits(),
            self.judged,
            self.normals,
            self.facets
        )?;
        for (meeting, [pairs, hits]) in &self.meetings {
            writeln!(f, "  {meeting:?}: {pairs}, of which {hits} hit")?;
        }
        writeln!(f, "bodies: {:?}", self.kinds)?;
        for (which, name) in ["intersects", "contact", "distance"].into_iter().enumerate() {
            let (iterations, calls) = (self.iterations[which], self.support_calls[which]);
            writeln!(f, "{name}: {:?}; maximum {iterations} iterations, {calls} support calls", self.statuses[which])?;
        }
        Ok(())
    }
}

fn keep_first(kept: &mut Vec<(u64, String)>) {
    kept.sort();
    kept.truncate(KEPT);
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.lines.is_empty() {
            self.write_pairs(f)?;
        } else {
            let (answers, truths) = (self.judged, self.normals + self.facets);
            writeln!(f, "{answers} answers judged, {truths} of them by all planes or facets: {:?}", self.lines)?;
        }
        writeln!(f, "tightest certificate: {:.3} of the tolerance", self.tightest)?;
        writeln!(f, "fingerprint: {:016x}", self.fingerprint)?;
        write!(f, "wrong: {} {:?}", self.wrong.values().sum::<u64>(), self.wrong)
    }
}
