//! Batch queries: many pairs in one call, on all threads.
//!
//! With the feature `parallel`, rayon distributes the pairs over the threads of the current pool.
//! Without it, the calling thread solves them in order. Every pair has a cache of its own, so the
//! answers are bit-identical to single queries, for any number of threads. They are written to the
//! caller's slice, in the order of the pairs, without allocation per pair.
//!
//! If the shapes of a batch are larger than the caches, queries wait for memory. Then each thread
//! keeps several support queries, intersection tests or distances in flight, so that they wait at
//! the same time. Contacts and manifolds fetch the next shapes while they compute, and contacts of
//! large hulls are in flight as well. A batch decides by the size of its shapes, and its answers
//! have the same bits in each case.
//!
//! # Stack
//! Contacts in flight take 64 KB in addition to [`Settings::stack_size`](crate::Settings).
//!
//! # Reference
//! Kenwright, section 4.6 (threading) and 4.7 (data per pair).

#![forbid(unsafe_code)]

mod ahead;
mod in_flight;
mod moving_pair;
mod pair;
mod plan;
mod query;
#[cfg(test)]
mod tests;

use self::in_flight::{CONTACTS_IN_FLIGHT, IN_FLIGHT};
pub use self::moving_pair::{MovingPair, clear};
pub use self::pair::{Pair, SupportQuery};
use self::plan::Plan;
use self::query::BatchQuery;
use crate::manifold::{Manifold, ManifoldSettings};
use crate::shapes::Shape;
use crate::solver::{Cache, Contact, ContactQuery, Distance, DistanceQuery, Intersection, IntersectionQuery, Settings};
use crate::support::SupportPoint;

/// Minimum number of pairs per task: about 20 µs of work, ten times the cost of handing a task to
/// another thread.
#[cfg(feature = "parallel")]
const MIN_PAIRS: usize = 32;

/// Number of intersection tests per task, of which several are in flight.
#[cfg(feature = "parallel")]
const MIN_TESTS: usize = 128;

/// Number of support queries per task: about 20 µs of work.
#[cfg(feature = "parallel")]
const MIN_SUPPORT_QUERIES: usize = 512;

/// The slices of a batch differ in length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a batch of {pairs} pairs requires {pairs} caches and {pairs} answers, found {caches} and {answers}: \
     pass slices of equal length"
)]
pub struct BatchError {
    /// Number of pairs.
    pub pairs: usize,
    /// Number of caches.
    pub caches: usize,
    /// Number of answers, or of manifolds.
    pub answers: usize,
}

