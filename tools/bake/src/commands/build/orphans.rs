//! Packs in the output folder whose source is gone.

use std::collections::HashSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use walkdir::WalkDir;

use super::rows::{Row, Status};
use crate::open::open_pack;
use crate::pack_file::{folder_of, resolve_recorded};
use crate::packs::is_pack;

/// A pack that no mesh of the build becomes and whose recorded source is not there.
#[derive(Debug)]
pub struct Orphan {
    pack: PathBuf,
    /// Where its source was, as it records it.
    recorded: String,
    /// Why it is left alone all the same; `None` where it may be removed.
    kept: Option<String>,
}

/// The orphans in `out`, by name, of a build of `inputs` that makes `outputs`.
///
/// A pack is one if it opens, so that it was certainly written by a bake; if it records its source; if the build has no mesh
/// for it; and if no file is at the recorded place, nor at the pack's own place below any input folder. Other builds may share
/// the folder: their packs have their sources. Nothing else in the folder is ever looked at.
///
/// # Complexity
/// One walk over `out`; packs that the build makes are not opened.
pub fn find(out: &Path, inputs: &[PathBuf], outputs: &HashSet<&Path>) -> Vec<Orphan> {
    let entries = WalkDir::new(out).sort_by_file_name().into_iter().flatten();
    let packs = entries.filter(|entry| entry.file_type().is_file() && is_pack(entry.path()));
    packs.filter(|entry| !outputs.contains(entry.path())).filter_map(|entry| judge(entry.path(), out, inputs)).collect()
}

fn judge(pack: &Path, out: &Path, inputs: &[PathBuf]) -> Option<Orphan> {
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
    // A name alone tells where the source was only if packs lie beside their sources.
    let is_beside = |folder: &PathBuf| match (folder.canonicalize(), folder_of(pack).canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    };
    let is_known = recorded.contains('/') || folders.iter().any(is_beside);
    let kept = (!is_known).then(|| {
        "it records its source's name but not its folder, so that it may be another build's; remove it by hand, or start \
         bake in a folder that holds both meshes and packs"
            .to_owned()
    });
    Some(Orphan { pack: pack.to_owned(), recorded, kept })
}

impl Orphan {
    /// What is said of it; it is removed first if `prunes`, with the folders below `out` that are empty then.
    ///
    /// Whatever hinders that is the row's error.
    pub fn row(&self, out: &Path, prunes: bool) -> Row {
        let mut row = Row::new(self.recorded.clone(), self.pack.display().to_string(), Status::Orphaned);
        row.reason = Some(format!("its source {} is gone", self.recorded));
        if !prunes {
            return row;
        }
        if let Some(kept) = &self.kept {
            row.notes.push(format!("{}: not removed: {kept}", row.output));
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
