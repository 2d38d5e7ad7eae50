//! Files under `assets/`: generation, comparison and writing.
//!
//! The generator owns the folder: its OBJ files and its `README.md` are exactly the files that
//! [`generate`] returns.

use crate::models::{self, Model};
use std::fmt::{self, Write as _};
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

const README: &str = "README.md";

/// Name and bytes of a generated file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GeneratedFile {
    /// Name under `assets/`.
    pub name: String,
    /// All of its bytes.
    pub bytes: Vec<u8>,
}

/// Difference between a file and the generated one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Difference {
    /// The file does not exist.
    Missing,
    /// The bytes differ.
    Changed {
        /// One-based number of the first line that differs.
        line: usize,
    },
    /// The file is an OBJ file that is not generated.
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

/// Adds the action and the path to an I/O error.
fn failed<'a>(action: &'static str, path: &'a Path) -> impl FnOnce(io::Error) -> AssetError + 'a {
    move |source| AssetError { action, path: path.to_owned(), source }
}

/// All files under `assets/`: the models, then the table of models.
pub fn generate() -> Vec<GeneratedFile> {
    let models = models::all();
    let readme = GeneratedFile { name: README.to_owned(), bytes: readme(&models).into_bytes() };
    models
        .iter()
        .map(|model| GeneratedFile { name: model.file_name.to_owned(), bytes: model.document.to_text().into_bytes() })
        .chain([readme])
        .collect()
}

/// Names of the files in `dir` that differ from the generated ones, each with its difference. Fails
/// if the folder or a file in it cannot be read.
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
    // Folders are listed in no particular order.
    strays.sort_by(|a, b| a.0.cmp(&b.0));
    differences.extend(strays);
    Ok(differences)
}

/// Writes the missing and different files to `dir`, and returns their names. Creates the folder if
/// necessary.
///
/// Each file is written to a temporary file and renamed. OBJ files that are not generated stay as
/// they are. Fails if a folder or file cannot be read or written.
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

fn replace(path: &Path, bytes: &[u8]) -> Result<(), AssetError> {
    let mut beside = path.as_os_str().to_owned();
    beside.push(".partial");
    let beside = PathBuf::from(beside);
    let mut file = File::create(&beside).map_err(failed("create", &beside))?;
    file.write_all(bytes).map_err(failed("write", &beside))?;
    file.sync_all().map_err(failed("write", &beside))?;
    fs::rename(&beside, path).map_err(failed("move a file to", path))
}

fn first_different_line(a: &[u8], b: &[u8]) -> usize {
    let same = a.iter().zip(b).take_while(|(x, y)| x == y).count();
    1 + a[..same].iter().filter(|byte| **byte == b'\n').count()
}

/// The table of models, as Markdown.
fn readme(models: &[Model]) -> String {
    let mut text = String::from(
        "# Assets\n\
         \n\
         Small OBJ files for tests, examples and first tries. `cargo run -p shapes --bin make-assets -- assets` generates\n\
         them, so they have the project's licences. Each file states its parameters. Lengths have no unit, z is up, and\n\
         faces wind counter-clockwise seen from outside. The rank is 0 for a point, 1 a line, 2 a plane, 3 a solid.\n\
         \n\
         | File | Model | Exercises | Rank | Vertices | Faces |\n\
         |---|---|---|---:|---:|---:|\n",
    );
    for model in models {
        writeln!(
            text,
            "| [{file}]({file}) | {} | {} | {} | {} | {} |",
            model.title,
            model.exercises,
            model.rank,
            model.document.vertex_count(),
            model.document.face_count(),
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
    fn files_are_small_and_have_distinct_names() {
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
