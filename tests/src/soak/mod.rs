//! The solver on millions of pairs. Each answer is verified by a certificate.
//!
//! The exact depth of a pair costs milliseconds; a certificate costs a microsecond. Each answer
//! comes with evidence (an axis, a normal, points that both shapes share), and brute force over
//! vertices and face planes verifies it. The certificates are written from the shapes' definitions,
//! without the solver's code and the shapes' support mappings.
//!
//! | module | what |
//! |---|---|
//! | [`model`] | a shape by its definition: extent in a direction, distance of a point from it |
//! | [`body`] | a shape with its definition |
//! | [`bodies`] | the shapes: game hulls, generated ones from slivers to points, shapes in closed form |
//! | [`meeting`] | the pose of a pair: touching, face to face, edge to edge, concentric, anywhere |
//! | [`judge`] | the certificates of pairs |
//! | [`lines`] | rays, shape casts and points, and their certificates |
//! | [`planes`] | half-spaces, and their certificates |
//! | [`manifolds`] | manifolds of moving pairs, and their certificates |
//! | [`motions`] | times of impact of shapes that move and turn, and their certificates |
//! | [`screws`] | times of impact of small hulls, in exact arithmetic |
//! | [`derivatives`] | derivatives of answers about hulls, against central differences |
//! | [`tally`] | the counts, and the wrong answers |
//!
//! The pairs of a seed are indexed, and each is generated from its index alone. So a run gives the
//! same results on any number of threads, can be split, and any pair can be reproduced.

pub mod bodies;
pub mod body;
mod claims;
pub mod derivatives;
pub mod judge;
pub mod lines;
pub mod manifolds;
pub mod meeting;
pub mod model;
pub mod motions;
pub mod planes;
pub mod screws;
pub mod tally;

use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};

use bodies::{Bodies, BodyPair};
use judge::judge_pair;
use rayon::prelude::*;
use shapes::rng::SplitMix64;
use tally::{Tally, Wrong};

/// Queries of the soak.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Queries {
    /// Intersection, contact and distance of pairs.
    Pairs,
    /// Rays at one shape.
    Rays,
    /// Shape casts of pairs.
    Casts,
    /// Signed distances of points from one shape.
    Points,
    /// Contacts, distances and casts of a half-space and one shape.
    HalfSpaces,
    /// Manifolds of pairs that move: ten updates of each pair.
    Manifolds,
    /// Times of impact of pairs that move and turn.
    Motions,
    /// Times of impact of small hulls of their own that move and turn, in exact arithmetic.
    Screws,
    /// Derivatives of distances, depths, rays and shape casts.
    Derivatives,
}

/// Judges the pairs `indices` of `seed` on `threads` threads. The tally does not depend on the
/// number of threads. Panics if they cannot be started.
pub fn soak(bodies: &Bodies<'_>, queries: Queries, seed: u64, indices: Range<u64>, threads: usize) -> Tally {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build().expect("threads start");
    let tallies = indices.into_par_iter().fold(Tally::default, |mut tally, index| {
        judge_one(bodies, queries, seed, index, &mut tally);
        tally
    });
    let join = |mut sum: Tally, tally| {
        sum.add(tally);
        sum
    };
    pool.install(|| tallies.reduce(Tally::default, join))
}

/// Judges one pair; a panic counts as wrong.
fn judge_one(bodies: &Bodies<'_>, queries: Queries, seed: u64, index: u64, tally: &mut Tally) {
    let pair = bodies.pair(seed, index);
    // A panic may leave counts incomplete, but then the run has failed.
    let judged = catch_unwind(AssertUnwindSafe(|| match queries {
        Queries::Pairs => judge_pair(&pair, tally),
        _ => judge_line(queries, &pair, tally),
    }));
    if judged.is_err() {
        tally.take_wrong(Wrong { index, what: "a panic", details: pair.to_string() });
    }
}

/// Judges a query about a line, a point, a half-space, a manifold or a motion.
fn judge_line(queries: Queries, pair: &BodyPair<'_, '_>, tally: &mut Tally) {
    let mut rng = SplitMix64::new(pair.seed.rotate_left(17) ^ pair.index.wrapping_mul(0xd6e8_feb8_6659_fd93));
    tally.pairs += 1;
    match queries {
        Queries::Pairs => {}
        Queries::Rays => lines::judge_ray(pair, &mut rng, tally),
        Queries::Casts => lines::judge_cast(pair, &mut rng, tally),
        Queries::Points => lines::judge_point(pair, &mut rng, tally),
        Queries::HalfSpaces => planes::judge(pair, &mut rng, tally),
        Queries::Manifolds => manifolds::judge(pair, &mut rng, tally),
        Queries::Motions => motions::judge(pair, &mut rng, tally),
        Queries::Screws => screws::judge(pair, &mut rng, tally),
        Queries::Derivatives => derivatives::judge(pair, &mut rng, tally),
    }
}
