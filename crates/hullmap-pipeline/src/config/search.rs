//! Which `hullmap.toml` applies to a mesh: the nearest one above it.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs::FileType;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::rules::Rule;
use super::{Config, FILE_NAME};
use crate::options::table::OPTIONS;
use crate::options::{OptionLayer, flag};
use crate::outcome::Failure;
use crate::pack_file::folder_of;
use crate::project::ROOT_MARKS;

/// The `hullmap.toml` files of a build, each read once.
///
/// The nearest file at or above a mesh applies, up to the folder that holds `.git` or `.hg`. So the
/// choice depends on where the mesh lies, not on how it was named, or where `bake` was started.
#[derive(Debug)]
pub struct Configs {
    choice: Choice,
    /// The file found for each canonical folder.
    found: HashMap<PathBuf, Option<Arc<Config>>>,
    /// Each file that was read, by its folder.
    read: HashMap<PathBuf, Arc<Config>>,
    /// The files in use, by canonical folder, and the rules that matched a mesh.
    used: BTreeMap<PathBuf, (Arc<Config>, BTreeSet<usize>)>,
}

#[derive(Debug, Default)]
pub struct Chosen {
    pub layer: OptionLayer,
    pub skips: bool,
    pub config: Option<Arc<Config>>,
}

#[derive(Debug)]
enum Choice {
    None,
    One(Arc<Config>, PathBuf),
    Nearest,
}

impl Configs {
    pub fn new(named: Option<&Path>) -> Result<Self, Failure> {
        let choice = match named {
            Some(path) if path == Path::new("none") => Choice::None,
            Some(path) => {
                let config = Config::read(path)?;
                Choice::One(Arc::new(config), canonical(folder_of(path))?)
            }
            None => Choice::Nearest,
        };
        Ok(Self { choice, found: HashMap::new(), read: HashMap::new(), used: BTreeMap::new() })
    }

    pub fn layer(&mut self, mesh: &Path) -> Result<Chosen, Failure> {
        if matches!(self.choice, Choice::None) {
            return Ok(Chosen::default());
        }
        let folder = canonical(folder_of(mesh))?;
        let name = Path::new(mesh.file_name().unwrap_or_default());
        let (config, root) = self.applying(&folder, mesh)?;
        let mut skips = false;
        let layer = config.as_ref().map_or_else(OptionLayer::default, |config| {
            let below = folder.strip_prefix(&root).ok().map(|below| below.join(name));
            let (_, used) = self.used.entry(root.clone()).or_insert_with(|| (config.clone(), BTreeSet::new()));
            used.extend((0..config.rules.len()).filter(|&rule| config.rules[rule].matches(below.as_deref(), name)));
            skips = config.skips(below.as_deref(), name);
            config.layer(below.as_deref(), name)
        });
        Ok(Chosen { layer, skips, config })
    }

    fn applying(&mut self, folder: &Path, file: &Path) -> Result<(Option<Arc<Config>>, PathBuf), Failure> {
        match &self.choice {
            Choice::None => Ok((None, PathBuf::new())),
            Choice::One(config, root) => Ok((Some(config.clone()), root.clone())),
            Choice::Nearest => {
                let config = self.nearest(folder, folder_of(file))?;
                let root =
                    config.as_ref().map_or_else(|| Ok(PathBuf::new()), |config| canonical(folder_of(&config.path)))?;
                Ok((config, root))
            }
        }
    }

    /// The file that applies to the meshes of a folder.
    pub fn of_folder(&mut self, folder: &Path) -> Result<Option<Arc<Config>>, Failure> {
        Ok(self.applying(&canonical(folder)?, &folder.join(FILE_NAME))?.0)
    }

