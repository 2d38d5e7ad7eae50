//! Several queries in flight in one thread: while one query waits for memory, the others compute.
//!
//! A look-up in a hull that is in no cache waits for two or three dependent cache misses. One query
//! needs the answer before it can state its next direction, so it waits for each of them. The
//! queries of a batch do not depend on each other.
//!
//! 1. Each query in flight is suspended, and has prefetched what it reads next: a word of a
//!    direction index, a node, or the blocks of a leaf.
//! 2. They take turns. Each runs until its next read from memory. The turns of the others give
//!    that memory some 100 ns to arrive.
//! 3. When a query has ended, the next pair takes its place. The shapes of that pair have been
//!    fetched in the meantime.
//!
//! Answers have the same bits as single queries. Suspending costs time when everything is in the
//! first caches, so a batch does it only if its shapes are larger ([`Plan`](super::plan::Plan)).
//!
//! # Tried and rejected
//! Fetching only the blocks of a leaf, with the words above it read at once, saved nothing: a
//! branch that is predicted wrongly keeps the processor from starting on the next query until
//! the word has arrived. The slots of the six cube faces are an exception, since they are fetched
//! ahead.

use super::ahead::{fetch_pairs, fetch_queries};
use super::pair::{Pair, SupportQuery};
use super::query::BatchQuery;
use crate::shapes::Shape;
use crate::solver::{Cache, Suspended};
use crate::support::simd::fetch_start;
use crate::support::{Lookup, SupportPoint};

/// Number of queries in flight. A processor core can wait for 10 to 16 cache lines at a time.
pub(super) const IN_FLIGHT: usize = 8;

/// Number of contacts in flight. The polytopes of all must stay in the first-level cache, and
/// they are on the stack: 16 KB each.
pub(super) const CONTACTS_IN_FLIGHT: usize = 3;

struct InFlight<Q, R> {
    /// The index of the pair, and its query.
    query: Option<(usize, Q)>,
    /// `None` before the first query.
    workspace: Option<R>,
}

/// Answers all pairs, `N` at a time: rounded shapes at once, all others as suspended queries. The
/// slices have equal lengths.
pub(super) fn answer_all<'s, A, B, Q, const N: usize>(
    pairs: &[Pair<'s, A, B>],
    settings: &Q::Settings,
    caches: &mut [Cache],
    out: &mut [Q::Answer],
) where
    A: Shape + ?Sized,
    B: Shape + ?Sized,
    Q: BatchQuery,
{
    // An array of workspaces would be built in copies, which take several times the stack.
    let mut in_flight =
        [const { InFlight::<Suspended<'s, A, B, Q>, Q::Workspace> { query: None, workspace: None } }; N];
    let mut rest = 0..pairs.len();
    // Starts the next query that takes a support query.
    let mut start = |workspace: &mut Q::Workspace, caches: &mut [Cache], out: &mut [Q::Answer]| {
        for at in rest.by_ref() {
            fetch_pairs(pairs, at, N);
            caches.get(at + N).into_iter().for_each(fetch_start);
            let (Some(pair), Some(cache), Some(out)) = (pairs.get(at), caches.get_mut(at), out.get_mut(at)) else {
                break;
            };
            if is_rounded(pair) {
                *out = Q::answer(pair, settings, cache);
                continue;
            }
            match Suspended::start((pair.a, pair.b, pair.b_in_a), settings, cache, workspace) {
                Ok(query) => return Some((at, query)),
                Err(answer) => *out = answer,
            }
        }
        None
    };
    let mut running = 0;
    for next in &mut in_flight {
        next.query = start(next.workspace.get_or_insert_default(), caches, out);
        running += usize::from(next.query.is_some());
    }
    while running > 0 {
        for InFlight { query: suspended, workspace } in &mut in_flight {
            let (Some((at, query)), Some(workspace)) = (suspended.as_mut(), workspace) else { continue };
            let Some(cache) = caches.get_mut(*at) else { continue };
            if let Some(answer) = query.resume(settings, cache, workspace) {
                if let Some(out) = out.get_mut(*at) {
                    *out = answer;
                }
                *suspended = start(workspace, caches, out);
                running -= usize::from(suspended.is_none());
            }
        }
    }
}

pub(super) fn is_rounded<A: Shape + ?Sized, B: Shape + ?Sized>(pair: &Pair<'_, A, B>) -> bool {
    pair.a.convex_radius() + pair.b.convex_radius() > 0.0
}

/// The support points of all queries. The slices have equal lengths.
pub(super) fn support_points<S: Shape + ?Sized>(queries: &[SupportQuery<'_, S>], out: &mut [SupportPoint]) {
    for (wave, out) in out.chunks_mut(IN_FLIGHT).enumerate() {
        let start = wave * IN_FLIGHT;
        (start..start + out.len()).for_each(|at| fetch_queries(queries, at, IN_FLIGHT));
        let queries = queries.get(start..start + out.len()).unwrap_or_default();
        let mut lookups = [Lookup::WHOLE; IN_FLIGHT];
        for (lookup, query) in lookups.iter_mut().zip(queries) {
            *lookup = query.shape.start_lookup(query.dir);
        }
        while !lookups.iter().all(Lookup::is_ready) {
            for (lookup, query) in lookups.iter_mut().zip(queries) {
                *lookup = query.shape.continue_lookup(query.dir, *lookup);
            }
        }
        for ((query, lookup), out) in queries.iter().zip(lookups).zip(out) {
            *out = query.shape.finish_lookup(query.dir, lookup);
        }
    }
}
