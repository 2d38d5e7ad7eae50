//! The rules of a `hullmap.toml`: options for all meshes, for meshes that globs match, and for
//! links of robots.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::glob::Glob;
use crate::options::OptionLayer;
use crate::outcome::Failure;
use crate::pack_file::{folder_of, link_below};

#[derive(Debug, Default)]
pub struct Config {
    pub path: PathBuf,
    /// The folder of packs, relative to the folder of the file, and its line.
    pub(super) output: Option<(usize, PathBuf)>,
    /// Meshes and folders, relative to the folder of the file; empty for this folder.
    pub(super) sources: Vec<PathBuf>,
    pub(super) defaults: OptionLayer,
    /// In the file's order: later rules override earlier ones.
    pub(super) rules: Vec<Rule>,
}

#[derive(Debug)]
pub(super) struct Rule {
    /// Line of the globs in the file.
    pub(super) line: usize,
    /// Globs of meshes; empty for a rule of links alone.
    pub(super) files: Vec<Glob>,
    /// Globs of links of robots. A rule that has some applies to robots only.
    pub(super) links: Vec<Glob>,
    /// Whether its meshes are left out; `None` if the rule does not state it.
    pub(super) skip: Option<bool>,
    pub(super) layer: OptionLayer,
}

impl Config {
    /// `below` is the mesh's path relative to the file's folder; `None` for a mesh outside, to
    /// which only globs without `/` can apply. `name` is its file name.
    pub fn layer(&self, below: Option<&Path>, name: &Path) -> OptionLayer {
        let rules = self.rules.iter().filter(|rule| rule.matches(below, name));
        rules.fold(self.defaults.clone(), |lower, rule| rule.layer.laid_over(&lower))
    }

    /// The folder of the packs. Fails if a link leads to it, perhaps out of the project.
    pub fn output(&self) -> Result<Option<PathBuf>, Failure> {
        let Some((line, output)) = &self.output else { return Ok(None) };
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let found = folder.join(output);
        match link_below(folder, &found) {
            None => Ok(Some(found)),
            Some(link) => Err(Failure::usage(format!(
                "{}:{line}: output leads through the link {}; replace it by a folder, or name the folder with --out",
                self.path.display(),
                link.display()
            ))),
        }
    }

    /// The inputs of a build that names none.
    pub fn sources(&self) -> Vec<PathBuf> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        if self.sources.is_empty() {
            return vec![folder_of(&self.path).to_owned()];
        }
        self.sources.iter().map(|source| folder.join(source)).collect()
    }

    pub fn skips(&self, below: Option<&Path>, name: &Path) -> bool {
        let rules = self.rules.iter().filter(|rule| rule.matches(below, name));
        rules.filter_map(|rule| rule.skip).next_back().unwrap_or(false)
    }

    /// Options for a mesh of a link, and whether the mesh is left alone. Adds the indices of the
    /// rules that match to `used`.
    pub fn of_link(
        &self,
        link: &str,
        below: Option<&Path>,
        name: &Path,
        used: &mut BTreeSet<usize>,
    ) -> (OptionLayer, bool) {
        let matching = (0..).zip(&self.rules).filter(|(_, rule)| rule.matches_link(link, below, name));
        let (indices, rules): (Vec<usize>, Vec<&Rule>) = matching.unzip();
        used.extend(indices);
        let layer = rules.iter().fold(self.defaults.clone(), |lower, rule| rule.layer.laid_over(&lower));
        (layer, rules.iter().filter_map(|rule| rule.skip).next_back().unwrap_or(false))
    }

    /// An option of decomposed meshes in a file that never switches decomposition on.
    pub(super) fn unused_option_of_parts(&self) -> Option<&'static str> {
        let layers = || std::iter::once(&self.defaults).chain(self.rules.iter().map(|rule| &rule.layer));
        let decomposes = layers().any(|layer| layer.decompose() == Some(true));
        layers().find_map(OptionLayer::first_option_of_parts).filter(|_| !decomposes)
    }
}

impl Rule {
    pub(super) fn matches(&self, below: Option<&Path>, name: &Path) -> bool {
        self.links.is_empty() && self.files.iter().any(|glob| glob.matches(below, name))
    }

    /// Both globs must match, where the rule has them.
    fn matches_link(&self, link: &str, below: Option<&Path>, name: &Path) -> bool {
        let link = Path::new(link);
        (self.files.is_empty() || self.files.iter().any(|glob| glob.matches(below, name)))
            && (self.links.is_empty() || self.links.iter().any(|glob| glob.matches(Some(link), link)))
    }
}
