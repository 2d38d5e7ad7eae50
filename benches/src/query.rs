//! Rivals, and the loops that query them.
//!
//! A [`Rival`] owns its tables. Its [`Query`](Rival::Query) borrows them and holds the state a
//! caller would keep between queries. The loops are methods of [`Contestant`], which every rival
//! implements through [`Entry`]. There is one virtual call for each batch; inside it `support` is
//! static and inlined, as in a caller's own loop.

use std::{
    hint::black_box,
    time::{Duration, Instant},
};

use glam::Vec3;
use shapes::rng::SplitMix64;

use crate::eviction::Eviction;

/// Factor of the last answer when it is added to the next direction. It is far below half an ulp of
/// any coordinate above 1e-12. So the direction does not change, but the processor has to wait for
/// the answer.
const DEPENDENCE: f32 = 1e-20;

/// Maximum memory of all copies of one rival, in bytes.
const COPIES_BYTES: usize = 32 << 20;

/// Minimum and maximum number of copies of one rival.
const COPIES_COUNT: [usize; 2] = [4, 128];

/// Answers support queries, and may keep state between them.
pub trait SupportQuery {
    /// A vertex with the maximum dot product with `dir`, up to [`crate::regret::EXACT`].
    fn support(&mut self, dir: Vec3) -> Vec3;
}

/// A method of answering support queries on one hull.
pub trait Rival: Sized {
    /// The tables, borrowed, and the state between queries.
    type Query<'a>: SupportQuery
    where
        Self: 'a;

    /// Its name in tables.
    fn name(&self) -> &str;

    /// Bytes in addition to one copy of the coordinates (12 per vertex).
    fn index_bytes(&self) -> usize;

    /// Approximate number of bytes of a copy.
    fn footprint_bytes(&self) -> usize;

    /// A query with empty state.
    fn query(&self) -> Self::Query<'_>;

    /// A copy in memory of its own.
    fn duplicate(&self) -> Self;
}

/// How the queries of a batch follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Each direction is known in advance, so that the processor overlaps queries.
    Independent,
    /// Each direction depends on the last answer, so that queries do not overlap.
    Dependent,
}

/// A rival behind an object-safe interface: one virtual call per batch, not per query.
pub trait Contestant {
    /// [`Rival::name`].
    fn name(&self) -> &str;

    /// [`Rival::index_bytes`].
    fn index_bytes(&self) -> usize;

    /// Time to build the index, if it was measured.
    fn build_time(&self) -> Option<Duration>;

    /// Queries all `dirs` twice, and times the second pass. So the tables they lead to are in the
    /// cache, as far as they fit.
    fn run(&self, flow: Flow, dirs: &[Vec3]) -> Duration;

    /// Creates the copies for [`run_cold`](Self::run_cold).
    fn stock_copies(&mut self);

    /// Empties the caches, then queries each copy once, in random order, each direction depending
    /// on the last answer. Returns the time and the number of queries.
    ///
    /// The shuffle brings the pointers and lengths of a copy's tables back into the cache. So only
    /// the tables miss, as for a hull whose object the broad phase has just visited. Panics without
    /// [`stock_copies`](Self::stock_copies).
    fn run_cold(&self, dirs: &[Vec3], eviction: &mut Eviction, rng: &mut SplitMix64) -> (Duration, usize);

    /// The answers to `dirs`, in order.
    fn answers(&self, dirs: &[Vec3]) -> Vec<Vec3>;
}

/// A rival in a comparison.
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
        query_all(&mut query, flow, dirs);
        start.elapsed()
    }

    fn stock_copies(&mut self) {
        let [min, max] = COPIES_COUNT;
        let count = (COPIES_BYTES / self.rival.footprint_bytes().max(1)).clamp(min, max);
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
}

#[inline]
fn query_all<Q: SupportQuery>(query: &mut Q, flow: Flow, dirs: &[Vec3]) {
    match flow {
        Flow::Independent => _ = black_box(independent(query, dirs)),
        Flow::Dependent => _ = black_box(dependent(query, dirs)),
    }
}

/// Combines the bits of all answers, so that no query can be optimised away.
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