/// Writes the [support point](crate::SupportMap::support_point) of `queries[i]` to `out[i]`.
///
/// # Errors
/// [`BatchError`] if the slices differ in length. Nothing is written in that case.
///
/// # Complexity
/// The sum over the single queries, divided among the threads. No allocation. On thousands of
/// different hulls, half of the time of single queries or less.
pub fn support_points<S>(queries: &[SupportQuery<'_, S>], out: &mut [SupportPoint]) -> Result<(), BatchError>
where
    S: Shape + Sync + ?Sized,
{
    check_lengths(queries.len(), queries.len(), out.len())?;
    let plan = Plan::of_shapes(queries.len(), |at| queries.get(at).map(|query| query.shape));
    let solve = |queries: &[SupportQuery<'_, S>], out: &mut [SupportPoint]| match plan {
        Plan::Loop => queries.iter().zip(out).for_each(|(query, out)| *out = query.shape.support_point(query.dir)),
        Plan::Ahead => ahead::support_points(queries, out),
        Plan::InFlight => in_flight::support_points(queries, out),
    };
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        queries
            .par_chunks(MIN_SUPPORT_QUERIES)
            .zip(out.par_chunks_mut(MIN_SUPPORT_QUERIES))
            .for_each(|(queries, out)| solve(queries, out));
    }
    #[cfg(not(feature = "parallel"))]
    solve(queries, out);
    Ok(())
}

/// Writes the [`contact`](crate::contact()) of each `pairs[i]` to `out[i]`, using `caches[i]`.
///
/// # Errors
/// [`BatchError`] if the slices differ in length. Nothing is written in that case.
///
/// # Complexity
/// The sum over the single queries, divided among the threads. No allocation per pair.
pub fn contact<A, B>(
    pairs: &[Pair<'_, A, B>],
    settings: &Settings,
    caches: &mut [Cache],
    out: &mut [Contact],
) -> Result<(), BatchError>
where
    A: Shape + Sync + ?Sized,
    B: Shape + Sync + ?Sized,
{
    let plan = Plan::of_contacts(pairs);
    answer_all::<A, B, ContactQuery, CONTACTS_IN_FLIGHT>(plan, pairs, settings, caches, out, ahead::contact)
}

/// Writes the [`distance`](crate::distance()) of each `pairs[i]` to `out[i]`, using `caches[i]`.
///
/// # Errors
/// [`BatchError`] if the slices differ in length. Nothing is written in that case.
///
/// # Complexity
/// The sum over the single queries, divided among the threads. No allocation per pair.
pub fn distance<A, B>(
    pairs: &[Pair<'_, A, B>],
    settings: &Settings,
    caches: &mut [Cache],
    out: &mut [Distance],
) -> Result<(), BatchError>
where
    A: Shape + Sync + ?Sized,
    B: Shape + Sync + ?Sized,
{
    let (plan, ahead) = (Plan::of_pairs(pairs), ahead::answer_all::<A, B, DistanceQuery>);
    answer_all::<A, B, DistanceQuery, IN_FLIGHT>(plan, pairs, settings, caches, out, ahead)
}

/// Writes whether the shapes of each `pairs[i]` [`intersect`](crate::intersects()) to `out[i]`,
/// using `caches[i]`.
///
/// # Errors
/// [`BatchError`] if the slices differ in length. Nothing is written in that case.
///
/// # Complexity
/// The sum over the single queries, divided among the threads. No allocation per pair.
pub fn intersects<A, B>(
    pairs: &[Pair<'_, A, B>],
    caches: &mut [Cache],
    out: &mut [Intersection],
) -> Result<(), BatchError>
where
    A: Shape + Sync + ?Sized,
    B: Shape + Sync + ?Sized,
{
    let (plan, ahead) = (Plan::of_pairs(pairs), ahead::answer_all::<A, B, IntersectionQuery>);
    answer_all::<A, B, IntersectionQuery, IN_FLIGHT>(plan, pairs, &(), caches, out, ahead)
}

/// Calls [`Manifold::update`] on each `manifolds[i]` for `pairs[i]`, using `caches[i]`.
///
/// # Errors
/// [`BatchError`] if the slices differ in length. Nothing is written in that case.
///
/// # Complexity
/// The sum over the single updates, divided among the threads. No allocation per pair.
pub fn manifolds<A, B>(
    pairs: &[Pair<'_, A, B>],
    settings: &ManifoldSettings,
    caches: &mut [Cache],
    manifolds: &mut [Manifold],
) -> Result<(), BatchError>
where
    A: Shape + Sync + ?Sized,
    B: Shape + Sync + ?Sized,
{
    check_lengths(pairs.len(), caches.len(), manifolds.len())?;
    match Plan::of_manifolds(pairs) {
        Plan::Ahead => in_runs(pairs, caches, manifolds, |pairs, caches, manifolds| {
            ahead::manifolds(pairs, settings, caches, manifolds);
        }),
        Plan::Loop | Plan::InFlight => each(pairs, caches, manifolds, |pair, cache, manifold| {
            manifold.update(pair.a, pair.b, pair.b_in_a, settings, cache);
        }),
    }
    Ok(())
}

/// Writes the answer of `query` for each `pairs[i]` to `out[i]`, with `caches[i]`: for pairs with
/// parts, and for queries that have no batch of their own.
///
/// # Errors
/// [`BatchError`] if the slices differ in length. Nothing is written in that case.
///
/// # Complexity
/// The sum over the single queries, divided among the threads. No allocation per pair, with caches
/// [for pairs of parts](Cache::with_pairs).
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let cubes = two_cubes();
/// use hullmap::batch::{self, Pair};
/// use hullmap::glam::DVec3;
/// use hullmap::{Cache, Contact, Pose, Settings};
///
/// // Two unit cubes, at x from 0 to 1 and from 3 to 4, and copies of them on top.
/// let at = |x| Pose::from_translation(DVec3::new(x, 0.0, 0.75));
/// let pairs = [at(0.0)?, at(2.5)?].map(|b_in_a| Pair { a: &cubes, b: &cubes, b_in_a });
/// let (mut caches, mut contacts) = (vec![Cache::with_pairs(4); 2], vec![Contact::default(); 2]);
/// batch::map(&pairs, &mut caches, &mut contacts, |pair, cache| {
///     hullmap::contact(pair.a, pair.b, pair.b_in_a, &Settings::default(), cache)
/// })?;
/// assert!(contacts.iter().all(|contact| (contact.depth - 0.25).abs() < 1e-9));
/// assert_eq!(contacts[1].parts, [1, 0]);
/// # Ok(())
/// # }
/// ```
pub fn map<P: Sync, T: Send>(
    pairs: &[P],
    caches: &mut [Cache],
    out: &mut [T],
    query: impl Fn(&P, &mut Cache) -> T + Sync,
) -> Result<(), BatchError> {
    check_lengths(pairs.len(), caches.len(), out.len())?;
    each(pairs, caches, out, |pair, cache, out| *out = query(pair, cache));
    Ok(())
}

/// Answers all pairs as planned, with up to `N` in flight.
fn answer_all<'s, A, B, Q, const N: usize>(
    plan: Plan,
    pairs: &[Pair<'s, A, B>],
    settings: &Q::Settings,
    caches: &mut [Cache],
    out: &mut [Q::Answer],
    ahead: impl Fn(&[Pair<'s, A, B>], &Q::Settings, &mut [Cache], &mut [Q::Answer]) + Sync,
) -> Result<(), BatchError>
where
    A: Shape + Sync + ?Sized,
    B: Shape + Sync + ?Sized,
    Q: BatchQuery,
{
    check_lengths(pairs.len(), caches.len(), out.len())?;
    match plan {
        Plan::Loop => each(pairs, caches, out, |pair, cache, out| *out = Q::answer(pair, settings, cache)),
        Plan::Ahead => in_runs(pairs, caches, out, |pairs, caches, out| ahead(pairs, settings, caches, out)),
        Plan::InFlight => in_runs(pairs, caches, out, |pairs, caches, out| {
            in_flight::answer_all::<A, B, Q, N>(pairs, settings, caches, out);
        }),
    }
    Ok(())
}

fn check_lengths(pairs: usize, caches: usize, answers: usize) -> Result<(), BatchError> {
    if pairs == caches && pairs == answers { Ok(()) } else { Err(BatchError { pairs, caches, answers }) }
}

/// Calls `solve` with each pair, its cache and its answer. The slices have equal lengths.
fn each<P, C, T, F>(pairs: &[P], caches: &mut [C], out: &mut [T], solve: F)
where
    P: Sync,
    C: Send,
    T: Send,
    F: Fn(&P, &mut C, &mut T) + Sync,
{
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        let outputs = caches.par_iter_mut().zip(out.par_iter_mut());
        let jobs = pairs.par_iter().zip(outputs).with_min_len(MIN_PAIRS);
        jobs.for_each(|(pair, (cache, out))| solve(pair, cache, out));
    }
    #[cfg(not(feature = "parallel"))]
    for (pair, (cache, out)) in pairs.iter().zip(caches.iter_mut().zip(out)) {
        solve(pair, cache, out);
    }
}

/// Calls `solve` with runs of pairs, their caches and their answers, of which several are in
/// flight. The slices have equal lengths.
fn in_runs<'p, 's, A, B, T, F>(pairs: &'p [Pair<'s, A, B>], caches: &mut [Cache], out: &mut [T], solve: F)
where
    A: Sync + ?Sized,
    B: Sync + ?Sized,
    T: Send,
    F: Fn(&'p [Pair<'s, A, B>], &mut [Cache], &mut [T]) + Sync,
{
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        let outputs = caches.par_chunks_mut(MIN_TESTS).zip(out.par_chunks_mut(MIN_TESTS));
        let jobs = pairs.par_chunks(MIN_TESTS).zip(outputs);
        jobs.for_each(|(pairs, (caches, out))| solve(pairs, caches, out));
    }
    #[cfg(not(feature = "parallel"))]
    solve(pairs, caches, out);
}
