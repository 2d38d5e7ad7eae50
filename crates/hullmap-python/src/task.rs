//! Rows of arrays in pieces, on all threads, with the GIL released.
//!
//! The pieces have a fixed size. For two shapes, each piece has a cache of its own, so the answers
//! are the same for any number of threads. `hullmap::batch` has a cache for every pair instead: for
//! a million poses of one pair that would be more than a gigabyte. Many pairs have a cache each if
//! they move, and all rows of one moment are solved before the rows of the next.

use std::sync::{Mutex, PoisonError};

use hullmap::{Cache, Pose, SharedGeometry};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;

use crate::columns::{Columns, Rows};
use crate::error::PoseError;
use crate::pairs::{Pairs, Queried};
use crate::pose::{PoseArrays, Poses};
use crate::query::cache_of;
use crate::threads::{self, Threads};

/// Poses of a piece: about 300 µs of work, a hundred times the cost of handing it to a thread.
pub const PIECE: usize = 256;

/// Rows of a piece of many pairs, as in `hullmap::batch`: few, so that one robot's pairs are enough
/// for all threads.
const PIECE_OF_MANY: usize = 32;

/// Number of pieces after which signals are looked for: less than a second of work.
const BLOCK: usize = 256;

/// How rows are cut into pieces, which threads solve in any order.
#[derive(Clone, Copy)]
pub struct Cut {
    /// Number of rows.
    pub count: usize,
    /// Rows of a piece.
    pub piece: usize,
    /// Rows of a step, at least 1. A step starts when the step before it is done.
    pub step: usize,
}

impl Cut {
    /// Rows that do not depend on each other.
    pub fn free(count: usize, piece: usize) -> Self {
        Self { count, piece, step: usize::MAX }
    }

    /// The end of the rows that are solved together from `start` on.
    fn end(self, start: usize) -> usize {
        let step = (start / self.step).saturating_add(1).saturating_mul(self.step);
        self.count.min(start.saturating_add(self.piece.saturating_mul(BLOCK).max(1))).min(step)
    }
}

/// Fills the rows of columns, and returns them as arrays. `solve` fills the rows of a piece that
/// starts at the given row, and returns the first row that it rejects, with the reason. `report` is
/// called with the share that is done.
pub fn fill<'py>(
    py: Python<'py>,
    mut columns: Columns,
    (cut, threads, report): (Cut, Threads, Option<&Bound<'_, PyAny>>),
    solve: impl Fn(usize, usize, Rows<'_>) -> Result<(), (usize, String)> + Sync,
    error: fn(String) -> PyErr,
) -> PyResult<Bound<'py, PyDict>> {
    let Cut { count, piece, step } = cut;
    let pool = if threads.is_one() || count.min(step) <= piece { None } else { Some(threads::pool(threads)?) };
    let mut start = 0;
    while start < count {
        let end = cut.end(start);
        // The first rejected row, whichever thread finds it.
        let rejected: Mutex<Option<(usize, String)>> = Mutex::new(None);
        let run = |(index, rows): (usize, Rows<'_>)| {
            let first = start + index * piece;
            if let Err(found) = solve(first, end.min(first.saturating_add(piece)) - first, rows) {
                let mut rejected = rejected.lock().unwrap_or_else(PoisonError::into_inner);
                if rejected.as_ref().is_none_or(|earlier| found.0 < earlier.0) {
                    *rejected = Some(found);
                }
            }
        };
        let columns = &mut columns;
        py.detach(|| {
            let pieces = columns.pieces(start..end, piece);
            match &pool {
                None => pieces.into_iter().enumerate().for_each(run),
                Some(pool) => pool.install(|| pieces.into_par_iter().enumerate().for_each(run)),
            }
        });
        if let Some((_, message)) = rejected.into_inner().unwrap_or_else(PoisonError::into_inner) {
            return Err(error(message));
        }
        py.check_signals()?;
        if let Some(report) = report {
            report.call1((end as f64 / count as f64,))?;
        }
        start = end;
    }
    columns.into_arrays(py)
}

/// Pairs, the poses of the second shapes in the frames of the first, and how to iterate over them.
pub struct Task<'p> {
    pub pairs: &'p Pairs,
    pub poses: Poses,
    /// Number of answers.
    pub count: usize,
    /// Rows of a piece.
    pub piece: usize,
    coherent: bool,
    /// The caches of many pairs, if they move.
    memory: Option<&'p [Mutex<Cache>]>,
    threads: Threads,
}

impl<'p> Task<'p> {
    pub fn new(queried: &'p Queried<'_>, poses: &PoseArrays<'_>, coherent: bool, threads: Threads) -> PyResult<Self> {
        let (pairs, poses) = (queried.get(), Poses::new(poses)?);
        let (piece, memory) = match queried {
            Queried::Two(_) => (PIECE, None),
            Queried::Many(_) if coherent => (PIECE_OF_MANY, Some(pairs.memory()?)),
            Queried::Many(_) => (PIECE_OF_MANY, None),
        };
        Ok(Self { count: poses.count(pairs), pairs, poses, piece, coherent, memory, threads })
    }

    /// Answers the query of each row but those whose answer is `known`; `write` writes an answer to
    /// a row.
    pub fn solve<'py, T, Q: Fn([&SharedGeometry; 2], Pose, &mut Cache) -> T>(
        &self,
        py: Python<'py>,
        (name, takes_parts): (&str, bool),
        columns: Columns,
        query: impl Fn(usize) -> Result<Q, String> + Sync,
        known: impl Fn(usize) -> Option<T> + Sync,
        write: impl Fn(&mut Rows<'_>, usize, &T) + Sync,
    ) -> PyResult<Bound<'py, PyDict>> {
        self.pairs.check(name, takes_parts)?;
        let step = self.memory.map_or(usize::MAX, |memory| memory.len().max(1));
        let cut = Cut { step, ..Cut::free(self.count, self.piece) };
        let solve = |first: usize, count: usize, mut rows: Rows<'_>| {
            let mut own = self.pairs.sides(first).map_or_else(Cache::new, cache_of);
            for at in 0..count {
                let row = first + at;
                if let Some(found) = known(row) {
                    write(&mut rows, at, &found);
                    continue;
                }
                let Some(sides) = self.pairs.sides(row) else { continue };
                let rejected = |message| (row, message);
                let pose = self.poses.get(row, self.pairs).map_err(rejected)?;
                let query = query(row).map_err(rejected)?;
                let of_pair = self.memory.and_then(|memory| memory.get(row % memory.len().max(1)));
                let found = if let Some(caches) = of_pair {
                    query(sides, pose, &mut caches.lock().unwrap_or_else(PoisonError::into_inner))
                } else {
                    if !self.coherent {
                        own.clear();
                    }
                    query(sides, pose, &mut own)
                };
                write(&mut rows, at, &found);
            }
            Ok(())
        };
        fill(py, columns, (cut, self.threads, None), solve, PoseError::new_err)
    }
}
