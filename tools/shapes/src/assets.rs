//! The files under `assets/`: what they should hold, whether they do, and writing them.
//!
//! The folder belongs to the generator: its OBJ files and its `README.md` are those of [`generate`] and no others.

use crate::models::{self, Model};
use std::fmt::{self, Write as _};
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Name of the file with the table of models.
const README: &str = "README.md";

/// A file as it should be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GeneratedFile {
    /// Name under `assets/`.
    pub name: String,
    /// All of its bytes.
    pub bytes: Vec<u8>,
}

/// How a file in a folder departs from what is generated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Difference {
    /// It is not there.
    Missing,
    /// Its bytes differ, for the first time in this line, counted from 1.
    Changed {
        /// First line that differs.
        line: usize,
    },
    /// It is an OBJ file that is not generated.
    Unexpected,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing => f.write_str("missing"),
            Self::Changed { line } => write!(f, "differs from line {line} on"),
            Self::Unexpected => f.write_str("not generated"),
        }
    }
}

/// A file or folder that could not be read or written.
#[derive(Debug)]
pub struct AssetError {
    action: &'static str,
    path: PathBuf,
    source: io::Error,
}

impl fmt::Display for AssetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (path, action, source) = (self.path.display(), self.action, &self.source);
        write!(f, "{path}: cannot {action}: {source}")
    }
}

impl std::error::Error for AssetError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.source)
    }
}

/// Attaches what was being done, and to which file.
fn failed<'a>(action: &'static str, path: &'a Path) -> impl FnOnce(io::Error) -> AssetError + 'a {
    move |source| AssetError { action, path: path.to_owned(), source }
}

/// Every file that belongs under `assets/`: the models, then the table of them.
pub fn generate() -> Vec<GeneratedFile> {
    let models = models::all();
    let readme = GeneratedFile { name: README.to_owned(), bytes: readme(&models).into_bytes() };
    models
        .iter()
        .map(|model| GeneratedFile { name: model.file_name.to_owned(), bytes: model.document.to_text().into_bytes() })
        .chain([readme])
        .collect()
}

/// Names of the files in `dir` that are not as generated, with what is wrong with each.
///
/// # Errors
/// If the folder or a file in it cannot be read.
pub fn compare(dir: &Path) -> Result<Vec<(String, Difference)>, AssetError> {
    let expected = generate();
    let mut differences = Vec::new();
    for file in &expected {
        let path = dir.join(&file.name);
        match fs::read(&path) {
            Ok(found) if found == file.bytes => {}
            Ok(found) => {
                let line = first_different_line(&found, &file.bytes);
                differences.push((file.name.clone(), Difference::Changed { line }));
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                differences.push((file.name.clone(), Difference::Missing));
            }
            Err(error) => return Err(failed("read", &path)(error)),
        }
    }
    let mut strays = Vec::new();
    for entry in fs::read_dir(dir).map_err(failed("read the folder", dir))? {
        let name = entry.map_err(failed("read the folder", dir))?.file_name();
        let name = name.to_string_lossy().into_owned();
        if name.ends_with(".obj") && expected.iter().all(|file| file.name != name) {
            strays.push((name, Difference::Unexpected));
        }
    }
    // Folders list in any order.
    strays.sort_by(|a, b| a.0.cmp(&b.0));
    differences.extend(strays);
    Ok(differences)
}

/// Writes what is missing or different into `dir`, which is made if need be, and returns the names written.
///
/// Each file is written beside its place and moved there whole. OBJ files that are not generated are left alone.
///
/// # Errors
/// If a folder or file cannot be read or written.
pub fn write(dir: &Path) -> Result<Vec<String>, AssetError> {
    fs::create_dir_all(dir).map_err(failed("make the folder", dir))?;
    let stale = compare(dir)?;
    let mut written = Vec::new();
    for file in generate() {
        if stale.iter().any(|(name, _)| *name == file.name) {
            replace(&dir.join(&file.name), &file.bytes)?;
            written.push(file.name);
        }
    }
    Ok(written)
}

/// Writes `bytes` to a file beside `path`, then renames it.
fn replace(path: &Path, bytes: &[u8]) -> Result<(), AssetError> {
    let mut beside = path.as_os_str().to_owned();
    beside.push(".partial");
    let beside = PathBuf::from(beside);
    let mut file = File::create(&beside).map_err(failed("create", &beside))?;
    file.write_all(bytes).map_err(failed("write", &beside))?;
    file.sync_all().map_err(failed("write", &beside))?;
    fs::rename(&beside, path).map_err(failed("move a file to", path))
}

/// Line, from 1, of the first byte at which two different texts part.
fn first_different_line(a: &[u8], b: &[u8]) -> usize {
    let same = a.iter().zip(b).take_while(|(x, y)| x == y).count();
    1 + a[..same].iter().filter(|byte| **byte == b'\n').count()
}

/// The table of models, as Markdown.
fn readme(models: &[Model]) -> String {
    let mut text = String::from(
        "# Assets\n\
         \n\
         Small OBJ files for tests, examples and first tries. The project makes them itself, from numbers alone: they\n\
         carry the project's own licences, and their bytes are the same on every machine. Lengths have no unit, z is\n\
         up, faces wind counter-clockwise seen from outside.\n\
         \n\
         To make them again, after a change in `tools/shapes`:\n\
         \n    \
         cargo run -p shapes --bin make-assets -- assets\n\
         \n\
         To see whether they are what would be made (`cargo test -p shapes` asks the same):\n\
         \n    \
         cargo run -p shapes --bin make-assets -- --check assets\n\
         \n\
         Rank is that of all vertices together: 0 a point, 1 a line, 2 a plane, 3 a solid. Vertices are `v` lines,\n\
         faces `f` lines.\n\
         \n\
         | File | Is | Exercises | Rank | Vertices | Faces | Parameters |\n\
         |---|---|---|---:|---:|---:|---|\n",
    );
    for model in models {
        writeln!(
            text,
            "| [{file}]({file}) | {} | {} | {} | {} | {} | {} |",
            model.title,
            model.exercises,
            model.rank,
            model.document.vertex_count(),
            model.document.face_count(),
            model.parameters,
            file = model.file_name,
        )
        .expect("writing to a string does not fail");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_small_and_told_apart_by_name() {
        let files = generate();
        let mut names: Vec<_> = files.iter().map(|f| f.name.to_lowercase()).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), files.len());
        assert!(files.iter().all(|f| f.bytes.len() < 150_000));
        assert!(files.iter().map(|f| f.bytes.len()).sum::<usize>() < 700_000);
    }

    #[test]
    fn first_difference_is_located() {
        assert_eq!(first_different_line(b"a\nb\nc", b"a\nb\nd"), 3);
        assert_eq!(first_different_line(b"x", b"y"), 1);
        assert_eq!(first_different_line(b"a\n", b"a\nb\n"), 2);
    }
}
