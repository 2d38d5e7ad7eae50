//! `--watch`: bakes, waits for changes, and bakes what they affect, until Ctrl-C.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use notify::event::{AccessKind, AccessMode, EventKind, ModifyKind};
use notify::{Event, RecommendedWatcher, RecursiveMode, Watcher};

use super::once::{build, find_jobs};
use crate::args::BuildArgs;
use crate::interrupt;
use crate::terminal::{self, Output};
use hullmap_import::height_field::is_grid;
use hullmap_import::{is_buffer, is_source};
use hullmap_pipeline::config::FILE_NAME;
use hullmap_pipeline::jobs::Job;
use hullmap_pipeline::outcome::{Exit, Failure};
use hullmap_pipeline::pack_file::{canonical_of_gone, folder_of};
use hullmap_pipeline::packs::is_baked;
use hullmap_pipeline::runner::one::Baker;

/// A change is processed after this much quiet time, because editors save in several steps.
const QUIET: Duration = Duration::from_millis(200);

/// Maximum delay after the first change, in case changes never stop.
const MAX_DELAY: Duration = Duration::from_secs(5);

const MAX_NAMED: usize = 5;

pub fn run(args: &BuildArgs, project: &Path, baker: &Baker, out: &mut Output) -> Result<Exit, Failure> {
    let (sender, events) = channel();
    // The receiver is only gone at the end of the process.
    let watcher = notify::recommended_watcher(move |event| drop(sender.send(event)));
    let cannot =
        |error: notify::Error| Failure::usage(format!("cannot watch for changes: {error}; run without --watch"));
    let mut watcher = Watched { watcher: watcher.map_err(cannot)?, folders: BTreeSet::new() };
    // Before the first build, so that no change is missed.
    watcher.watch_all(args).map_err(cannot)?;
    let mut changed = None;
    loop {
        match once(args, project, baker, changed.as_ref(), out) {
            Ok(configs) => watcher.watch_files(&configs),
            Err(failure) if failure.message.is_empty() => return Err(failure),
            Err(failure) => terminal::error(&failure),
        }
        // The folder exists now, so it has a canonical path, as the paths of events do. If it was
        // removed and made again, its watch is gone.
        let made = args.out.canonicalize().unwrap_or_else(|_| args.out.clone());
        let _ = watcher.watcher.watch(&made, RecursiveMode::Recursive);
        terminal::say("watching for changes; press Ctrl-C to stop");
        let paths = match interrupt::idle(|| wait(&events, &made)) {
            Some(paths) => paths,
            None => return Ok(Exit::Done),
        };
        print_changes(&paths);
        changed = Some(paths);
    }
}

/// One build, of all or of what the changed paths affect. Returns the `hullmap.toml` files in use.
fn once(
    args: &BuildArgs,
    project: &Path,
    baker: &Baker,
    changed: Option<&BTreeSet<PathBuf>>,
    out: &mut Output,
) -> Result<BTreeSet<PathBuf>, Failure> {
    let is_all = changed.is_none_or(|paths| paths.iter().any(|path| !is_source(path) && !is_baked(path)));
    let mut found = find_jobs(args, is_all)?;
    if !is_all {
        // They were reported by the build of everything.
        found.unread.clear();
    }
    let is_touched = |job: &Job| match changed {
        Some(paths) if !is_all => {
            let is_changed = |path: Option<PathBuf>| path.is_none_or(|path| paths.contains(&path));
            is_changed(job.source.canonicalize().ok()) || is_changed(canonical_of_gone(&job.output))
        }
        _ => true,
    };
    build(args, project, baker, &found, is_touched, out)?;
    Ok(found.jobs.into_iter().filter_map(|job| job.config).collect())
}

struct Watched {
    watcher: RecommendedWatcher,
    folders: BTreeSet<PathBuf>,
}

impl Watched {
    fn watch_all(&mut self, args: &BuildArgs) -> Result<(), notify::Error> {
        for input in &args.meshes.inputs {
            let path = input.canonicalize().unwrap_or_else(|_| input.clone());
            if path.is_dir() {
                self.watcher.watch(&path, RecursiveMode::Recursive)?;
            } else {
                self.watch_folder_of(&path);
            }
        }
        self.watch_files(&args.meshes.config.iter().cloned().collect());
        Ok(())
    }

    fn watch_files(&mut self, files: &BTreeSet<PathBuf>) {
        for file in files {
            if let Ok(path) = file.canonicalize() {
                self.watch_folder_of(&path);
            }
        }
    }

    /// Watches a file's folder, because editors replace files and a watch would stay with the old.
    fn watch_folder_of(&mut self, file: &Path) {
        let folder = folder_of(file).to_owned();
        if self.folders.insert(folder.clone()) {
            // Watching a folder twice is harmless, and one that cannot be watched is not fatal.
            let _ = self.watcher.watch(&folder, RecursiveMode::NonRecursive);
        }
    }
}

