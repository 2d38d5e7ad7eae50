use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader, Write as _};
use std::path::{Path, PathBuf};

use hullmap_import::open_regular;

use crate::args::TaskArgs;
use crate::interrupt;
use crate::rows::{print_messages, run_jobs, write_rows};
use crate::terminal::Output;
use hullmap_pipeline::baker::bake_pack;
use hullmap_pipeline::jobs::Job;
use hullmap_pipeline::jobs::task::{Task, read_task};
use hullmap_pipeline::outcome::{Exit, Failure, end};
use hullmap_pipeline::pack_file::{folder_of, link_below, make_folder, put_in_place, sweep, write_beside};
use hullmap_pipeline::runner::cache::Cache;
use hullmap_pipeline::runner::one::Build;
use hullmap_pipeline::runner::rows::Row;

pub fn run(args: &TaskArgs, out: &mut Output) -> Result<Exit, Failure> {
    interrupt::catch();
    let mut exit = Exit::Done;
    let mut rows = Vec::new();
    let cache = args.cache.as_deref().map(Cache::new);
    for (folder, jobs) in jobs(args)? {
        let results = bake(args, cache.as_ref(), &folder, &jobs)?;
        exit = exit.max(results.iter().map(|(_, exit)| *exit).max().unwrap_or(Exit::Done));
        rows.extend(results.into_iter().map(|(row, _)| row));
    }
    if let Some(path) = &args.results {
        write_results(path, &rows)?;
        // Schedulers repeat a task that fails, which helps no faulty mesh. An error in the baker
        // must be seen.
        if exit == Exit::Rejected && !rows.iter().any(|row| row.is_internal) {
            exit = Exit::Done;
        }
    }
    print_messages(&rows, &args.run, false);
    end(exit, write_rows(&rows, &args.run, false, out))
}

fn jobs(args: &TaskArgs) -> Result<BTreeMap<PathBuf, Vec<Job>>, Failure> {
    let shown = args.plan.display();
    let mut reader: Box<dyn BufRead> = if args.plan == Path::new("-") {
        Box::new(std::io::stdin().lock())
    } else {
        let file = open_regular(&args.plan).map_err(|error| {
            Failure::usage(format!("{shown}: cannot read: {error}; name a file, or `-` for standard input"))
        })?;
        Box::new(BufReader::new(file))
    };
    let mut missing: BTreeSet<usize> = args.indices.iter().copied().collect();
    let mut jobs: BTreeMap<PathBuf, Vec<Job>> = BTreeMap::new();
    let mut line = 0;
    let fault = |fault: String| Failure::usage(format!("{shown}: {fault}"));
    while let Some(task) = read_task(&mut reader, &mut line).map_err(fault)? {
        let Task { task: index, out, .. } = &task;
        if !args.indices.is_empty() && !missing.remove(index) {
            continue;
        }
        let out = args.out.clone().unwrap_or_else(|| PathBuf::from(out));
        let own = task.jobs(&out).map_err(|fault| Failure::usage(format!("{shown}: task {index}: {fault}")))?;
        jobs.entry(out).or_default().extend(own);
        if !args.indices.is_empty() && missing.is_empty() {
            break;
        }
    }
    match missing.first() {
        Some(index) => Err(Failure::usage(format!("{shown}: there is no task {index}; check its number"))),
        None => Ok(jobs),
    }
}

fn bake(args: &TaskArgs, cache: Option<&Cache>, out: &Path, jobs: &[Job]) -> Result<Vec<(Row, Exit)>, Failure> {
    make_folder(out).map_err(|error| {
        Failure::usage(format!("{}: cannot create this folder: {error}; check the path", out.display()))
    })?;
    let folders: BTreeSet<&Path> = jobs.iter().map(|job| folder_of(&job.output)).collect();
    folders.into_iter().filter(|folder| link_below(out, folder).is_none()).for_each(sweep);
    let build = Build {
        limits: args.limits.limits(),
        verify: args.verify,
        force: args.force,
        check: false,
        cache,
        out,
        project: Path::new("."),
        baker: &bake_pack,
    };
    let jobs: Vec<&Job> = jobs.iter().collect();
    run_jobs(&jobs, &build, &args.run)
}

fn write_results(path: &Path, rows: &[Row]) -> Result<(), Failure> {
    let failure = |error| Failure::usage(format!("{}: cannot write the results: {error}", path.display()));
    let mut text = Vec::new();
    for row in rows {
        serde_json::to_writer(&mut text, row).map_err(|error| failure(error.into()))?;
        writeln!(text).map_err(failure)?;
    }
    write_beside(path, &text).and_then(|file| put_in_place(file, path)).map_err(failure)
}
