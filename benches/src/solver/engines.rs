//! The three queries, ours and parry3d's own: `query::contact` without prediction, `query::intersection_test` and
//! `query::distance`. Our settings are the defaults.

use std::{hint::black_box, time::Instant};

use hullmap::{Cache, Hull, Settings, contact, distance, intersects};
use parry3d::{math, query, shape::ConvexPolyhedron};

use super::pairs::{Pair, Placed};

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// Penetration depth, normal and points.
    Contact,
    /// Yes or no.
    Intersects,
    /// Distance and nearest points.
    Distance,
}

impl Query {
    /// All queries, in the order of tables.
    pub const ALL: [Query; 3] = [Query::Contact, Query::Intersects, Query::Distance];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Query::Contact => "contact",
            Query::Intersects => "intersects",
            Query::Distance => "distance",
        }
    }
}

/// What our answer took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cost {
    /// Pairs of support queries.
    pub support_calls: u32,
    /// Steps of all phases.
    pub iterations: u32,
}

/// One of ours.
#[inline]
pub fn ours(query: Query, [a, b]: &[Hull<'_>; 2], placed: &Placed, settings: &Settings, cache: &mut Cache) -> Cost {
    match query {
        Query::Contact => {
            let c = black_box(contact(a, b, placed.b_in_a, settings, cache));
            Cost { support_calls: c.support_calls, iterations: c.iterations }
        }
        Query::Intersects => {
            let c = black_box(intersects(a, b, placed.b_in_a, cache));
            Cost { support_calls: c.support_calls, iterations: c.iterations }
        }
        Query::Distance => {
            let c = black_box(distance(a, b, placed.b_in_a, settings, cache));
            Cost { support_calls: c.support_calls, iterations: c.iterations }
        }
    }
}

/// One of parry's.
#[inline]
fn parrys(query: Query, [a, b]: &[ConvexPolyhedron; 2], placed: &Placed) {
    const SUPPORTED: &str = "parry takes two polyhedra";
    match query {
        Query::Contact => {
            black_box(query::contact(&math::Pose::IDENTITY, a, &placed.parry, b, 0.0).expect(SUPPORTED));
        }
        Query::Intersects => {
            black_box(query::intersection_test(&math::Pose::IDENTITY, a, &placed.parry, b).expect(SUPPORTED));
        }
        Query::Distance => {
            black_box(query::distance(&math::Pose::IDENTITY, a, &placed.parry, b).expect(SUPPORTED));
        }
    }
}

/// Times of one engine on one list of queries, in pieces of a few queries.
///
/// The pieces are short beside a time slice of the operating system: where it gives the processor to somebody else in
/// between, that spoils the piece of that round and no more.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    piece: usize,
    queries: usize,
    /// Piece by piece, round by round, in nanoseconds.
    times_ns: Vec<Vec<f64>>,
}

impl Samples {
    /// No times yet, of `queries` in pieces of `piece` each.
    pub fn new(queries: usize, piece: usize) -> Self {
        Self { piece, queries, times_ns: vec![Vec::new(); queries.div_ceil(piece)] }
    }

    /// Asks all of `items` and keeps what it took.
    fn round<T>(&mut self, items: &[T], mut ask: impl FnMut(&T)) {
        debug_assert_eq!(items.len(), self.queries);
        let mut start = Instant::now();
        for (piece, times_ns) in black_box(items).chunks(self.piece).zip(&mut self.times_ns) {
            piece.iter().for_each(&mut ask);
            let end = Instant::now();
            times_ns.push((end - start).as_secs_f64() * 1e9);
            start = end;
        }
    }

    /// What all queries take together, in nanoseconds: of each piece the lower quartile over the rounds.
    pub fn total_ns(&self) -> f64 {
        self.times_ns.iter().map(|rounds| lower_quartile(rounds)).sum()
    }

    /// How many queries a round has.
    pub fn queries(&self) -> usize {
        self.queries
    }

    /// A round with nothing remembered.
    pub fn cold(&mut self, query: Query, hulls: &[Hull<'_>; 2], poses: &[Placed]) {
        let settings = Settings::default();
        self.round(poses, |placed| {
            ours(query, hulls, placed, &settings, &mut Cache::default());
        });
    }

    /// A round of the `frames` of that many `paths`, which take turns, with a cache kept for each path. The caches are empty at
    /// first.
    pub fn warm(&mut self, query: Query, hulls: &[Hull<'_>; 2], frames: &[Placed], paths: usize) {
        let settings = Settings::default();
        let mut caches = vec![Cache::default(); paths];
        let mut path = 0;
        self.round(frames, |placed| {
            ours(query, hulls, placed, &settings, &mut caches[path]);
            path = if path + 1 == paths { 0 } else { path + 1 };
        });
    }

    /// A round of parry's.
    pub fn parry(&mut self, query: Query, pair: &Pair, poses: &[Placed]) {
        self.round(poses, |placed| parrys(query, pair.polyhedra(), placed));
    }
}

/// The lower quartile; infinite without values. Not the median: other work on the machine only ever adds time, and on a busy one
/// it adds some to more than half of the long queries.
fn lower_quartile(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len().saturating_sub(1) / 4).copied().unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spoilt_piece_does_not_count() {
        let mut samples = Samples::new(5, 2);
        for times in [[700.0, 2.0, 3.0], [1.0, 900.0, 3.0], [800.0, 2.0, 3.0]] {
            samples.times_ns.iter_mut().zip(times).for_each(|(piece, time)| piece.push(time));
        }
        assert_eq!((samples.total_ns(), samples.queries()), (6.0, 5));
    }

    #[test]
    fn every_item_is_asked_once_a_round() {
        let mut samples = Samples::new(5, 2);
        let mut seen = Vec::new();
        samples.round(&[1, 2, 3, 4, 5], |item| seen.push(*item));
        assert_eq!(seen, [1, 2, 3, 4, 5]);
        assert!(samples.total_ns() > 0.0 && samples.times_ns.len() == 3);
    }
}
