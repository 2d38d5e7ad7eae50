//! Files: the workspace's folder, those that an environment variable names, and those in a folder.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// The path in the environment variable `variable`. If it is not set, prints which test is skipped
/// and returns `None`. Panics if the path does not exist: a requested test must not be skipped.
pub fn path(variable: &str, test: &str) -> Option<PathBuf> {
    let Some(path) = std::env::var_os(variable).filter(|value| !value.is_empty()) else {
        println!("skipped: {test}: {variable} is not set");
        return None;
    };
    // Cargo runs a test in its package's folder; the path is relative to the workspace.
    let path = workspace().join(path);
    assert!(path.exists(), "{variable} names {}, which does not exist", path.display());
    Some(path)
}

/// The workspace's folder.
pub fn workspace() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.ancestors().nth(2).expect("the package lies two folders below the workspace").to_owned()
}

/// Writes a file below `folder`, and makes the folders above it. Panics if that fails.
pub fn write(folder: impl AsRef<Path>, name: &str, bytes: impl AsRef<[u8]>) {
    let path = folder.as_ref().join(name);
    fs::create_dir_all(path.parent().expect("a file is in a folder")).unwrap();
    fs::write(path, bytes).unwrap();
}

/// A temporary folder with these files. Panics if it cannot be made.
pub fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    files.iter().for_each(|(name, text)| write(&folder, name, text));
    folder
}

/// Every file below a folder, by its relative path. Panics if one cannot be read.
pub fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    fn walk(folder: &Path, root: &Path, found: &mut BTreeMap<String, Vec<u8>>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, root, found);
            } else {
                found.insert(path.strip_prefix(root).unwrap().display().to_string(), fs::read(&path).unwrap());
            }
        }
    }
    let mut found = BTreeMap::new();
    walk(folder, folder, &mut found);
    found
}
