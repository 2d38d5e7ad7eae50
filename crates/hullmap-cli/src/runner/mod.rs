//! Runs jobs on this machine, in parallel and independently.
//!
//! | module | concept |
//! |---|---|
//! | [`one`] | one job: read, import, bake, verify, rename |
//! | [`cache`] | finished packs by key, in a folder that several machines share |
//! | [`freshness`] | whether a pack is up to date |
//! | [`memory`] | how much memory a job takes |
//! | [`schedule`] | which job is started next, within a memory limit |
//! | [`progress`] | bars and lines while it runs |
//! | [`rows`] | results |

pub mod cache;
pub mod freshness;
pub mod memory;
pub mod one;
pub mod progress;
pub mod rows;
pub mod schedule;

use crate::args::{DEFAULT_MEMORY, RunArgs};
use crate::jobs::Job;
use crate::outcome::{Exit, Failure};
use crate::terminal::{self, Output};
use one::Build;
use progress::Progress;
use rows::{Row, Status, write_json, write_table};

pub fn run(jobs: &[&Job], build: &Build, args: &RunArgs) -> Result<Vec<(Row, Exit)>, Failure> {
    let pool = pool(args)?;
    let costs: Vec<u64> = jobs.iter().map(|job| memory::estimate(job)).collect();
    let progress = Progress::new(args.quiet, jobs.len(), costs.iter().sum());
    let work = |index: usize| {
        let job = jobs[index];
        let done = progress.begin(index, job.source.display(), costs[index]);
        let (row, exit) = build.run(job, done.whole());
        progress.end(index, row.status);
        (row, exit)
    };
    let memory = args.memory.unwrap_or(DEFAULT_MEMORY);
    let results = schedule::run_bounded(&pool, &costs, memory, work, || progress.tick());
    progress.finish();
    if let Some(cache) = build.cache
        && let Some(trouble) = cache.take_trouble()
        && !args.quiet
    {
        terminal::warning(trouble);
    }
    Ok(results)
}

pub fn pool(args: &RunArgs) -> Result<rayon::ThreadPool, Failure> {
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(count) = args.jobs {
        pool = pool.num_threads(usize::from(count));
    }
    pool.build().map_err(|error| Failure::usage(format!("cannot start threads: {error}")))
}

/// Prints messages in the order of the rows. `prunes`: orphans were to be removed.
pub fn print_messages(rows: &[Row], is_quiet: bool, prunes: bool) {
    for row in rows {
        if !is_quiet {
            if row.status == Status::Orphaned {
                let remedy = match row.notes.first() {
                    Some(kept) => format!(", but {kept}"),
                    None if prunes => String::new(),
                    None => " (--prune removes it)".to_owned(),
                };
                let reason = row.reason.as_deref().unwrap_or_default();
                terminal::note(format_args!("{}: {reason}{remedy}", row.output));
            }
            for note in row.notes.iter().filter(|_| row.status != Status::Orphaned) {
                terminal::note(format_args!("{}: {note}", row.source));
            }
            for warning in &row.warnings {
                terminal::warning(format_args!("{}: {warning}", row.source));
            }
        }
        if let Some(error) = &row.error {
            terminal::error(error);
        }
    }
}

pub fn write_rows(rows: &[Row], args: &RunArgs, is_check: bool, out: &mut Output) -> Result<(), Failure> {
    match (args.json, args.quiet) {
        (true, _) => write_json(rows, out),
        (false, true) => Ok(()),
        (false, false) => write_table(rows, args.verbose, is_check, out),
    }
}
