//! The solver on millions of pairs, each answer judged by a certificate of its own.
//!
//! The truths of [`truth`](crate::truth) cost a millisecond a pair. A certificate costs a microsecond: the answers themselves say where
//! to look (an axis, a normal, points that both shapes share), and brute force over vertices and face planes tells whether
//! that is so. It is written from the shapes' definitions, without the solver's code and without the shapes' support mappings.
//!
//! | module | what |
//! |---|---|
//! | [`model`] | a shape as its definition: how far it reaches, how far outside of it a point is |
//! | [`cast`] | the shapes: game hulls, generated ones from slivers to points, shapes in closed form |
//! | [`meeting`] | how a pair lies: kissing, face to face, edge to edge, concentric, anywhere |
//! | [`judge`] | the certificates |
//! | [`tally`] | the counts, and what was wrong |
//!
//! Pairs of one seed are numbered and each is made from its number alone: a run is the same on any number of threads, can be
//! cut into pieces, and any pair can be had again.

pub mod cast;
pub mod judge;
pub mod meeting;
pub mod model;
pub mod tally;

use std::{
    ops::Range,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Mutex,
        atomic::{AtomicU64, Ordering},
    },
};

use cast::Cast;
use judge::judge_pair;
use tally::{Tally, Wrong};

/// Pairs that a thread takes at a time: some 20 ms of work.
const RUN: u64 = 2048;

/// Judges the pairs `numbers` of `seed` on `threads` threads. The tally does not depend on their number.
pub fn soak(cast: &Cast<'_>, seed: u64, numbers: Range<u64>, threads: usize) -> Tally {
    let next = AtomicU64::new(numbers.start);
    let sum = Mutex::new(Tally::default());
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                let mut tally = Tally::default();
                loop {
                    let start = next.fetch_add(RUN, Ordering::Relaxed);
                    if start >= numbers.end {
                        break;
                    }
                    for number in start..numbers.end.min(start + RUN) {
                        one(cast, seed, number, &mut tally);
                    }
                }
                sum.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).add(tally);
            });
        }
    });
    sum.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Judges one pair; a panic counts as wrong.
fn one(cast: &Cast<'_>, seed: u64, number: u64, tally: &mut Tally) {
    let pair = cast.pair(seed, number);
    // What a panic leaves half done are counts, of a run that has failed.
    let judged = catch_unwind(AssertUnwindSafe(|| judge_pair(&pair, tally)));
    if judged.is_err() {
        tally.take_wrong(Wrong { number, what: "a panic", details: pair.to_string() });
    }
}
