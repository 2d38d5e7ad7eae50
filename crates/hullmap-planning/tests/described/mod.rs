//! Robots of descriptions in text.

use std::path::PathBuf;

use hullmap_planning::{Packs, Robot};
use hullmap_robot::Places;

/// A file in a folder of its own, which is deleted with the guard.
pub fn file(name: &str, text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

pub fn robot(name: &str, text: &str) -> Robot {
    let (_guard, path) = file(name, text);
    Robot::read(&path, &Places::beside(&path).unwrap(), &mut Packs::default()).unwrap()
}
