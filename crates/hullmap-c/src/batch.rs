//! Many pairs on all cores: each pair is one query of its own, so answers do not depend on the
//! number of threads.

#![forbid(unsafe_code)]

use std::mem::MaybeUninit;
use std::ops::DerefMut;
use std::sync::MutexGuard;

use hullmap::ManifoldSettings;
use rayon::prelude::*;

use crate::failure::Fallible;
use crate::handles::{Cache, Empty, Manifold, Points};
use crate::query::{self, CheckedPair};
use crate::types;

/// Minimum number of pairs per task: about 20 µs of work, ten times the cost of handing a task to
/// another thread. The same as in `hullmap::batch`.
const MIN_PAIRS: usize = 32;

/// Solves each pair, with its cache if there are caches, and writes the answers.
pub(crate) fn each<T: Send>(
    pairs: &[CheckedPair<'_>],
    caches: Option<&[&Cache]>,
    out: &mut [MaybeUninit<T>],
    solve: impl Fn(&CheckedPair<'_>, &mut hullmap::Cache) -> T + Sync,
) -> Fallible<()> {
    let jobs = pairs.par_iter().zip(out).with_min_len(MIN_PAIRS);
    let Some(caches) = caches else {
        // A task reuses one empty cache.
        jobs.for_each_init(hullmap::Cache::new, |memory, (pair, out)| {
            memory.empty();
            out.write(solve(pair, memory));
        });
        return Ok(());
    };
    let mut guards = Vec::with_capacity(caches.len());
    for (index, cache) in caches.iter().enumerate() {
        guards.push(cache.0.take(format_args!("caches[{index}]"))?);
    }
    let memories: Vec<&mut hullmap::Cache> = guards.iter_mut().map(MutexGuard::deref_mut).collect();
    jobs.zip(memories).for_each(|((pair, out), memory)| {
        out.write(solve(pair, memory));
    });
    Ok(())
}

/// Updates the manifold of each pair, and writes the points.
pub(crate) fn manifolds(
    pairs: &[CheckedPair<'_>],
    settings: &ManifoldSettings,
    manifolds: &[&Manifold],
    out: &mut [MaybeUninit<types::ManifoldPoints>],
) -> Fallible<()> {
    let mut guards = Vec::with_capacity(manifolds.len());
    for (index, manifold) in manifolds.iter().enumerate() {
        guards.push(manifold.0.take(format_args!("manifolds[{index}]"))?);
    }
    let mut points: Vec<&mut Points> = guards.iter_mut().map(MutexGuard::deref_mut).collect();
    let jobs = pairs.par_iter().zip(&mut points).with_min_len(MIN_PAIRS);
    jobs.for_each(|(pair, points)| query::update(pair, settings, points));
    // The answers hold pointers, which threads do not pass on.
    for (points, out) in points.into_iter().zip(out) {
        out.write(points.answer());
    }
    Ok(())
}
