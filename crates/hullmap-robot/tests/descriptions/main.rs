//! Robot descriptions: what is found in each format, what changes, and how their chains move.

mod chains;
mod formats;
mod mesh_paths;
mod random;

use std::path::{Path, PathBuf};

use hullmap_robot::{Description, Places, RobotError};

/// A folder with these files, and its path without links.
fn folder(files: &[(&str, &str)]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    let root = folder.path().canonicalize().unwrap();
    (folder, root)
}

fn read(root: &Path, name: &str) -> Result<Description, RobotError> {
    let places = Places { roots: vec![root.to_owned()], ..Places::default() };
    Description::read(&root.join(name), &places)
}
