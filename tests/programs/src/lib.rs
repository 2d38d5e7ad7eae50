//! Functions that several of the programs use.

use std::path::{Path, PathBuf};

use hullmap_bake::PointSet;
use hullmap_import::{ImportOptions, Limits, Split, import, read};

/// The OBJ meshes of a folder whose names contain `only`, with their names, sorted by path.
///
/// # Panics
/// If the folder or a mesh cannot be read.
pub fn meshes_of(folder: &Path, only: &str) -> Vec<(String, PointSet)> {
    let entries = std::fs::read_dir(folder).expect("the folder can be read");
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "obj"));
    paths.sort();
    let named =
        paths.into_iter().map(|path| (path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), path));
    named.filter(|(name, _)| name.contains(only)).map(|(name, path)| (name.clone(), imported(&name, &path))).collect()
}

/// The whole of an OBJ file.
fn imported(name: &str, path: &Path) -> PointSet {
    sets(name, path, Split::None).swap_remove(0)
}

/// The objects of an OBJ file.
///
/// # Panics
/// If the file cannot be read.
pub fn objects_of(name: &str, path: &Path) -> Vec<PointSet> {
    sets(name, path, Split::Object)
}

fn sets(name: &str, path: &Path, split: Split) -> Vec<PointSet> {
    let source = read(name, path, &Limits::DEFAULT).expect("the mesh can be read");
    let options = ImportOptions { split, ..ImportOptions::DEFAULT };
    let imported = import(name, name, path, &source, &options, &Limits::DEFAULT);
    let mut imported = imported.expect("the mesh can be imported");
    imported.give_triangles();
    imported.point_sets
}
