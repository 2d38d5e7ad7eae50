//! House rules, as tests: `structure` is about crates and packages, `prose` about comments and
//! documents. They compile little, but a newcomer's `cargo test` does not need them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use hullmap_testkit::files::workspace;

/// Every Rust file of the workspace, relative to it. Panics if a folder cannot be read.
pub fn sources() -> Vec<PathBuf> {
    fn search(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() && !path.ends_with("target") {
                search(&path, found);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    let root = workspace();
    let mut found = Vec::new();
    for folder in ["crates", "tools", "tests"] {
        search(&root.join(folder), &mut found);
    }
    found.sort();
    found.iter().map(|path| path.strip_prefix(&root).unwrap().to_owned()).collect()
}

/// Every tracked file, relative to the workspace. Empty outside of a git checkout.
///
/// # Panics
/// If a path is not UTF-8.
pub fn tracked() -> Vec<String> {
    let listed = Command::new("git").arg("ls-files").current_dir(workspace()).output();
    let listed = listed.map(|out| String::from_utf8(out.stdout).expect("paths are UTF-8")).unwrap_or_default();
    listed.lines().filter(|path| workspace().join(path).exists()).map(str::to_owned).collect()
}