    /// The file is the one that applies to the description: meshes may lie in packages elsewhere.
    pub fn of_link(&mut self, description: &Path, link: &str, mesh: &Path) -> Result<Chosen, Failure> {
        let (config, root) = self.applying(&canonical(folder_of(description))?, description)?;
        let Some(config) = config else { return Ok(Chosen::default()) };
        let name = Path::new(mesh.file_name().unwrap_or_default());
        let folder = folder_of(mesh).canonicalize().ok();
        let below = folder.and_then(|folder| Some(folder.strip_prefix(&root).ok()?.join(name)));
        let (_, used) = self.used.entry(root).or_insert_with(|| (config.clone(), BTreeSet::new()));
        let (layer, skips) = config.of_link(link, below.as_deref(), name, used);
        Ok(Chosen { layer, skips, config: Some(config) })
    }

    /// Warnings about rules without meshes, and unused options of decomposed meshes, after
    /// [`layer`](Self::layer) was called for each mesh. `is_cut`: whether a file's meshes are
    /// decomposed for other reasons.
    pub fn warnings(&self, inputs: &[PathBuf], is_cut: impl Fn(&Path) -> bool) -> Vec<String> {
        let mut warnings = Vec::new();
        let inputs: Vec<PathBuf> = inputs.iter().filter_map(|input| input.canonicalize().ok()).collect();
        for (root, (config, used)) in &self.used {
            let file = config.path.display();
            // A build of part of the folder does not include the other meshes.
            let holds = |place: &Path| inputs.iter().any(|input| place.starts_with(input));
            let is_input = |source: &PathBuf| source.canonicalize().is_ok_and(|source| holds(&source));
            let is_whole = holds(root) || !config.sources.is_empty() && config.sources().iter().all(is_input);
            let is_of_links = |rule: &Rule| !rule.links.is_empty();
            let rules = (0..).zip(&config.rules).filter(|(_, rule)| !is_of_links(rule));
            let unused = rules.filter(|(rule, _)| is_whole && !used.contains(rule));
            for (_, rule) in unused {
                let globs: Vec<String> = rule.files.iter().map(|glob| format!("`{}`", glob.text)).collect();
                warnings.push(format!("{file}:{}: no mesh matches {}", rule.line, globs.join(" or ")));
            }
            if let Some(key) = config.unused_option_of_parts().filter(|_| !is_cut(&config.path)) {
                warnings.push(format!(
                    "{file}: {key} has no effect, because no mesh that this file applies to is decomposed; \
                     add decompose = true, or remove the option"
                ));
            }
        }
        warnings
    }

    /// Warnings about rules of links without a link, after [`of_link`](Self::of_link) was called
    /// for each mesh of each link.
    pub fn warnings_of_links(&self) -> Vec<String> {
        let unused = self.used.values().flat_map(|(config, used)| {
            let rules = (0..).zip(&config.rules).filter(|(rule, own)| !own.links.is_empty() && !used.contains(rule));
            rules.map(|(_, rule)| {
                let globs: Vec<String> = rule.links.iter().map(|glob| format!("`{}`", glob.text)).collect();
                format!("{}:{}: no mesh of a link matches {}", config.path.display(), rule.line, globs.join(" or "))
            })
        });
        unused.collect()
    }

    /// Notes on options of rules that `flags`, from the command line, override.
    pub fn overridden(&self, flags: &OptionLayer) -> Vec<String> {
        let mut notes = Vec::new();
        for (config, used) in self.used.values() {
            for rule in used.iter().map(|rule| &config.rules[*rule]) {
                for (at, option) in OPTIONS.iter().enumerate() {
                    let [own, given] = [&rule.layer, flags].map(|layer| layer.value_at(at));
                    if own.is_some() && given.is_some() && own != given {
                        let (file, line, key) = (config.path.display(), rule.line, option.key);
                        let flag = flag(key);
                        notes.push(format!(
                            "{file}:{line}: {key} of this rule has no effect, because {flag} overrides it"
                        ));
                    }
                }
            }
        }
        notes
    }

