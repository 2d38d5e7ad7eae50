//! The meshes that inputs name, and the folders of their packs.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use walkdir::WalkDir;

use super::filter::Filter;
use crate::outcome::Failure;
use hullmap_import::{NAMES, is_source, unread_format};

/// One mesh and the folder of its pack.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mesh {
    /// The mesh, as named or found.
    pub source: PathBuf,
    /// The folder of its pack.
    pub folder: PathBuf,
}

/// The meshes in the inputs, and what else they contain.
#[derive(Debug, Default)]
pub struct Found {
    /// The meshes in the order of the inputs, sorted by name within each folder.
    pub meshes: Vec<Mesh>,
    /// Meshes in folders whose formats are not supported, in the same order.
    pub unread: Vec<Mesh>,
    /// The folders without meshes.
    pub empty: Vec<PathBuf>,
}

/// The meshes that inputs name.
///
/// Packs of files lie in `out`; files in a folder keep their path relative to it. Links to folders
/// are followed, except in cycles. A file that is reached twice with the same folder is baked once.
/// Fails if an input is missing or cannot be read, all of them are folders without meshes, or
/// `filter` leaves none.
pub fn search(inputs: &[PathBuf], out: &Path, filter: &mut Filter) -> Result<Found, Failure> {
    let mut found = Found::default();
    let mut left_out = 0;
    for input in inputs {
        let kind = std::fs::metadata(input).map_err(|error| {
            Failure::usage(format!("{}: cannot read this input: {error}; check the path", input.display()))
        })?;
        if kind.is_dir() {
            let before = found.meshes.len();
            let count = search_folder(input, out, filter, &mut found)?;
            if count == 0 {
                found.empty.push(input.clone());
            }
            left_out += count - (found.meshes.len() - before);
        } else if filter.keeps(None, input) {
            found.meshes.push(Mesh { source: input.clone(), folder: out.to_owned() });
        } else {
            left_out += 1;
        }
    }
    if let Some(empty) = found.empty.first().filter(|_| found.meshes.is_empty() && left_out == 0) {
        let unread = in_words(found.unread.iter().map(|mesh| mesh.source.as_path()));
        let unread = unread.map_or(String::new(), |unread| format!("; not read: {unread}"));
        return Err(Failure::usage(format!("{}{unread}", without_meshes(empty))));
    }
    if found.meshes.is_empty() {
        return Err(Failure::usage(format!(
            "--exclude and --ext leave no mesh to bake (left out: {left_out}); change one of them"
        )));
    }
    Ok(Found { meshes: without_repeats(found.meshes), unread: without_repeats(found.unread), empty: found.empty })
}

/// The fault of a folder without meshes.
pub fn without_meshes(folder: &Path) -> String {
    format!("{}: no meshes ({NAMES}) in this folder; name a folder of meshes", folder.display())
}

/// Files of formats that are not supported, counted by extension: `2 .fbx (FBX), 53 .usd
/// (USD)`; `None` if there are none.
pub fn in_words<'a>(files: impl Iterator<Item = &'a Path>) -> Option<String> {
    let mut counts: BTreeMap<(String, &str), usize> = BTreeMap::new();
    for file in files {
        let extension = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        *counts.entry((extension, unread_format(file).unwrap_or_default())).or_default() += 1;
    }
    let words = counts.iter().map(|((extension, format), count)| format!("{count} .{extension} ({format})"));
    Some(words.collect::<Vec<_>>().join(", ")).filter(|text| !text.is_empty())
}

/// Adds the meshes in a folder; returns how many it holds, before `filter` leaves any out.
fn search_folder(folder: &Path, out: &Path, filter: &mut Filter, found: &mut Found) -> Result<usize, Failure> {
    let mut count = 0;
    for entry in WalkDir::new(folder).follow_links(true).sort_by_file_name() {
        let entry = match entry {
            Ok(entry) => entry,
            Err(error) if error.loop_ancestor().is_some() => continue,
            // A dangling link is ignored unless it has the name of a mesh.
            Err(error) if error.path().is_some_and(|path| path.is_symlink() && !is_source(path)) => {
                continue;
            }
            Err(error) => {
                return Err(Failure::usage(format!(
                    "{}: cannot search: {error}; check its permissions",
                    folder.display()
                )));
            }
        };
        let is_unread = unread_format(entry.path()).is_some();
        if entry.file_type().is_file() && (is_unread || is_source(entry.path())) {
            count += usize::from(!is_unread);
            let below = entry.path().strip_prefix(folder).unwrap_or(entry.path());
            if filter.keeps(Some(below), entry.path()) {
                let folder = out.join(below.parent().unwrap_or(Path::new("")));
                let meshes = if is_unread { &mut found.unread } else { &mut found.meshes };
                meshes.push(Mesh { source: entry.path().to_owned(), folder });
            }
        }
    }
    Ok(count)
}

