//! The plan of a build: which files it reads and which packs it writes.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use walkdir::WalkDir;

use crate::outcome::Failure;
use hullmap_import::{NAMES, is_source};

/// One mesh and the path of its pack.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The mesh, as named or found.
    pub source: PathBuf,
    /// The pack.
    pub output: PathBuf,
}

/// The meshes in the order of the inputs, sorted by name within each folder.
///
/// A file becomes `out/<stem>.hullmap`; files in a folder keep their path relative to it. Links to
/// folders are followed, except in cycles. A file that is reached twice with the same output is
/// baked once.
///
/// # Errors
/// An input is missing or cannot be read, a folder holds no meshes, or two files would become one
/// pack.
pub fn plan(inputs: &[PathBuf], out: &Path) -> Result<Vec<Place>, Failure> {
    let mut places = Vec::new();
    for input in inputs {
        let kind = std::fs::metadata(input).map_err(|error| {
            Failure::usage(format!("{}: cannot read this input: {error}; check the path", input.display()))
        })?;
        if kind.is_dir() {
            let before = places.len();
            plan_folder(input, out, &mut places)?;
            if places.len() == before {
                return Err(Failure::usage(format!(
                    "{}: no meshes ({NAMES}) in this folder; name a folder of meshes",
                    input.display()
                )));
            }
        } else {
            places.push(Place { source: input.clone(), output: pack_path(out, input) });
        }
    }
    without_clashes(places)
}

fn plan_folder(folder: &Path, out: &Path, places: &mut Vec<Place>) -> Result<(), Failure> {
    for entry in WalkDir::new(folder).follow_links(true).sort_by_file_name() {
        let entry = match entry {
            Ok(entry) => entry,
            Err(error) if error.loop_ancestor().is_some() => continue,
            // A dangling link is ignored unless it has the name of a mesh.
            Err(error) if error.path().is_some_and(|path| path.is_symlink() && !is_source(path)) => {
                continue;
            }
            Err(error) => {
                return Err(Failure::usage(format!("{}: cannot search: {error}", folder.display())));
            }
        };
        if entry.file_type().is_file() && is_source(entry.path()) {
            let below = entry.path().strip_prefix(folder).unwrap_or(entry.path());
            let folder = out.join(below.parent().unwrap_or(Path::new("")));
            places.push(Place { source: entry.path().to_owned(), output: pack_path(&folder, entry.path()) });
        }
    }
    Ok(())
}

fn without_clashes(places: Vec<Place>) -> Result<Vec<Place>, Failure> {
    let mut by_output: HashMap<PathBuf, PathBuf> = HashMap::new();
    let mut kept = Vec::with_capacity(places.len());
    for place in places {
        if let Some(other) = by_output.get(&place.output) {
            let is_same = match (other.canonicalize(), place.source.canonicalize()) {
                (Ok(a), Ok(b)) => a == b,
                _ => *other == place.source,
            };
            if !is_same {
                return Err(Failure::usage(format!(
                    "{} and {} would both become {}; rename one, or bake them into separate folders",
                    other.display(),
                    place.source.display(),
                    place.output.display()
                )));
            }
            continue;
        }
        by_output.insert(place.output.clone(), place.source.clone());
        kept.push(place);
    }
    Ok(kept)
}

/// `folder/<stem>.hullmap`; the stem keeps its inner dots.
fn pack_path(folder: &Path, source: &Path) -> PathBuf {
    let mut name = source.file_stem().unwrap_or_default().to_owned();
    name.push(".hullmap");
    folder.join(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::Exit;

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
        let places = plan(inputs, Path::new("out")).unwrap();
        places.iter().map(|place| place.output.to_str().unwrap().replace('\\', "/")).collect()
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
    fn two_sources_of_one_pack_are_an_error() {
        let meshes = folder(&["a/x.obj", "b/x.obj"]);
        let inputs = ["a", "b"].map(|name| meshes.path().join(name));
        let failure = plan(&inputs, Path::new("out")).unwrap_err();
        assert_eq!(failure.exit, Exit::Usage);
        assert!(failure.message.contains("would both become"), "{failure}");
    }

    #[test]
    fn missing_and_empty_inputs_are_errors() {
        let meshes = folder(&["a.txt"]);
        assert!(plan(&[meshes.path().join("no.obj")], Path::new("out")).unwrap_err().message.contains("no.obj"));
        assert!(plan(&[meshes.path().to_owned()], Path::new("out")).unwrap_err().message.contains("no meshes"));
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
