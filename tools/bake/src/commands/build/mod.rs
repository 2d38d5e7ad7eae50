//! `bake build`: bakes meshes into packs, in parallel and independently.
//!
//! 1. [`plan`] finds the meshes that [`filter`] leaves; [`Configs`] and the flags determine the
//!    options of each; [`pack_names`] names their packs.
//! 2. [`schedule`] starts the files within a memory limit; [`freshness`] finds packs that are up to
//!    date; [`job`] bakes the others.
//! 3. [`orphans`] finds packs whose source is gone; [`rows`] prints the results.

mod filter;
mod freshness;
mod job;
mod memory;
mod orphans;
mod pack_names;
mod plan;
mod progress;
mod rows;
mod schedule;
#[cfg(test)]
mod tests;
mod watch;

use std::collections::{BTreeSet, HashSet};
use std::path::{Path, PathBuf};

use crate::args::{BuildArgs, DEFAULT_MEMORY};
use crate::baker::bake_pack;
use crate::config::{Chosen, Configs, FILE_NAME};
use crate::depfile::{self, Rule};
use crate::interrupt;
use crate::options::{BuildOptions, flag};
use crate::outcome::{Exit, Failure, end};
use crate::pack_file::{folder_of, link_below, make_folder, put_in_place, sweep, sweep_below, write_beside};
use crate::terminal::{self, Output};
use filter::Filter;
use job::{Baker, Build, Job};
use pack_names::PackName;
use plan::Mesh;
use progress::Progress;
use rows::{Row, Status, write_json, write_table};

/// Runs the command.
///
/// # Errors
/// An input or `hullmap.toml` cannot be read; found before any work. Failures of single files are
/// reported in their rows and in the exit code.
pub fn run(args: &BuildArgs, out: &mut Output) -> Result<Exit, Failure> {
    interrupt::catch();
    let project = Path::new(".");
    if args.watch {
        return watch::run(args, project, &bake_pack, out);
    }
    run_with(args, project, &bake_pack, out)
}

/// Runs the command once, with any baker, in any folder.
fn run_with(args: &BuildArgs, project: &Path, baker: &Baker, out: &mut Output) -> Result<Exit, Failure> {
    let jobs = jobs(args, project, !args.quiet)?;
    build(args, project, baker, &jobs, |_| true, out)
}

/// The files to bake, each with its options. If `warns`, prints warnings about options without
/// effect. Writes no file.
fn jobs(args: &BuildArgs, project: &Path, warns: bool) -> Result<Vec<Job>, Failure> {
    if args.out.is_file() {
        return Err(Failure::usage(format!(
            "{}: is a file, but --out requires a folder; name a folder for the packs",
            args.out.display()
        )));
    }
    let mut filter = Filter::new(args);
    let meshes = plan::plan(&args.inputs, &args.out, &mut filter)?;
    for glob in filter.unused().filter(|_| warns) {
        terminal::warning(format_args!("--exclude: no mesh matches `{glob}`"));
    }
    if args.prune && warns && !bakes_folders(args) {
        terminal::note("--prune has no effect, because no input is a folder; name the folder of the meshes");
    }
    let mut configs = Configs::new(args.config.as_deref(), args.no_config, project)?;
    let mut chosen = Vec::with_capacity(meshes.len());
    for mesh in meshes {
        let Chosen { layer, skips, config } = configs.layer(&mesh.source)?;
        let config = config.map(|config| config.path.clone());
        if !skips {
            chosen.push((mesh, args.options.over(&layer).resolve(), config));
        } else if warns && (args.verbose || args.inputs.contains(&mesh.source)) {
            let (source, config) = (mesh.source.display(), config.unwrap_or_default());
            terminal::note(format_args!("{source}: left out, because {} sets skip = true", config.display()));
        }
    }
    let names: Vec<_> = chosen.iter().map(|(mesh, options, _)| (mesh, options.keeps_extension())).collect();
    let names = pack_names::pack_names(&names);
    let job = |((mesh, options, config), name): ((Mesh, BuildOptions, _), PackName)| Job {
        source: mesh.source,
        output: name.output.clone(),
        name,
        options,
        config,
    };
    let jobs: Vec<Job> = chosen.into_iter().zip(names).map(job).collect();
    if warns {
        let is_cut = |job: &Job| job.options.decompose().is_some();
        if let Some(key) = args.options.first_decomposition_parameter().filter(|_| !jobs.iter().any(is_cut)) {
            terminal::warning(format_args!(
                "--{} has no effect, because no mesh of this build is decomposed; add --decompose, or decompose = true to {FILE_NAME}",
                flag(key)
            ));
        }
        let is_cut_by = |config: &Path| jobs.iter().any(|job| job.config.as_deref() == Some(config) && is_cut(job));
        configs.warnings(&args.inputs, is_cut_by).iter().for_each(terminal::warning);
    }
    Ok(jobs)
}

