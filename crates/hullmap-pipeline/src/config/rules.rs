//! The rules of a `hullmap.toml`: options for all meshes, for meshes that globs match, and for
//! links of robots.

use std::path::{Path, PathBuf};

use crate::glob::Glob;
use crate::options::OptionLayer;

#[derive(Debug)]
pub struct Config {
    pub path: PathBuf,
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

    pub fn skips(&self, below: Option<&Path>, name: &Path) -> bool {
        let rules = self.rules.iter().filter(|rule| rule.matches(below, name));
        rules.filter_map(|rule| rule.skip).next_back().unwrap_or(false)
    }

    /// Options for a mesh of a link, and whether the mesh is left alone.
    pub fn of_link(&self, link: &str, below: Option<&Path>, name: &Path) -> (OptionLayer, bool) {
        let rules: Vec<&Rule> = self.rules.iter().filter(|rule| rule.matches_link(link, below, name)).collect();
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
