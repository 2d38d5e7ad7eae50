use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use hullmap_import::unread_format;

use super::orphans;
use crate::args::BuildArgs;
use crate::depfile::{self, Rule};
use crate::rows::{self, Messages, print_messages, run_jobs, write_rows};
use crate::terminal::Output;
use hullmap_pipeline::content::beside;
use hullmap_pipeline::jobs::search::without_meshes;
use hullmap_pipeline::jobs::{Job, Jobs};
use hullmap_pipeline::outcome::{Exit, Failure, end};
use hullmap_pipeline::pack_file::{folder_of, link_below, make_folder, put_in_place, sweep, sweep_below, write_beside};
use hullmap_pipeline::runner::cache::Cache;
use hullmap_pipeline::runner::one::{Baker, Build};
use hullmap_pipeline::runner::rows::{Row, Status};

pub fn run(args: &BuildArgs, project: &Path, baker: &Baker, out: &mut Output) -> Result<Exit, Failure> {
    let found = find_jobs(args, true)?;
    build(args, project, baker, &found, |_| true, out)
}

/// The files to bake, with options. If `warns`, prints warnings about options without effect.
pub fn find_jobs(args: &BuildArgs, warns: bool) -> Result<Jobs, Failure> {
    if args.prune && !args.meshes.only.is_empty() {
        return Err(Failure::usage("--prune: needs the build of the whole project; name no inputs"));
    }
    if args.prune && !bakes_folders(args) {
        let message = "--prune has no effect, because no input is a folder; name the folder of the meshes";
        return Err(Failure::usage(message));
    }
    let printed = match (warns, args.run.verbose) {
        (false, _) => Messages::Silent,
        (true, false) => Messages::Warnings,
        (true, true) => Messages::All,
    };
    rows::find_jobs(&args.meshes, &args.out, printed)
}

pub fn build(
    args: &BuildArgs,
    project: &Path,
    baker: &Baker,
    found: &Jobs,
    chosen: impl Fn(&Job) -> bool,
    out: &mut Output,
) -> Result<Exit, Failure> {
    let Jobs { jobs, unread, empty, folders } = found;
    let is_ours = |place: &str| args.shard.is_none_or(|shard| shard.holds(place));
    let chosen: Vec<&Job> = jobs.iter().filter(|job| is_ours(&job.place) && chosen(job)).collect();
    if !args.check {
        make_folder(&args.out).map_err(|error| {
            Failure::usage(format!("{}: cannot create this folder: {error}; check the path", args.out.display()))
        })?;
        // A killed bake may have left temporary files of meshes that are gone. A build of single
        // files skips this walk; the first shard does it for all shards.
        if bakes_folders(args) && args.shard.is_none_or(|shard| shard.index() == 0) {
            sweep_below(&args.out);
        }
        let outputs = chosen.iter().map(|job| job.output.as_path());
        let folders: BTreeSet<&Path> = outputs.chain(args.depfile.as_deref()).map(folder_of).collect();
        folders.into_iter().filter(|folder| link_below(&args.out, folder).is_none()).for_each(sweep);
    }
    let cache = args.cache.as_deref().map(Cache::new);
    let build = Build {
        limits: args.meshes.limits.limits(),
        verify: args.verify,
        force: args.force,
        check: args.check,
        cache: cache.as_ref(),
        out: &args.out,
        project,
        baker,
    };
    let results = run_jobs(&chosen, &build, &args.run)?;
    let mut exit = results.iter().map(|(_, exit)| *exit).max().unwrap_or(Exit::Done);
    let mut rows: Vec<Row> = results.into_iter().map(|(row, _)| row).collect();
    for folder in empty {
        let mut row = Row::new(folder.display().to_string(), String::new(), Status::Failed);
        row.error = Some(without_meshes(folder));
        exit = exit.max(Exit::Usage);
        rows.push(row);
    }
    if bakes_folders(args) && args.meshes.only.is_empty() {
        // A folder without meshes may be on a disk that is missing: its packs are kept.
        let inputs: Vec<PathBuf> = args.meshes.inputs.iter().filter(|input| !empty.contains(input)).cloned().collect();
        let orphans = orphans::find(&args.out, &inputs, jobs, project);
        for orphan in orphans.into_iter().filter(|orphan| is_ours(&orphan.place(&args.out))) {
            let row = orphan.row(&args.out, args.prune && !args.check);
            if row.error.is_some() {
                exit = exit.max(Exit::Usage);
            } else if args.check && args.prune && !orphan.is_kept() {
                exit = exit.max(Exit::Rejected);
            }
            rows.push(row);
        }
    }
    for unread in unread.iter().filter(|unread| is_ours(&unread.place)) {
        let mut row = Row::new(unread.source.display().to_string(), String::new(), Status::Unread);
        row.reason = unread_format(&unread.source).map(|format| format!("{format} is not supported"));
        rows.push(row);
    }
    // Results are printed even if the depfile cannot be written.
    let target = args.depfile_target.as_deref();
    let depfile = args.depfile.as_ref().map_or(Ok(()), |path| write_depfile(path, target, &chosen, folders));
    print_messages(&rows, &args.run, args.prune);
    let exit = end(exit, write_rows(&rows, &args.run, args.check, out))?;
    depfile.map(|()| exit)
}

fn bakes_folders(args: &BuildArgs) -> bool {
    args.meshes.inputs.iter().any(|input| input.is_dir())
}

/// Writes the dependencies of each pack: the mesh, its buffers, and its `hullmap.toml`. A single
/// target depends on the folders, too, which change if a mesh is added.
fn write_depfile(path: &Path, target: Option<&Path>, jobs: &[&Job], folders: &[PathBuf]) -> Result<(), Failure> {
    let mut rules = Vec::new();
    for job in jobs {
        let beside = beside(&job.source, &job.options).map_err(|error| {
            let source = job.source.display();
            Failure::usage(format!(
                "{}: not written, because {source} cannot be read: {error}; check the mesh",
                path.display()
            ))
        })?;
        let own = [Some(job.source.clone()), job.config.clone()].into_iter().flatten();
        rules.push(Rule { target: job.output.clone(), prerequisites: own.chain(beside).collect() });
    }
    if let Some(target) = target {
        let files = rules.into_iter().flat_map(|rule| rule.prerequisites);
        let all: BTreeSet<PathBuf> = files.chain(folders.iter().cloned()).collect();
        rules = vec![Rule { target: target.to_owned(), prerequisites: all.into_iter().collect() }];
    }
    depfile::text(&rules)
        .and_then(|text| write_beside(path, text.as_bytes()))
        .and_then(|file| put_in_place(file, path))
        .map_err(|error| Failure::usage(format!("{}: cannot write the depfile: {error}", path.display())))
}
