//! Runs jobs on this machine, in parallel and independently.
//!
//! | module | concept |
//! |---|---|
//! | [`one`] | one job: read, import, bake, verify, rename |
//! | [`cache`] | finished packs by key, in a folder that several machines share |
//! | [`freshness`] | whether a pack is up to date |
//! | [`memory`] | how much memory a job takes |
//! | [`schedule`] | which job is started next, within a memory limit |
//! | [`rows`] | results |

pub mod cache;
pub mod freshness;
pub mod memory;
pub mod one;
pub mod rows;
pub mod schedule;

use std::path::Path;
use std::sync::Arc;

use hullmap_bake::progress::Progress;

use crate::jobs::Job;
use crate::outcome::{Exit, Failure};
use one::Build;
use rows::{Row, Status};

/// Threads and memory that a build may use.
#[derive(Clone, Copy, Debug)]
pub struct Resources {
    /// Number of threads; `None`: one per core.
    pub threads: Option<u16>,
    /// Maximum memory in bytes for files in progress; a file that needs more is baked alone.
    pub memory: u64,
}

/// Learns how far a build is. Methods may be called from any thread.
pub trait Observer: Sync {
    /// A file is begun, whose work has this cost. Returns how much of it is done, for its thread to
    /// count.
    fn begin(&self, index: usize, name: &Path, cost: u64) -> Arc<Progress>;
    /// A file is finished.
    fn end(&self, index: usize, status: Status);
    /// Called ten times a second.
    fn tick(&self);
}

/// Starts threads; `None`: one per core.
pub fn threads(count: Option<u16>) -> Result<rayon::ThreadPool, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count.map_or(0, usize::from)).build();
    pool.map_err(|error| Failure::usage(format!("cannot start threads: {error}")))
}

/// Runs jobs in parallel; the results have the order of the jobs. `observe` makes an observer of
/// this many files, and the sum of their costs.
pub fn run<O: Observer>(
    jobs: &[&Job],
    build: &Build,
    resources: Resources,
    observe: impl FnOnce(usize, u64) -> O,
) -> Result<Vec<(Row, Exit)>, Failure> {
    let pool = threads(resources.threads)?;
    let costs: Vec<u64> = jobs.iter().map(|job| memory::estimate(job)).collect();
    let observer = observe(jobs.len(), costs.iter().sum());
    let work = |index: usize| {
        let job = jobs[index];
        let done = observer.begin(index, &job.source, costs[index]);
        let (row, exit) = build.run(job, done.whole());
        observer.end(index, row.status);
        (row, exit)
    };
    Ok(schedule::run_bounded(&pool, &costs, resources.memory, work, || observer.tick()))
}
