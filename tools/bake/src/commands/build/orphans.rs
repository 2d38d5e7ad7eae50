//! Packs in the output folder whose source is gone.

use std::collections::HashSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use walkdir::WalkDir;

use super::rows::{Row, Status};
use crate::open::open_pack;
use crate::pack_file::{folder_of, plain, resolve_recorded, shown_from};
use crate::packs::is_pack;

/// A pack that no mesh of the build becomes and whose recorded source is not there.
#[derive(Debug)]
pub struct Orphan {
    pack: PathBuf,
    /// Where its source was, as the user would name it.
    source: String,
    /// Why it is not certain that its source is gone, so that it is left alone; `None` where it may be removed.
    kept: Option<&'static str>,
}

/// The pack names a folder of its source, but not the one whose meshes become packs at its place.
const MOVED: &str = "no mesh of this build would lie there: the pack was copied or moved, or is another build's; not pruned: \
                     remove it by hand if nobody needs it";

/// The pack names no folder at all.
const NAME_ALONE: &str = "the folder of its source is not recorded, so that it may be another build's; not pruned: remove it \
                          by hand, or start bake in a folder that holds both meshes and packs";

/// The orphans in `out`, by name, of a build of `inputs` that makes `outputs`; `project` is the folder that `bake` was started in.
///
/// A pack is one if it opens, so that it was certainly written by a bake; if it records its source; if the build has no mesh
/// for it; and if no file is at the recorded place, nor at the pack's own place below any input folder. Other builds may share
/// the folder: their packs have their sources. Nothing else in the folder is ever looked at.
///
/// It may be removed if it lies where this build would put a pack of the recorded source. A pack that was copied, moved or
/// renamed records a way that leads elsewhere from there, and its source may well live.
///
/// # Complexity
/// One walk over `out`; packs that the build makes are not opened.
pub fn find(out: &Path, inputs: &[PathBuf], outputs: &HashSet<&Path>, project: &Path) -> Vec<Orphan> {
    let entries = WalkDir::new(out).sort_by_file_name().into_iter().flatten();
    let packs = entries.filter(|entry| entry.file_type().is_file() && is_pack(entry.path()));
    let others = packs.filter(|entry| !outputs.contains(entry.path()));
    others.filter_map(|entry| judge(entry.path(), out, inputs, project)).collect()
}

fn judge(pack: &Path, out: &Path, inputs: &[PathBuf], project: &Path) -> Option<Orphan> {
    let recorded = open_pack(pack).ok()?.source_path().to_owned();
    let recorded_place = resolve_recorded(&recorded, folder_of(pack))?;
    let name = recorded_place.file_name()?;
    let below = pack.strip_prefix(out).ok()?.parent().unwrap_or(Path::new(""));
    let folders: Vec<PathBuf> = inputs.iter().filter(|input| !input.is_file()).map(|input| input.join(below)).collect();
    // Where the system cannot say, it may be there.
    let may_be_there = |path: &Path| path.try_exists().unwrap_or(true);
    if may_be_there(&recorded_place) || folders.iter().any(|folder| may_be_there(&folder.join(name))) {
        return None;
    }
    let recorded_place = plain(&recorded_place);
    let is_recorded =
        |folder: &&PathBuf| canonical_of_gone(folder).is_some_and(|path| path.join(name) == recorded_place);
    let folder = folders.iter().find(is_recorded);
    let names_folder = recorded.contains('/');
    let kept = match folder {
        Some(_) if recorded_place.file_stem() == pack.file_stem() => None,
        None if !names_folder => Some(NAME_ALONE),
        _ => Some(MOVED),
    };
    let source = match folder {
        Some(folder) => folder.join(name),
        // Where the pack lies says nothing of where its source was.
        None if !names_folder => PathBuf::from(&recorded),
        None => shown_from(&recorded_place, project),
    };
    Some(Orphan { pack: pack.to_owned(), source: source.display().to_string(), kept })
}

/// The canonical path of a folder that may be gone, with folders above it; `None` where that cannot be found out.
fn canonical_of_gone(folder: &Path) -> Option<PathBuf> {
    for above in folder.ancestors() {
        let place = if above == Path::new("") { Path::new(".") } else { above };
        match place.canonicalize() {
            Ok(canonical) => return Some(plain(&canonical.join(folder.strip_prefix(above).ok()?))),
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(_) => return None,
        }
    }
    None
}

impl Orphan {
    /// Whether it stays, as it is not certain that its source is gone.
    pub fn is_kept(&self) -> bool {
        self.kept.is_some()
    }

    /// What is said of it; it is removed first if `prunes`, with the folders below `out` that are empty then.
    ///
    /// Whatever hinders that is the row's error.
    pub fn row(&self, out: &Path, prunes: bool) -> Row {
        let mut row = Row::new(self.source.clone(), self.pack.display().to_string(), Status::Orphaned);
        let word = if self.is_kept() { "not there" } else { "gone" };
        row.reason = Some(format!("its source {} is {word}", self.source));
        row.notes.extend(self.kept.map(str::to_owned));
        if !prunes || self.is_kept() {
            return row;
        }
        match std::fs::remove_file(&self.pack) {
            Ok(()) => {
                row.status = Status::Pruned;
                remove_empty_folders(folder_of(&self.pack), out);
            }
            // Another bake was faster.
            Err(error) if error.kind() == ErrorKind::NotFound => row.status = Status::Pruned,
            Err(error) => row.error = Some(format!("{}: cannot remove: {error}", row.output)),
        }
        row
    }
}

/// Removes `folder` and those above it, up to `out` itself, while they are empty.
fn remove_empty_folders(folder: &Path, out: &Path) {
    for folder in folder.ancestors().take_while(|folder| *folder != out && folder.starts_with(out)) {
        // Fails where anything is in it.
        if std::fs::remove_dir(folder).is_err() {
            return;
        }
    }
}
