//! The inputs of a command, and what leaves some of their meshes out.

use std::path::PathBuf;

use crate::glob::Glob;
use crate::options::OptionLayer;

/// The meshes to bake: the inputs, and what leaves some of them out.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Meshes, and folders to search for them.
    pub inputs: Vec<PathBuf>,
    /// Only these meshes of the inputs, and meshes in these folders; empty for all.
    pub only: Vec<PathBuf>,
    /// Options that override `hullmap.toml`.
    pub options: OptionLayer,
    /// The `hullmap.toml` of all meshes, or `none`; otherwise the nearest one above each.
    pub config: Option<PathBuf>,
    /// Leaves out the meshes that match.
    pub exclude: Vec<Glob>,
    /// Also takes hidden meshes in folders, and those that a `.gitignore` names.
    pub no_ignore: bool,
    /// Extensions of meshes in folders; empty for all.
    pub extensions: Vec<String>,
}
