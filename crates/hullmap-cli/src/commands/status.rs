//! `bake farm status`: which packs of a build are missing or stale, by their headers.
//!
//! Meshes are not read, and packs only if their options seem to differ: fast enough for a million
//! packs on a network file system. `bake build --check` also notices changed meshes.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read};

use hullmap::{Asset, OpenError, Pack};
use hullmap_format::header::{FileKind, HEADER_LEN, Header, options_hash};
use hullmap_import::open_regular;
use rayon::prelude::*;
use serde::Serialize;

use crate::args::StatusArgs;
use crate::rows::jobs_of_folders;
use crate::table::{Table, or_dash};
use crate::terminal::Output;
use hullmap_geometry::number::grouped;
use hullmap_pipeline::jobs::Job;
use hullmap_pipeline::jobs::shard::shard_of;
use hullmap_pipeline::outcome::{Exit, Failure, end};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum State {
    /// Complete, of this format version, with these options.
    Present,
    /// Incomplete, of another format version, or with other options.
    Stale,
    Missing,
}

/// One pack. Field names are the JSON's.
#[derive(Debug, Serialize)]
struct Row {
    source: String,
    output: String,
    status: State,
    reason: Option<String>,
    shard: Option<u32>,
}

pub fn run(args: &StatusArgs, out: &mut Output) -> Result<Exit, Failure> {
    let (jobs, exit) = jobs_of_folders(&args.meshes, &args.out)?;
    let rows: Vec<Row> = jobs.par_iter().map(|job| row(job, args.shards)).collect();
    let is_complete = rows.iter().all(|row| row.status == State::Present);
    let exit = exit.max(if is_complete { Exit::Done } else { Exit::Rejected });
    end(exit, if args.json { write_json(&rows, out) } else { write_table(&rows, args.shards, out) })
}

fn row(job: &Job, shards: Option<u32>) -> Row {
    let (status, reason) = state(job);
    Row {
        source: job.source.display().to_string(),
        output: job.output.display().to_string(),
        status,
        reason,
        shard: shards.map(|count| shard_of(&job.place, count)),
    }
}

fn state(job: &Job) -> (State, Option<String>) {
    let stale = |reason: String| (State::Stale, Some(reason));
    let mut bytes = Vec::with_capacity(HEADER_LEN);
    let read = open_regular(&job.output).and_then(|file| {
        let length = file.metadata()?.len();
        file.take(HEADER_LEN as u64).read_to_end(&mut bytes)?;
        Ok(length)
    });
    let (length, header) = match read {
        Ok(length) => (length, Header::read_kind(&bytes, job.options.file_kind())),
        Err(error) if error.kind() == ErrorKind::NotFound => return (State::Missing, None),
        Err(error) => return stale(format!("the pack cannot be read: {error}")),
    };
    match header.and_then(|header| header.check_length(length).map(|()| header)) {
        Ok(header) if header.options_hash == options_hash(&job.options.to_string()) => (State::Present, None),
        // The hash of the options of a pack with warnings covers them too.
        Ok(_) => match recorded_options(job) {
            Ok(options) if options == job.options.to_string() => (State::Present, None),
            Ok(_) => stale("the options have changed".to_owned()),
            Err(error) => stale(error.to_string()),
        },
        Err(error) => stale(error.to_string()),
    }
}

fn recorded_options(job: &Job) -> Result<String, OpenError> {
    // Packs, which are many, need not be read as a whole.
    match job.options.file_kind() {
        FileKind::Pack => Pack::open_skipping_contents(&job.output).map(|pack| pack.options().to_owned()),
        FileKind::TriangleMesh | FileKind::HeightField => {
            Asset::open(&job.output).map(|asset| asset.options().to_owned())
        }
    }
}

fn write_json(rows: &[Row], out: &mut Output) -> Result<(), Failure> {
    for row in rows {
        out.json(row)?;
    }
    Ok(out.flush()?)
}

fn write_table(rows: &[Row], shards: Option<u32>, out: &mut Output) -> Result<(), Failure> {
    let mut table = Table::headed("status: | pack: | why:");
    let mut incomplete: BTreeMap<u32, usize> = BTreeMap::new();
    let mut is_empty = true;
    for row in rows.iter().filter(|row| row.status != State::Present) {
        is_empty = false;
        let word = if row.status == State::Missing { "missing" } else { "stale" };
        table.push(vec![word.to_owned(), row.output.clone(), or_dash(row.reason.as_ref(), String::clone)]);
        if let Some(shard) = row.shard {
            *incomplete.entry(shard).or_default() += 1;
        }
    }
    if !is_empty {
        table.write(out)?;
        out.line("")?;
    }
    if let Some(count) = shards {
        // As `sbatch --array` takes it.
        let list: Vec<String> = incomplete.keys().map(u32::to_string).collect();
        let list = if list.is_empty() { "none".to_owned() } else { list.join(",") };
        out.line(format_args!("incomplete shards of {count}: {list}"))?;
    }
    let count = |state| grouped(rows.iter().filter(|row| row.status == state).count() as u64);
    let [present, stale, missing] = [State::Present, State::Stale, State::Missing].map(count);
    out.line(format_args!("{present} present, {stale} stale, {missing} missing"))?;
    Ok(out.flush()?)
}