    fn nearest(&mut self, folder: &Path, shown: &Path) -> Result<Option<Arc<Config>>, Failure> {
        if let Some(found) = self.found.get(folder) {
            return Ok(found.clone());
        }
        let mut found = None;
        for (steps, above) in folder.ancestors().enumerate() {
            let file = above.join(FILE_NAME);
            if file_type(&file)?.is_some_and(|kind| kind.is_file()) {
                if let Some(config) = self.read.get(above) {
                    found = Some(config.clone());
                } else {
                    let config = Arc::new(Config::read(&shown_above(shown, steps, &file))?);
                    self.read.insert(above.to_owned(), config.clone());
                    found = Some(config);
                }
                break;
            }
            if is_marked(above)? {
                break;
            }
        }
        self.found.insert(folder.to_owned(), found.clone());
        Ok(found)
    }
}

fn is_marked(folder: &Path) -> Result<bool, Failure> {
    for mark in ROOT_MARKS {
        if file_type(&folder.join(mark))?.is_some() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Type of the file at a path, if there is one. A path that cannot be read may be a `hullmap.toml`:
/// that is an error, so that no mesh is baked with the wrong options.
fn file_type(path: &Path) -> Result<Option<FileType>, Failure> {
    match std::fs::metadata(path) {
        Ok(metadata) => Ok(Some(metadata.file_type())),
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
        Err(error) => Err(cannot_search(path, &error)),
    }
}

fn cannot_search(path: &Path, error: &std::io::Error) -> Failure {
    Failure::usage(format!(
        "{}: cannot search for {FILE_NAME}: {error}; check its permissions, or pass --config none",
        path.display()
    ))
}

/// `steps` folders above `shown`, or the canonical path if that name has fewer components.
fn shown_above(shown: &Path, steps: usize, canonical: &Path) -> PathBuf {
    let is_plain = !shown.components().any(|part| part == std::path::Component::ParentDir);
    let named = shown.ancestors().nth(steps).filter(|named| is_plain && *named != Path::new(""));
    let depth = shown.components().filter(|part| *part != std::path::Component::CurDir).count();
    let here = steps == depth && shown.is_relative() && is_plain;
    match named {
        Some(named) => {
            let file = named.join(FILE_NAME);
            // `./hullmap.toml` is shown without the dot.
            file.strip_prefix(".").map_or_else(|_| file.clone(), Path::to_owned)
        }
        None if here => PathBuf::from(FILE_NAME),
        None => canonical.to_owned(),
    }
}

/// A missing folder is returned unchanged: reading it fails with a better message.
fn canonical(folder: &Path) -> Result<PathBuf, Failure> {
    match folder.canonicalize() {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(folder.to_owned()),
        result => result.map_err(|error| cannot_search(folder, &error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_once() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("hullmap.toml"), "[defaults]\nunit_scale = 2\n").unwrap();
        let mut configs = Configs::new(None).unwrap();
        for mesh in ["x.obj", "y.obj"] {
            assert!(configs.layer(&folder.path().join(mesh)).unwrap().layer.get("unit_scale").is_some());
        }
        assert_eq!(configs.read.len(), 1);
    }

    #[test]
    fn files_are_shown_as_the_user_would_name_them() {
        let way = |shown: &str, steps: usize| shown_above(Path::new(shown), steps, Path::new("/c/hullmap.toml"));
        assert_eq!(way("a/b", 0), Path::new("a/b/hullmap.toml"));
        assert_eq!(way("a/b", 1), Path::new("a/hullmap.toml"));
        assert_eq!(way("a/b", 2), Path::new("hullmap.toml"));
        assert_eq!(way("a/b", 3), Path::new("/c/hullmap.toml"));
        assert_eq!(way("../a", 1), Path::new("/c/hullmap.toml"));
        assert_eq!(way(".", 0), Path::new("hullmap.toml"));
        assert_eq!(way(".", 1), Path::new("/c/hullmap.toml"));
        // It was shown, and read, as `hullmap.toml`.
        assert_eq!(way("./a", 2), Path::new("/c/hullmap.toml"));
        assert_eq!(way("./a", 1), Path::new("hullmap.toml"));
    }
}
