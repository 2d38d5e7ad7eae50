use std::collections::{BTreeMap, BTreeSet};
use std::io::Read as _;
use std::path::{Path, PathBuf};

use hullmap_import::open_regular;
use hullmap_robot::{Description, Link};

use hullmap_pipeline::mesh_file::obj;

pub fn starts_with(path: &Path, text: &str) -> bool {
    let mut start = Vec::new();
    let read = open_regular(path).and_then(|file| file.take(text.len() as u64).read_to_end(&mut start));
    read.is_ok() && start == text.as_bytes()
}

/// The files of a run.
#[derive(Default)]
pub struct Outputs {
    /// The file that each edited file is made of: a description, or a file that it includes.
    pub documents: BTreeMap<PathBuf, PathBuf>,
    /// Bytes of the files so far, and the description that each belongs to.
    pub written: BTreeMap<PathBuf, (Vec<u8>, String)>,
}

/// Where the hulls of a description lie.
pub struct OwnHulls {
    folder: PathBuf,
    /// Meshes that the description named before.
    named: BTreeSet<PathBuf>,
}

impl OwnHulls {
    /// `None` if the folder is the model's own, which holds other meshes, too.
    pub fn new(description: &Description, output: &Path, folder: &Path) -> Option<Self> {
        let meshes = description.links.iter().flat_map(Link::meshes);
        let named = meshes.filter_map(|mesh| mesh.file.as_ref().ok()?.canonicalize().ok()).collect();
        description.mesh_folder(output).is_none().then(|| Self { folder: folder.to_owned(), named })
    }

    /// Hulls in the folder that no description of this run uses.
    pub fn left_over(&self, outputs: &Outputs) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(&self.folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let is_hull = |path: &PathBuf| {
            path.extension().is_some_and(|extension| extension == "obj") && starts_with(path, obj::START)
        };
        let is_used = |path: &PathBuf| self.named.contains(path) || outputs.written.contains_key(path);
        let mut unused: Vec<PathBuf> = entries.filter(is_hull).filter(|path| !is_used(path)).collect();
        unused.sort();
        unused
    }
}