/// Bakes the `chosen` jobs and prints the results.
fn build(
    args: &BuildArgs,
    project: &Path,
    baker: &Baker,
    jobs: &[Job],
    chosen: impl Fn(&Job) -> bool,
    out: &mut Output,
) -> Result<Exit, Failure> {
    let outputs: HashSet<&Path> = jobs.iter().map(|job| job.output.as_path()).collect();
    if !args.check {
        make_folder(&args.out).map_err(|error| {
            Failure::usage(format!("{}: cannot create this folder: {error}; check the path", args.out.display()))
        })?;
        // A killed bake may have had meshes that are gone now. A build of single files skips this
        // walk.
        if bakes_folders(args) {
            sweep_below(&args.out);
        }
        let folders: BTreeSet<&Path> = outputs.iter().copied().chain(args.depfile.as_deref()).map(folder_of).collect();
        folders.into_iter().filter(|folder| link_below(&args.out, folder).is_none()).for_each(sweep);
    }
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(count) = args.jobs {
        pool = pool.num_threads(usize::from(count));
    }
    let pool = pool.build().map_err(|error| Failure::usage(format!("cannot start threads: {error}")))?;

    let chosen: Vec<&Job> = jobs.iter().filter(|job| chosen(job)).collect();
    let costs: Vec<u64> = chosen.iter().map(|job| memory::estimate(job)).collect();
    let limits = args.limits.limits();
    let build =
        Build { limits, verify: args.verify, force: args.force, check: args.check, out: &args.out, project, baker };
    let progress = Progress::new(args.quiet, chosen.len(), costs.iter().sum());
    let work = |index: usize| {
        let job = chosen[index];
        progress.begin(index, job.source.display());
        let (row, exit) = build.run(job);
        progress.end(index, costs[index], row.status);
        (row, exit)
    };
    let memory = args.memory.unwrap_or(DEFAULT_MEMORY);
    let results = schedule::run_bounded(&pool, &costs, memory, work, || progress.tick());
    progress.finish();

    let mut exit = results.iter().map(|(_, exit)| *exit).max().unwrap_or(Exit::Done);
    let mut rows: Vec<Row> = results.into_iter().map(|(row, _)| row).collect();
    if bakes_folders(args) {
        for orphan in orphans::find(&args.out, &args.inputs, jobs, project) {
            let row = orphan.row(&args.out, args.prune && !args.check);
            if row.error.is_some() {
                exit = exit.max(Exit::Usage);
            } else if args.check && args.prune && !orphan.is_kept() {
                exit = exit.max(Exit::Rejected);
            }
            rows.push(row);
        }
    }
    // Results are printed even if the depfile cannot be written.
    let depfile =
        args.depfile.as_ref().map_or(Ok(()), |path| write_depfile(path, args.depfile_target.as_deref(), jobs));
    print_messages(args, &rows);
    let exit = end(exit, write_rows(args, &rows, out))?;
    depfile.map(|()| exit)
}

/// Whether an input is a folder: only then are orphans searched.
fn bakes_folders(args: &BuildArgs) -> bool {
    args.inputs.iter().any(|input| input.is_dir())
}

/// Prints notes, warnings and errors, in the order of the files.
fn print_messages(args: &BuildArgs, rows: &[Row]) {
    for row in rows {
        if !args.quiet {
            if row.status == Status::Orphaned {
                let remedy = match row.notes.first() {
                    Some(kept) => format!(", but {kept}"),
                    None if args.prune => String::new(),
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

fn write_rows(args: &BuildArgs, rows: &[Row], out: &mut Output) -> Result<(), Failure> {
    match (args.json, args.quiet) {
        (true, _) => write_json(rows, out),
        (false, true) => Ok(()),
        (false, false) => write_table(rows, args.verbose, args.check, out),
    }
}

/// Writes the dependencies of each pack: the mesh, its buffers, and its `hullmap.toml`.
fn write_depfile(path: &Path, target: Option<&Path>, jobs: &[Job]) -> Result<(), Failure> {
    let mut rules = Vec::new();
    for job in jobs {
        let buffers = hullmap_import::buffers_of(&job.source).map_err(|error| {
            let source = job.source.display();
            Failure::usage(format!(
                "{}: not written, because {source} cannot be read: {error}; check the mesh",
                path.display()
            ))
        })?;
        let own = [Some(job.source.clone()), job.config.clone()].into_iter().flatten();
        rules.push(Rule { target: job.output.clone(), prerequisites: own.chain(buffers).collect() });
    }
    if let Some(target) = target {
        let all: BTreeSet<PathBuf> = rules.into_iter().flat_map(|rule| rule.prerequisites).collect();
        rules = vec![Rule { target: target.to_owned(), prerequisites: all.into_iter().collect() }];
    }
    depfile::text(&rules)
        .and_then(|text| write_beside(path, text.as_bytes()))
        .and_then(|file| put_in_place(file, path))
        .map_err(|error| Failure::usage(format!("{}: cannot write the depfile: {error}", path.display())))
}
