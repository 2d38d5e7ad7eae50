//! The three queries of hullmap, with default settings, and of parry3d: `query::contact` without
//! prediction, `query::intersection_test` and `query::distance`.

use std::{hint::black_box, time::Instant};

use hullmap::{Cache, Hull, Settings, contact, distance, intersects};
use parry3d::{math, query, shape::ConvexPolyhedron};

use super::pairs::{BakedPair, Placed};

/// Kind of a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairQuery {
    /// Penetration depth, normal and points.
    Contact,
    /// Yes or no.
    Intersects,
    /// Distance and nearest points.
    Distance,
}

impl PairQuery {
    /// All queries, in the order of tables.
    pub const ALL: [PairQuery; 3] = [PairQuery::Contact, PairQuery::Intersects, PairQuery::Distance];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            PairQuery::Contact => "contact",
            PairQuery::Intersects => "intersects",
            PairQuery::Distance => "distance",
        }
    }
}

/// Cost of an answer of hullmap.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cost {
    /// Number of pairs of support queries.
    pub support_calls: u32,
    /// Number of steps of all phases.
    pub iterations: u32,
}

/// One query of hullmap. The answer is not copied, and neither is parry's.
#[inline]
pub fn hullmap(
    query: PairQuery,
    [a, b]: &[Hull<'_>; 2],
    placed: &Placed,
    settings: &Settings,
    cache: &mut Cache,
) -> Cost {
    match query {
        PairQuery::Contact => {
            let c = contact(a, b, placed.b_in_a, settings, cache);
            black_box(&c);
            Cost { support_calls: c.support_calls, iterations: c.iterations }
        }
        PairQuery::Intersects => {
            let c = intersects(a, b, placed.b_in_a, cache);
            black_box(&c);
            Cost { support_calls: c.support_calls, iterations: c.iterations }
        }
        PairQuery::Distance => {
            let c = distance(a, b, placed.b_in_a, settings, cache);
            black_box(&c);
            Cost { support_calls: c.support_calls, iterations: c.iterations }
        }
    }
}

/// One query of parry.
#[inline]
fn parrys(query: PairQuery, [a, b]: &[ConvexPolyhedron; 2], placed: &Placed) {
    const SUPPORTED: &str = "parry supports two polyhedra";
    match query {
        PairQuery::Contact => {
            black_box(&query::contact(&math::Pose::IDENTITY, a, &placed.parry, b, 0.0).expect(SUPPORTED));
        }
        PairQuery::Intersects => {
            black_box(&query::intersection_test(&math::Pose::IDENTITY, a, &placed.parry, b).expect(SUPPORTED));
        }
        PairQuery::Distance => {
            black_box(&query::distance(&math::Pose::IDENTITY, a, &placed.parry, b).expect(SUPPORTED));
        }
    }
}

/// Times of one engine on one list of queries, in pieces of a few queries.
///
/// The pieces are short compared with a time slice of the operating system. If another process gets
/// the processor in between, it spoils one piece in one round only.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    piece: usize,
    queries: usize,
    /// Piece by piece, round by round, in nanoseconds.
    times_ns: Vec<Vec<f64>>,
}

impl Samples {
    /// An empty record of `queries` queries in pieces of `piece` each.
    pub fn new(queries: usize, piece: usize) -> Self {
        Self { piece, queries, times_ns: vec![Vec::new(); queries.div_ceil(piece)] }
    }

    /// Times all `items`, piece by piece.
    fn round<T>(&mut self, items: &[T], mut run: impl FnMut(&T)) {
        debug_assert_eq!(items.len(), self.queries);
        let mut start = Instant::now();
        for (piece, times_ns) in black_box(items).chunks(self.piece).zip(&mut self.times_ns) {
            piece.iter().for_each(&mut run);
            let end = Instant::now();
            times_ns.push((end - start).as_secs_f64() * 1e9);
            start = end;
        }
    }

    /// Time of all queries together, in nanoseconds: the sum over the pieces of the lower quartile
    /// over the rounds.
    pub fn total_ns(&self) -> f64 {
        self.times_ns.iter().map(|rounds| lower_quartile(rounds)).sum()
    }

    /// Number of queries in a round.
    pub fn queries(&self) -> usize {
        self.queries
    }

    /// A round with empty caches.
    pub fn cold(&mut self, query: PairQuery, hulls: &[Hull<'_>; 2], poses: &[Placed]) {
        let settings = Settings::default();
        self.round(poses, |placed| {
            hullmap(query, hulls, placed, &settings, &mut Cache::default());
        });
    }

    /// A round of `frames`, in which `paths` paths take turns, with a cache for each path. The
    /// caches are empty at the start of the round.
    pub fn warm(&mut self, query: PairQuery, hulls: &[Hull<'_>; 2], frames: &[Placed], paths: usize) {
        let settings = Settings::default();
        let mut caches = vec![Cache::default(); paths];
        let mut path = 0;
        self.round(frames, |placed| {
            hullmap(query, hulls, placed, &settings, &mut caches[path]);
            path = if path + 1 == paths { 0 } else { path + 1 };
        });
    }

    /// A round of parry.
    pub fn parry(&mut self, query: PairQuery, pair: &BakedPair, poses: &[Placed]) {
        self.round(poses, |placed| parrys(query, pair.polyhedra(), placed));
    }
}

/// The lower quartile; infinite without values. Not the median: other work on the machine only adds
/// time, and on a busy machine it adds some to more than half of the long queries.
fn lower_quartile(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len().saturating_sub(1) / 4).copied().unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spoilt_pieces_do_not_count() {
        let mut samples = Samples::new(5, 2);
        for times in [[700.0, 2.0, 3.0], [1.0, 900.0, 3.0], [800.0, 2.0, 3.0]] {
            samples.times_ns.iter_mut().zip(times).for_each(|(piece, time)| piece.push(time));
        }
        assert_eq!((samples.total_ns(), samples.queries()), (6.0, 5));
    }

    #[test]
    fn each_round_queries_every_item_once() {
        let mut samples = Samples::new(5, 2);
        let mut seen = Vec::new();
        samples.round(&[1, 2, 3, 4, 5], |item| seen.push(*item));
        assert_eq!(seen, [1, 2, 3, 4, 5]);
        assert!(samples.total_ns() > 0.0 && samples.times_ns.len() == 3);
    }
}
