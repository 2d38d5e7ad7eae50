//! Which meshes of the inputs are baked: `--exclude` and `--ext`.

use std::path::Path;

use super::selection::Selection;
use crate::glob::Glob;

#[derive(Debug, Default)]
pub struct Filter {
    /// Each with whether it has matched a mesh.
    excluded: Vec<(Glob, bool)>,
    /// Extensions of meshes in folders, in lower case; empty for all.
    extensions: Vec<String>,
}

impl Filter {
    pub fn new(selection: &Selection) -> Self {
        Self {
            excluded: selection.exclude.iter().map(|glob| (glob.clone(), false)).collect(),
            extensions: selection.extensions.iter().map(|extension| extension.to_lowercase()).collect(),
        }
    }

    /// Whether a mesh is baked. `below` is its path relative to the input folder; `None` for a mesh
    /// that is itself an input, which may have any extension.
    pub fn keeps(&mut self, below: Option<&Path>, mesh: &Path) -> bool {
        let name = Path::new(mesh.file_name().unwrap_or_default());
        let mut is_excluded = false;
        for (glob, has_matched) in &mut self.excluded {
            let is_match = glob.matches(below, name);
            *has_matched |= is_match;
            is_excluded |= is_match;
        }
        let is_listed = || {
            let extension = mesh.extension().unwrap_or_default().to_string_lossy().to_lowercase();
            self.extensions.contains(&extension)
        };
        !is_excluded && (below.is_none() || self.extensions.is_empty() || is_listed())
    }

    pub fn unused(&self) -> impl Iterator<Item = &str> {
        self.excluded.iter().filter(|(_, has_matched)| !has_matched).map(|(glob, _)| glob.text.as_str())
    }
}