fn without_repeats(meshes: Vec<Mesh>) -> Vec<Mesh> {
    let mut known: HashMap<PathBuf, Vec<PathBuf>> = HashMap::new();
    let mut kept = Vec::with_capacity(meshes.len());
    for mesh in meshes {
        let others = known.entry(mesh.folder.join(mesh.source.file_name().unwrap_or_default())).or_default();
        let is_same = |other: &PathBuf| match (other.canonicalize(), mesh.source.canonicalize()) {
            (Ok(a), Ok(b)) => a == b,
            _ => *other == mesh.source,
        };
        if !others.iter().any(is_same) {
            others.push(mesh.source.clone());
            kept.push(mesh);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::super::pack_names::{Unnamed, pack_names};
    use super::*;
    use hullmap_format::header::FileKind;

    /// A folder with empty files of these names.
    fn folder(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        }
        folder
    }

    fn outputs(inputs: &[PathBuf]) -> Vec<String> {
        let meshes = search(inputs, Path::new("out"), &mut Filter::default()).unwrap().meshes;
        let unnamed = |mesh| Unnamed { mesh, keeps_extension: None, kind: FileKind::Pack };
        let meshes: Vec<_> = meshes.iter().map(unnamed).collect();
        let names = pack_names(&meshes);
        names.iter().map(|name| name.output.to_str().unwrap().replace('\\', "/")).collect()
    }

    #[test]
    fn folders_are_mirrored_and_sorted() {
        let meshes = folder(&["b.obj", "a/x.OBJ", "a/deep/y.v2.obj", "a.txt", "c.mtl"]);
        assert_eq!(
            outputs(&[meshes.path().to_owned()]),
            ["out/a/deep/y.v2.hullmap", "out/a/x.hullmap", "out/b.hullmap"]
        );
    }

    #[test]
    fn files_lie_flat_and_keep_their_order() {
        let meshes = folder(&["b.obj", "a/x.obj", "cloud.txt"]);
        let inputs = ["cloud.txt", "b.obj", "a/x.obj", "b.obj"].map(|name| meshes.path().join(name));
        assert_eq!(outputs(&inputs), ["out/cloud.hullmap", "out/b.hullmap", "out/x.hullmap"]);
    }

    #[test]
    fn missing_and_empty_inputs_are_errors() {
        let meshes = folder(&["a.txt"]);
        assert!(
            search(&[meshes.path().join("no.obj")], Path::new("out"), &mut Filter::default())
                .unwrap_err()
                .message
                .contains("no.obj")
        );
        assert!(
            search(&[meshes.path().to_owned()], Path::new("out"), &mut Filter::default())
                .unwrap_err()
                .message
                .contains("no meshes")
        );
    }

    /// The other inputs were not baked.
    #[test]
    fn a_folder_without_meshes_does_not_stop_the_others() {
        let meshes = folder(&["a/x.obj", "b/readme.txt", "c/y.usd"]);
        let inputs = ["a", "b", "c"].map(|name| meshes.path().join(name));
        let found = search(&inputs, Path::new("out"), &mut Filter::default()).unwrap();
        assert_eq!((found.meshes.len(), found.unread.len(), &found.empty[..]), (1, 1, &inputs[1..]));
        let failure = search(&inputs[1..], Path::new("out"), &mut Filter::default()).unwrap_err();
        assert!(failure.message.contains("b: no meshes") && failure.message.contains("1 .usd (USD)"), "{failure}");
    }

    #[test]
    fn unread_files_are_counted_by_extension() {
        let files = ["b.usd", "a.USD", "c.fbx"].map(Path::new);
        assert_eq!(in_words(files.into_iter()).unwrap(), "1 .fbx (FBX), 2 .usd (USD)");
        assert_eq!(in_words(std::iter::empty()), None);
    }

    #[cfg(unix)]
    #[test]
    fn cyclic_links_are_ignored() {
        let meshes = folder(&["a/x.obj"]);
        std::os::unix::fs::symlink(meshes.path(), meshes.path().join("a/up")).unwrap();
        std::os::unix::fs::symlink(meshes.path().join("nothing"), meshes.path().join("a/dead")).unwrap();
        assert_eq!(outputs(&[meshes.path().to_owned()]), ["out/a/x.hullmap"]);
    }
}
