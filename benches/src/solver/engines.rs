//! The three queries of hullmap, with default settings, and of parry3d: `query::contact` without
//! prediction, `query::intersection_test` and `query::distance`.

use std::{hint::black_box, time::Instant};

use hullmap::{Cache, Hull, Settings, contact, distance, intersects};
use parry3d::{math, query, shape::ConvexPolyhedron};

use super::pairs::Placed;

/// Why parry's queries of two polyhedra cannot fail.
pub const SUPPORTED: &str = "parry supports two polyhedra";

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
pub fn hullmap(query: PairQuery, [a, b]: &[Hull<'_>; 2], placed: &Placed, cache: &mut Cache) -> Cost {
    let settings = Settings::default();
    macro_rules! cost {
        ($answer:expr) => {{
            let answer = $answer;
            black_box(&answer);
            Cost { support_calls: answer.support_calls, iterations: answer.iterations }
        }};
    }
    match query {
        PairQuery::Contact => cost!(contact(a, b, placed.b_in_a, &settings, cache)),
        PairQuery::Intersects => cost!(intersects(a, b, placed.b_in_a, cache)),
        PairQuery::Distance => cost!(distance(a, b, placed.b_in_a, &settings, cache)),
    }
}

/// One query of parry.
#[inline]
pub fn parrys(query: PairQuery, [a, b]: &[ConvexPolyhedron; 2], placed: &Placed) {
    let (here, there) = (&math::Pose::IDENTITY, &placed.parry);
    match query {
        PairQuery::Contact => _ = black_box(&query::contact(here, a, there, b, 0.0).expect(SUPPORTED)),
        PairQuery::Intersects => _ = black_box(&query::intersection_test(here, a, there, b).expect(SUPPORTED)),
        PairQuery::Distance => _ = black_box(&query::distance(here, a, there, b).expect(SUPPORTED)),
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
    pub fn round<T>(&mut self, items: &[T], mut run: impl FnMut(&T)) {
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
