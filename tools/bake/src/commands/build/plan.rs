//! Which files a build reads and which it writes.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use walkdir::WalkDir;

use crate::import::{self, is_source};
use crate::outcome::Failure;

/// One source file and the pack it becomes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Job {
    /// The source file as it was named or found.
    pub source: PathBuf,
    /// The pack.
    pub output: PathBuf,
}

/// The jobs, in the order of the inputs and by name within a folder.
///
/// A file becomes `out/<stem>.hullmap`; a folder's files keep their place below it. Links to folders are followed,
/// but not in circles. A file that two inputs reach with the same output is baked once.
///
/// # Errors
/// An input that is missing or cannot be read, a folder without source files, two files that become one pack.
pub fn plan(inputs: &[PathBuf], out: &Path) -> Result<Vec<Job>, Failure> {
    let mut jobs = Vec::new();
    for input in inputs {
        let kind = std::fs::metadata(input).map_err(|error| {
            Failure::usage(format!("{}: cannot read this input: {error}; check the path", input.display()))
        })?;
        if kind.is_dir() {
            let before = jobs.len();
            plan_folder(input, out, &mut jobs)?;
            if jobs.len() == before {
                return Err(Failure::usage(format!("{}: no {} files in this folder", input.display(), import::NAMES)));
            }
        } else {
            jobs.push(Job { source: input.clone(), output: pack_path(out, input) });
        }
    }
    without_clashes(jobs)
}

fn plan_folder(folder: &Path, out: &Path, jobs: &mut Vec<Job>) -> Result<(), Failure> {
    for entry in WalkDir::new(folder).follow_links(true).sort_by_file_name() {
        let entry = match entry {
            Ok(entry) => entry,
            Err(error) if error.loop_ancestor().is_some() => continue,
            // A link that leads nowhere is no mesh, unless it is called one.
            Err(error) if error.path().is_some_and(|path| path.is_symlink() && !is_source(path)) => {
                continue;
            }
            Err(error) => {
                return Err(Failure::usage(format!("{}: cannot search: {error}", folder.display())));
            }
        };
        if entry.file_type().is_file() && is_source(entry.path()) {
            let below = entry.path().strip_prefix(folder).unwrap_or(entry.path());
            let place = out.join(below.parent().unwrap_or(Path::new("")));
            jobs.push(Job { source: entry.path().to_owned(), output: pack_path(&place, entry.path()) });
        }
    }
    Ok(())
}

fn without_clashes(jobs: Vec<Job>) -> Result<Vec<Job>, Failure> {
    let mut by_output: HashMap<PathBuf, PathBuf> = HashMap::new();
    let mut kept = Vec::with_capacity(jobs.len());
    for job in jobs {
        if let Some(other) = by_output.get(&job.output) {
            let is_same = match (other.canonicalize(), job.source.canonicalize()) {
                (Ok(a), Ok(b)) => a == b,
                _ => *other == job.source,
            };
            if !is_same {
                return Err(Failure::usage(format!(
                    "{} and {} would both become {}; rename one or bake them apart",
                    other.display(),
                    job.source.display(),
                    job.output.display()
                )));
            }
            continue;
        }
        by_output.insert(job.output.clone(), job.source.clone());
        kept.push(job);
    }
    Ok(kept)
}

/// `place/<stem>.hullmap`; the stem keeps its inner points.
fn pack_path(place: &Path, source: &Path) -> PathBuf {
    let mut name = source.file_stem().unwrap_or_default().to_owned();
    name.push(".hullmap");
    place.join(name)
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
        let jobs = plan(inputs, Path::new("out")).unwrap();
        jobs.iter().map(|job| job.output.to_str().unwrap().replace('\\', "/")).collect()
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
        assert!(
            plan(&[meshes.path().to_owned()], Path::new("out"))
                .unwrap_err()
                .message
                .contains("no OBJ, glTF, GLB, STL or PLY files")
        );
    }

    #[cfg(unix)]
    #[test]
    fn links_in_circles_end() {
        let meshes = folder(&["a/x.obj"]);
        std::os::unix::fs::symlink(meshes.path(), meshes.path().join("a/up")).unwrap();
        std::os::unix::fs::symlink(meshes.path().join("nothing"), meshes.path().join("a/dead")).unwrap();
        assert_eq!(outputs(&[meshes.path().to_owned()]), ["out/a/x.hullmap"]);
    }
}
