//! What a rival is, and the loops that ask it.
//!
//! A [`Rival`] owns its tables; its [`Query`](Rival::Query) borrows them and holds what a caller would keep between
//! queries. The loops are methods of [`Contestant`], which every rival gets: the one virtual call is a batch's, inside
//! it `support` is static and inlined as in a caller's own loop.

use std::{
    hint::black_box,
    time::{Duration, Instant},
};

use glam::Vec3;
use shapes::rng::SplitMix64;

use crate::eviction::Eviction;

/// Factor on the last answer when it is added to the next direction: far below half an ulp of any coordinate that is
/// not itself below 1e-12, so that the direction stays what it was, yet cannot be known before the answer is.
const DEPENDENCE: f32 = 1e-20;

/// Memory that the copies of one rival may take together, in bytes.
const COPIES_BYTES: usize = 32 << 20;

/// Fewest and most copies of one rival.
const COPIES_COUNT: [usize; 2] = [4, 128];

/// Answers support queries; may remember the last ones.
pub trait SupportQuery {
    /// A vertex with the greatest dot product with `dir`, or, where the rival is inexact, one not far from it.
    fn support(&mut self, dir: Vec3) -> Vec3;
}

/// A way to answer support queries on one hull.
pub trait Rival: Sized {
    /// The tables, borrowed, and the state between queries.
    type Query<'a>: SupportQuery
    where
        Self: 'a;

    /// Its name in tables.
    fn name(&self) -> &str;

    /// Whether it claims a regret of at most [`crate::regret::EXACT`] in every direction.
    fn is_exact(&self) -> bool;

    /// Bytes that it keeps besides one copy of the coordinates (12 a vertex).
    fn index_bytes(&self) -> usize;

    /// About how many bytes a copy of it takes.
    fn footprint_bytes(&self) -> usize;

    /// Starts asking: nothing is remembered yet.
    fn query(&self) -> Self::Query<'_>;

    /// The same, in memory of its own.
    fn duplicate(&self) -> Self;
}

/// How the queries of a batch follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Each direction is known beforehand, so that the processor overlaps queries.
    Independent,
    /// Each direction depends on the answer before it, so that it cannot.
    Dependent,
}

/// A rival behind a common face: calls are virtual a batch, not a query.
pub trait Contestant {
    /// [`Rival::name`].
    fn name(&self) -> &str;

    /// [`Rival::is_exact`].
    fn is_exact(&self) -> bool;

    /// [`Rival::index_bytes`].
    fn index_bytes(&self) -> usize;

    /// How long it took to build the index, where that was measured.
    fn build_time(&self) -> Option<Duration>;

    /// Asks all of `dirs` twice, and times the second pass: whatever ran before, the tables that they lead to are in the
    /// cache, as far as they fit.
    fn run(&self, flow: Flow, dirs: &[Vec3]) -> Duration;

    /// Makes the copies that [`run_cold`](Self::run_cold) goes round.
    fn stock_copies(&mut self);

    /// Empties the caches, then asks each copy once, in random order, each direction depending on the answer before it.
    /// Returns the time and the number of queries.
    ///
    /// The few words that name the copy's tables (pointers and lengths) are brought back into the cache by the shuffle:
    /// what misses is the tables, as for a hull whose object the broad phase has just touched.
    ///
    /// # Panics
    /// Without [`stock_copies`](Self::stock_copies).
    fn run_cold(&self, dirs: &[Vec3], eviction: &mut Eviction, rng: &mut SplitMix64) -> (Duration, usize);

    /// The answers to `dirs`, asked in order.
    fn answers(&self, dirs: &[Vec3]) -> Vec<Vec3>;

    /// Asks all of `dirs` once, for those who time it themselves. A rival that remembers starts without a memory.
    fn ask(&self, flow: Flow, dirs: &[Vec3]);
}

/// A rival entered for a comparison.
pub struct Entry<R> {
    rival: R,
    build_time: Option<Duration>,
    copies: Vec<R>,
}

impl<R> Entry<R> {
    /// A rival whose build was not timed.
    pub fn new(rival: R) -> Self {
        Self { rival, build_time: None, copies: Vec::new() }
    }

    /// A rival whose index took `build_time` to build.
    pub fn built_in(rival: R, build_time: Duration) -> Self {
        Self { rival, build_time: Some(build_time), copies: Vec::new() }
    }
}

impl<R: Rival> Contestant for Entry<R> {
    fn name(&self) -> &str {
        self.rival.name()
    }

    fn is_exact(&self) -> bool {
        self.rival.is_exact()
    }

    fn index_bytes(&self) -> usize {
        self.rival.index_bytes()
    }

    fn build_time(&self) -> Option<Duration> {
        self.build_time
    }

    fn run(&self, flow: Flow, dirs: &[Vec3]) -> Duration {
        let mut query = self.rival.query();
        let dirs = black_box(dirs);
        black_box(independent(&mut query, dirs));
        let start = Instant::now();
        ask(&mut query, flow, dirs);
        start.elapsed()
    }

    fn stock_copies(&mut self) {
        let [least, most] = COPIES_COUNT;
        let count = (COPIES_BYTES / self.rival.footprint_bytes().max(1)).clamp(least, most);
        self.copies = (0..count).map(|_| self.rival.duplicate()).collect();
    }

    fn run_cold(&self, dirs: &[Vec3], eviction: &mut Eviction, rng: &mut SplitMix64) -> (Duration, usize) {
        assert!(!self.copies.is_empty(), "cold queries need copies");
        let mut queries: Vec<R::Query<'_>> = self.copies.iter().map(R::query).collect();
        eviction.evict();
        for last in (1..queries.len()).rev() {
            queries.swap(last, rng.below(last + 1));
        }
        let count = queries.len().min(dirs.len());
        let dirs = black_box(&dirs[..count]);
        let start = Instant::now();
        let mut answer = Vec3::ZERO;
        for (query, &dir) in queries.iter_mut().zip(dirs) {
            answer = query.support(dir + answer * DEPENDENCE);
        }
        black_box(answer);
        (start.elapsed(), count)
    }

    fn answers(&self, dirs: &[Vec3]) -> Vec<Vec3> {
        let mut query = self.rival.query();
        dirs.iter().map(|&dir| query.support(dir)).collect()
    }

    fn ask(&self, flow: Flow, dirs: &[Vec3]) {
        ask(&mut self.rival.query(), flow, black_box(dirs));
    }
}

#[inline]
fn ask<Q: SupportQuery>(query: &mut Q, flow: Flow, dirs: &[Vec3]) {
    match flow {
        Flow::Independent => _ = black_box(independent(query, dirs)),
        Flow::Dependent => _ = black_box(dependent(query, dirs)),
    }
}

/// Sums up the bits of all answers, so that none can be left out.
#[inline(never)]
fn independent<Q: SupportQuery>(query: &mut Q, dirs: &[Vec3]) -> u32 {
    let mut checksum = 0_u32;
    for &dir in dirs {
        let [x, y, z] = query.support(dir).to_array().map(f32::to_bits);
        checksum = checksum.rotate_left(1) ^ x ^ y ^ z;
    }
    checksum
}

#[inline(never)]
fn dependent<Q: SupportQuery>(query: &mut Q, dirs: &[Vec3]) -> Vec3 {
    let mut answer = Vec3::ZERO;
    for &dir in dirs {
        answer = query.support(dir + answer * DEPENDENCE);
    }
    answer
}
