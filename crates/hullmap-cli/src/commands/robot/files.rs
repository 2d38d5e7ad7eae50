use std::collections::BTreeSet;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use hullmap_import::open_regular;

use hullmap_pipeline::mesh_file::obj;

pub fn starts_with(path: &Path, text: &str) -> bool {
    let mut start = Vec::new();
    let read = open_regular(path).and_then(|file| file.take(text.len() as u64).read_to_end(&mut start));
    read.is_ok() && start == text.as_bytes()
}

pub fn left_over(folder: &Path, used: &BTreeSet<PathBuf>) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let is_hull =
        |path: &PathBuf| path.extension().is_some_and(|extension| extension == "obj") && starts_with(path, obj::START);
    let mut unused: Vec<PathBuf> = entries.filter(is_hull).filter(|path| !used.contains(path)).collect();
    unused.sort();
    unused
}