/// The changed paths that may affect a build, once changes stop. Ignores packs, in folders below
/// `made`.
fn wait(events: &Receiver<notify::Result<Event>>, made: &Path) -> Option<BTreeSet<PathBuf>> {
    let mut paths = BTreeSet::new();
    let mut first: Option<Instant> = None;
    loop {
        let event = match first {
            None => events.recv().map_err(|_| RecvTimeoutError::Disconnected),
            Some(first) if first.elapsed() >= MAX_DELAY => return Some(paths),
            Some(_) => events.recv_timeout(QUIET),
        };
        match event {
            Ok(Ok(event)) => paths.extend(event.paths.iter().filter(|path| matters(event.kind, path, made)).cloned()),
            // Events were lost: build everything.
            Ok(Err(error)) => paths.extend(error.paths.into_iter().chain([PathBuf::from(FILE_NAME)])),
            Err(RecvTimeoutError::Timeout) => return Some(paths),
            Err(RecvTimeoutError::Disconnected) => return None,
        }
        if !paths.is_empty() {
            first.get_or_insert_with(Instant::now);
        }
    }
}

/// Whether an event can affect a build: it changes a mesh, a `hullmap.toml`, or a folder that may
/// hold meshes, or removes a pack. Others are ignored, so that a build does not trigger the next
/// one. Emacs locks `a.obj` by the link `.#a.obj`.
fn matters(kind: EventKind, path: &Path, made: &Path) -> bool {
    let is_change = match kind {
        EventKind::Access(kind) => kind == AccessKind::Close(AccessMode::Write),
        EventKind::Modify(ModifyKind::Metadata(_)) => false,
        _ => true,
    };
    let is_config = path.file_name().is_some_and(|name| name == FILE_NAME);
    // A removed name without extension may have been a folder.
    let may_be_folder = match kind {
        EventKind::Create(_) | EventKind::Modify(ModifyKind::Name(_)) => path.is_dir() || path.extension().is_none(),
        EventKind::Remove(_) => path.extension().is_none(),
        _ => false,
    };
    let may_be_gone = matches!(kind, EventKind::Remove(_) | EventKind::Modify(ModifyKind::Name(_)));
    let is_gone_pack = may_be_gone && is_baked(path) && !path.exists();
    let is_lock = path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b".#"));
    is_change
        && !is_lock
        && (is_gone_pack
            || is_source(path)
            || is_buffer(path)
            || is_grid(path)
            || is_config
            || may_be_folder && !path.starts_with(made))
}

fn print_changes(paths: &BTreeSet<PathBuf>) {
    let names: Vec<String> = paths.iter().take(MAX_NAMED).map(|path| shown(path)).collect();
    let more = match paths.len() - names.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    terminal::say(format_args!("changed: {}{more}", names.join(", ")));
}

fn shown(path: &Path) -> String {
    let here = std::env::current_dir().and_then(|here| here.canonicalize());
    let below = here.ok().and_then(|here| path.strip_prefix(here).ok().map(Path::to_owned));
    below.as_deref().unwrap_or(path).display().to_string()
}

#[cfg(test)]
mod tests {
    use notify::event::{CreateKind, DataChange, MetadataKind, RemoveKind};

    use super::*;

    #[test]
    fn changes_of_meshes_and_options_matter_and_own_output_does_not() {
        let data = EventKind::Modify(ModifyKind::Data(DataChange::Any));
        let (made, gone) = (EventKind::Create(CreateKind::Any), EventKind::Remove(RemoveKind::Any));
        let written = EventKind::Access(AccessKind::Close(AccessMode::Write));
        let read = EventKind::Access(AccessKind::Close(AccessMode::Read));
        let touched = EventKind::Modify(ModifyKind::Metadata(MetadataKind::Any));
        for (kind, path, expected) in [
            (data, "in/a.obj", true),
            (written, "in/A.OBJ", true),
            (gone, "in/a.obj", true),
            (gone, "in/sub", true),
            (data, "in/hullmap.toml", true),
            (read, "in/a.obj", false),
            (touched, "in/a.obj", false),
            (made, "in/made/sub", false),
            (gone, "in/made/a.obj", true),
            (made, "in/a.hullmap", false),
            (made, "in/.a.hullmapAbCdEf.tmp", false),
            (gone, "in/made/a.hullmap", true),
            (gone, "in/made/a.hullmesh", true),
            (made, "in/.#a.obj", false),
            (data, "in/sub", false),
        ] {
            assert_eq!(matters(kind, Path::new(path), Path::new("in/made")), expected, "{kind:?} {path}");
        }
    }

    #[test]
    fn saves_in_several_steps_are_one_change() {
        let (sender, events) = channel();
        let event =
            |path: &str| Ok(Event::new(EventKind::Modify(ModifyKind::Data(DataChange::Any))).add_path(path.into()));
        for path in ["a.obj", "a.hullmap", "b.obj", "a.obj"] {
            sender.send(event(path)).unwrap();
        }
        let paths = wait(&events, Path::new("made")).unwrap();
        assert_eq!(paths, BTreeSet::from(["a.obj".into(), "b.obj".into()]));
        drop(sender);
        assert!(wait(&events, Path::new("made")).is_none());
    }
}
