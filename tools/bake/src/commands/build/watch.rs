//! `--watch`: bake, wait for a change, bake what it touched, until Ctrl-C.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use notify::event::{AccessKind, AccessMode, EventKind, ModifyKind};
use notify::{Event, RecommendedWatcher, RecursiveMode, Watcher};

use super::job::{Baker, Job};
use super::{build, jobs};
use crate::args::BuildArgs;
use crate::config::FILE_NAME;
use crate::outcome::{Exit, Failure};
use crate::pack_file::folder_of;
use crate::{interrupt, messages};
use hullmap_import::{is_buffer, is_source};

/// A change counts once nothing more has changed for so long: editors save in several steps.
const QUIET: Duration = Duration::from_millis(200);

/// At the latest so long after the first change, in case something never stops.
const AT_MOST: Duration = Duration::from_secs(5);

/// Most changed files that are named.
const MOST_NAMED: usize = 5;

/// Builds until the process is interrupted. Errors are told, and the next change is waited for.
///
/// # Errors
/// The system cannot tell of changes, or the answer cannot be written.
pub fn run(args: &BuildArgs, project: &Path, baker: &Baker, out: &mut dyn Write) -> Result<Exit, Failure> {
    let (sender, events) = channel();
    // A receiver that is gone means the end of the process.
    let watcher = notify::recommended_watcher(move |event| drop(sender.send(event)));
    let cannot = |error: notify::Error| Failure::usage(format!("cannot watch for changes: {error}; leave --watch out"));
    let mut watcher = Watched { watcher: watcher.map_err(cannot)?, folders: BTreeSet::new() };
    // Watched before the first build, so that nothing is missed in between.
    watcher.watch_all(args).map_err(cannot)?;
    let mut changed = None;
    loop {
        match once(args, project, baker, changed.as_ref(), out) {
            Ok(configs) => watcher.watch_files(&configs),
            Err(failure) if failure.message.is_empty() => return Err(failure),
            Err(failure) => messages::error(&failure),
        }
        if !args.quiet {
            messages::say("watching for changes; Ctrl-C ends");
        }
        // Now that the folder is there it has a canonical path, as all paths of events have.
        let made = args.out.canonicalize().unwrap_or_else(|_| args.out.clone());
        let paths = match interrupt::idle(|| wait(&events, &made)) {
            Some(paths) => paths,
            None => return Ok(Exit::Done),
        };
        if !args.quiet {
            tell(&paths);
        }
        changed = Some(paths);
    }
}

/// One build: of everything, or of what the changed paths touch. Returns the `hullmap.toml` files that counted.
fn once(
    args: &BuildArgs,
    project: &Path,
    baker: &Baker,
    changed: Option<&BTreeSet<PathBuf>>,
    out: &mut dyn Write,
) -> Result<BTreeSet<PathBuf>, Failure> {
    let is_all = changed.is_none_or(|paths| paths.iter().any(|path| !is_source(path)));
    let jobs = jobs(args, project, is_all && !args.quiet)?;
    let is_touched = |job: &Job| match changed {
        Some(paths) if !is_all => job.source.canonicalize().map_or(true, |path| paths.contains(&path)),
        _ => true,
    };
    build(args, project, baker, &jobs, is_touched, out)?;
    Ok(jobs.into_iter().filter_map(|job| job.config).collect())
}

/// What the system watches for us.
struct Watched {
    watcher: RecommendedWatcher,
    folders: BTreeSet<PathBuf>,
}

impl Watched {
    /// The inputs, folders with all below them, and the file that `--config` names.
    fn watch_all(&mut self, args: &BuildArgs) -> Result<(), notify::Error> {
        for input in &args.inputs {
            let path = input.canonicalize().unwrap_or_else(|_| input.clone());
            if path.is_dir() {
                self.watcher.watch(&path, RecursiveMode::Recursive)?;
            } else {
                self.watch_folder_of(&path);
            }
        }
        self.watch_files(&args.config.iter().cloned().collect());
        Ok(())
    }

    fn watch_files(&mut self, files: &BTreeSet<PathBuf>) {
        for file in files {
            if let Ok(path) = file.canonicalize() {
                self.watch_folder_of(&path);
            }
        }
    }

    /// A file's folder rather than the file: editors replace files, and the watch would stay with the old one.
    fn watch_folder_of(&mut self, file: &Path) {
        let folder = folder_of(file).to_owned();
        if self.folders.insert(folder.clone()) {
            // A folder inside a watched input is watched twice: harmless. One that cannot be watched is not fatal either.
            let _ = self.watcher.watch(&folder, RecursiveMode::NonRecursive);
        }
    }
}

/// The paths that changed and may matter, once it is quiet; `None` when no more can come.
///
/// Folders below `made`, where packs go, are our own.
fn wait(events: &Receiver<notify::Result<Event>>, made: &Path) -> Option<BTreeSet<PathBuf>> {
    let mut paths = BTreeSet::new();
    let mut first: Option<Instant> = None;
    loop {
        let event = match first {
            None => events.recv().map_err(|_| RecvTimeoutError::Disconnected),
            Some(first) if first.elapsed() >= AT_MOST => return Some(paths),
            Some(_) => events.recv_timeout(QUIET),
        };
        match event {
            Ok(Ok(event)) => paths.extend(event.paths.iter().filter(|path| matters(event.kind, path, made)).cloned()),
            // Events were lost: whatever it was, look at everything.
            Ok(Err(error)) => paths.extend(error.paths.into_iter().chain([PathBuf::from(FILE_NAME)])),
            Err(RecvTimeoutError::Timeout) => return Some(paths),
            Err(RecvTimeoutError::Disconnected) => return None,
        }
        if !paths.is_empty() {
            first.get_or_insert_with(Instant::now);
        }
    }
}

/// Whether an event can change what a build makes: a mesh, a `hullmap.toml`, or a folder that came or went with meshes in it.
/// Reading is no change, and packs and temporary files are not meshes, so a build does not set off the next one.
fn matters(kind: EventKind, path: &Path, made: &Path) -> bool {
    let is_change = match kind {
        EventKind::Access(kind) => kind == AccessKind::Close(AccessMode::Write),
        EventKind::Modify(ModifyKind::Metadata(_)) => false,
        _ => true,
    };
    let is_config = path.file_name().is_some_and(|name| name == FILE_NAME);
    // What is gone cannot be asked what it was; a name without extension may well have been a folder.
    let may_be_folder = match kind {
        EventKind::Create(_) | EventKind::Modify(ModifyKind::Name(_)) => path.is_dir() || path.extension().is_none(),
        EventKind::Remove(_) => path.extension().is_none(),
        _ => false,
    };
    is_change && (is_source(path) || is_buffer(path) || is_config || may_be_folder && !path.starts_with(made))
}

fn tell(paths: &BTreeSet<PathBuf>) {
    let names: Vec<String> = paths.iter().take(MOST_NAMED).map(|path| shown(path)).collect();
    let more = match paths.len() - names.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    messages::say(format_args!("changed: {}{more}", names.join(", ")));
}

/// From the current folder, where it lies in it.
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
    fn changes_of_meshes_and_options_matter_and_our_own_work_does_not() {
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
            (gone, "in/a.hullmap", false),
            (data, "in/sub", false),
        ] {
            assert_eq!(matters(kind, Path::new(path), Path::new("in/made")), expected, "{kind:?} {path}");
        }
    }

    #[test]
    fn several_steps_are_one_change() {
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
