//! Orphans: packs in the output folder whose source is gone.

use std::collections::{HashMap, HashSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use hullmap_pipeline::jobs::pack_names::is_name_of;
use hullmap_pipeline::jobs::{Job, slashed};
use hullmap_pipeline::open::open_asset;
use hullmap_pipeline::pack_file::{canonical_of_gone, folder_of, plain, resolve_recorded, shown_from, walk};
use hullmap_pipeline::packs::{PackPlace, is_baked};
use hullmap_pipeline::project::{Found, Project};
use hullmap_pipeline::runner::rows::{Row, Status};

#[derive(Debug)]
pub struct Orphan {
    pack: PathBuf,
    source: String,
    reason: String,
    /// Why it is kept although its source is not found; `None` if it may be removed.
    kept: Option<&'static str>,
}

const MOVED: &str = "it is kept, because this build would not write it here; remove it by hand if it is not needed";

const OUTSIDE: &str = "it is kept, because its recorded path leads out of the project and was not followed; remove it \
                       by hand if it is not needed";

const NAME_ALONE: &str = "it is not pruned, because it does not record its source's folder; remove it by hand, or start \
                          bake in a folder that holds meshes and packs";

/// The orphans in `out`, sorted by name, of a build of `inputs` that writes `outputs`; `project` is
/// the folder where `bake` was started.
///
/// A pack is an orphan if it opens, records its source, is not written by this build, and no file
/// exists at the recorded path, as far as that stays inside the pack's [`Project`] or the inputs,
/// or at the pack's own relative path below any input folder. Packs of other builds that share the
/// folder have their sources. Files other than packs are ignored.
///
/// An orphan may be removed if this build would write the pack of the recorded source to that very
/// path. A copied, moved or renamed pack records another path, so its source may still exist.
pub fn find(out: &Path, inputs: &[PathBuf], jobs: &[Job], project: &Path) -> Vec<Orphan> {
    let outputs: HashSet<&Path> = jobs.iter().map(|job| job.output.as_path()).collect();
    let mut by_folder: HashMap<&Path, Vec<&Job>> = HashMap::new();
    for job in jobs {
        by_folder.entry(folder_of(&job.output)).or_default().push(job);
    }
    let beside = |pack: &Path| by_folder.get(folder_of(pack)).map_or(&[][..], Vec::as_slice);
    let entries = walk(out).build().flatten();
    let packs = entries.filter(|entry| entry.file_type().is_some_and(|kind| kind.is_file()) && is_baked(entry.path()));
    let others = packs.filter(|entry| !outputs.contains(entry.path()));
    others.filter_map(|entry| judge(entry.path(), out, inputs, beside(entry.path()), project)).collect()
}

/// `beside` are the jobs whose packs lie in the folder of `pack`.
fn judge(pack: &Path, out: &Path, inputs: &[PathBuf], beside: &[&Job], project: &Path) -> Option<Orphan> {
    let recorded = open_asset(pack).ok()?.source_path().to_owned();
    let recorded_place = resolve_recorded(&recorded, folder_of(pack))?;
    let name = recorded_place.file_name()?;
    let below = pack.strip_prefix(out).ok()?.parent().unwrap_or(Path::new(""));
    let folders: Vec<PathBuf> = inputs.iter().filter(|input| !input.is_file()).map(|input| input.join(below)).collect();
    // If the system reports another error, the file may exist.
    let may_be_there = |path: &Path| path.try_exists().unwrap_or(true);
    // Paths that lead out of the project are not followed, except into the inputs.
    let place = plain(&recorded_place);
    let is_in_input = inputs.iter().filter_map(|input| input.canonicalize().ok()).any(|input| place.starts_with(input));
    let is_inside = is_in_input
        || project_of(pack, below, project).is_some_and(|project| project.find(&recorded_place) != Found::Outside);
    if is_inside && let Some(orphan) = renamed(pack, &recorded_place, beside) {
        return Some(orphan);
    }
    if is_inside && may_be_there(&recorded_place) || folders.iter().any(|folder| may_be_there(&folder.join(name))) {
        return None;
    }
    let recorded_place = plain(&recorded_place);
    let is_recorded =
        |folder: &&PathBuf| canonical_of_gone(folder).is_some_and(|path| path.join(name) == recorded_place);
    let folder = folders.iter().find(is_recorded);
    let names_folder = recorded.contains('/');
    let kept = match folder {
        Some(_) if is_name_of(pack, &recorded_place) => None,
        None if !names_folder => Some(NAME_ALONE),
        None if !is_inside => Some(OUTSIDE),
        _ => Some(MOVED),
    };
    let source = match folder {
        Some(folder) => folder.join(name),
        // The pack's own folder does not reveal its source's.
        None if !names_folder => PathBuf::from(&recorded),
        None => shown_from(&recorded_place, project),
    };
    let source = source.display().to_string();
    let reason = format!("its source {source} is {}", if kept.is_some() { "not found" } else { "gone" });
    Some(Orphan { pack: pack.to_owned(), source, reason, kept })
}

/// The orphan that is left if the name of a mesh's pack gains or loses the mesh's extension.
fn renamed(pack: &Path, recorded_place: &Path, beside: &[&Job]) -> Option<Orphan> {
    let is_name = |job: &&&Job| job.source.file_name() == recorded_place.file_name() && is_name_of(pack, &job.source);
    let is_source = |job: &&&Job| match (job.source.canonicalize(), recorded_place.canonicalize()) {
        (Ok(source), Ok(recorded)) => source == recorded,
        _ => false,
    };
    let job = beside.iter().filter(is_name).find(is_source)?;
    let source = job.source.display().to_string();
    let reason = format!("its source {source} is now baked into {}", job.output.display());
    Some(Orphan { pack: pack.to_owned(), source, reason, kept: None })
}

fn project_of(pack: &Path, below: &Path, start: &Path) -> Option<Project> {
    Project::of_pack(&PackPlace { path: pack.to_owned(), below: below.to_owned() }, start)
}

impl Orphan {
    pub fn is_kept(&self) -> bool {
        self.kept.is_some()
    }

    pub fn place(&self, out: &Path) -> String {
        slashed(self.pack.strip_prefix(out).unwrap_or(&self.pack))
    }

    /// Its row. If `prunes`, the pack is removed first, with folders below `out` that become empty;
    /// a failure to do so is the row's error.
    pub fn row(&self, out: &Path, prunes: bool) -> Row {
        let mut row = Row::new(self.source.clone(), self.pack.display().to_string(), Status::Orphaned);
        row.reason = Some(self.reason.clone());
        row.notes.extend(self.kept.map(str::to_owned));
        if !prunes || self.is_kept() {
            return row;
        }
        match std::fs::remove_file(&self.pack) {
            Ok(()) => {
                row.status = Status::Pruned;
                remove_empty_folders(folder_of(&self.pack), out);
            }
            // Another bake removed it first.
            Err(error) if error.kind() == ErrorKind::NotFound => row.status = Status::Pruned,
            Err(error) => row.error = Some(format!("{}: cannot remove: {error}", row.output)),
        }
        row
    }
}

fn remove_empty_folders(folder: &Path, out: &Path) {
    for folder in folder.ancestors().take_while(|folder| *folder != out && folder.starts_with(out)) {
        // Fails if the folder is not empty.
        if std::fs::remove_dir(folder).is_err() {
            return;
        }
    }
}
