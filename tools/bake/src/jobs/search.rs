//! The meshes that inputs name, and the folders of their packs.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use walkdir::WalkDir;

use super::filter::Filter;
use crate::outcome::Failure;
use hullmap_import::{NAMES, is_source};

/// One mesh and the folder of its pack.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mesh {
    /// The mesh, as named or found.
    pub source: PathBuf,
    /// The folder of its pack.
    pub folder: PathBuf,
}

/// The meshes in the order of the inputs, sorted by name within each folder.
///
/// Packs of files lie in `out`; files in a folder keep their path relative to it. Links to folders
/// are followed, except in cycles. A file that is reached twice with the same folder is baked once.
///
/// # Errors
/// An input is missing or cannot be read, a folder holds no meshes, or `filter` leaves none.
pub fn search(inputs: &[PathBuf], out: &Path, filter: &mut Filter) -> Result<Vec<Mesh>, Failure> {
    let mut meshes = Vec::new();
    let mut left_out = 0;
    for input in inputs {
        let kind = std::fs::metadata(input).map_err(|error| {
            Failure::usage(format!("{}: cannot read this input: {error}; check the path", input.display()))
        })?;
        if kind.is_dir() {
            let before = meshes.len();
            let count = search_folder(input, out, filter, &mut meshes)?;
            if count == 0 {
                return Err(Failure::usage(format!(
                    "{}: no meshes ({NAMES}) in this folder; name a folder of meshes",
                    input.display()
                )));
            }
            left_out += count - (meshes.len() - before);
        } else if filter.keeps(None, input) {
            meshes.push(Mesh { source: input.clone(), folder: out.to_owned() });
        } else {
            left_out += 1;
        }
    }
    if meshes.is_empty() {
        return Err(Failure::usage(format!(
            "--exclude and --ext leave no mesh to bake (left out: {left_out}); change one of them"
        )));
    }
    Ok(without_repeats(meshes))
}

/// Adds the meshes in a folder; returns how many it holds, with those that `filter` leaves out.
fn search_folder(folder: &Path, out: &Path, filter: &mut Filter, meshes: &mut Vec<Mesh>) -> Result<usize, Failure> {
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
        if entry.file_type().is_file() && is_source(entry.path()) {
            count += 1;
            let below = entry.path().strip_prefix(folder).unwrap_or(entry.path());
            if filter.keeps(Some(below), entry.path()) {
                let folder = out.join(below.parent().unwrap_or(Path::new("")));
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
    use super::super::pack_names::pack_names;
    use super::*;

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
        let meshes = search(inputs, Path::new("out"), &mut Filter::default()).unwrap();
        let meshes: Vec<_> = meshes.iter().map(|mesh| (mesh, None)).collect();
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

    #[cfg(unix)]
    #[test]
    fn cyclic_links_are_ignored() {
        let meshes = folder(&["a/x.obj"]);
        std::os::unix::fs::symlink(meshes.path(), meshes.path().join("a/up")).unwrap();
        std::os::unix::fs::symlink(meshes.path().join("nothing"), meshes.path().join("a/dead")).unwrap();
        assert_eq!(outputs(&[meshes.path().to_owned()]), ["out/a/x.hullmap"]);
    }
}
