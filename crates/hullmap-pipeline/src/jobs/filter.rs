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

    /// Whether a mesh is baked: no glob of `--exclude` matches it or a folder that it is in.
    /// `below` is its path relative to the input folder; `None` for a mesh that is itself an
    /// input, which may have any extension.
    pub fn keeps(&mut self, below: Option<&Path>, mesh: &Path) -> bool {
        let name = Path::new(mesh.file_name().unwrap_or_default());
        // As typed: folders above an absolute path do not count.
        let typed = Some(mesh.strip_prefix(".").unwrap_or(mesh)).filter(|mesh| mesh.is_relative());
        let mut is_excluded = false;
        for (glob, has_matched) in &mut self.excluded {
            let typed = typed.filter(|_| !glob.is_of_names());
            let is_match =
                glob.matches(below, name) || below.into_iter().chain(typed).any(|path| glob.matches_within(path));
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
