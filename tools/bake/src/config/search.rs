//! Which `hullmap.toml` counts for a mesh.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs::FileType;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Config, FILE_NAME};
use crate::option_layer::OptionLayer;
use crate::outcome::Failure;
use crate::pack_file::{folder_of, shown_from};

/// What marks the root of a project, beside the folder that `bake` was started in.
const ROOT_MARKS: [&str; 2] = [".git", ".hg"];

/// The `hullmap.toml` files of a build, each read once.
///
/// The nearest one counts for a mesh: in the mesh's folder, or in the next folder above it that has one. The search ends with
/// the folder that holds a version control's `.git` or `.hg`, else with the one that `bake` was started in, else at the file
/// system's root. So which one counts depends on where the mesh lies, not on how it was named.
#[derive(Debug)]
pub struct Configs {
    choice: Choice,
    /// The folder that `bake` was started in, canonical.
    project: PathBuf,
    /// What was found for each canonical folder.
    found: HashMap<PathBuf, Option<Arc<Config>>>,
    /// Each file that was read, by its folder.
    read: HashMap<PathBuf, Arc<Config>>,
    /// The files that counted, by their canonical folders, each with the rules that matched a mesh.
    met: BTreeMap<PathBuf, (Arc<Config>, BTreeSet<usize>)>,
    /// Files above the folder that `bake` was started in that would have counted, had it been started there.
    unread: BTreeSet<PathBuf>,
}

#[derive(Debug)]
enum Choice {
    /// None whatever.
    None,
    /// This one for all, with its canonical folder.
    One(Arc<Config>, PathBuf),
    /// The nearest.
    Nearest,
}

impl Configs {
    /// The files that count: none, the one named, or the nearest ones.
    ///
    /// # Errors
    /// The one named cannot be read or is faulty.
    pub fn new(named: Option<&Path>, none: bool, project: &Path) -> Result<Self, Failure> {
        let choice = match named {
            _ if none => Choice::None,
            Some(path) => {
                let config = Config::read(path)?;
                Choice::One(Arc::new(config), canonical(folder_of(path))?)
            }
            None => Choice::Nearest,
        };
        Ok(Self {
            choice,
            project: canonical(project)?,
            found: HashMap::new(),
            read: HashMap::new(),
            met: BTreeMap::new(),
            unread: BTreeSet::new(),
        })
    }

    /// What the file that counts for `mesh` says of it, and that file.
    ///
    /// # Errors
    /// The file cannot be read or is faulty.
    pub fn layer(&mut self, mesh: &Path) -> Result<(OptionLayer, Option<Arc<Config>>), Failure> {
        if matches!(self.choice, Choice::None) {
            return Ok((OptionLayer::default(), None));
        }
        let folder = canonical(folder_of(mesh))?;
        let name = Path::new(mesh.file_name().unwrap_or_default());
        let (config, root) = match &self.choice {
            Choice::None => (None, PathBuf::new()),
            Choice::One(config, root) => (Some(config.clone()), root.clone()),
            Choice::Nearest => {
                let config = self.nearest(&folder, folder_of(mesh))?;
                let root =
                    config.as_ref().map_or_else(|| Ok(PathBuf::new()), |config| canonical(folder_of(&config.path)))?;
                (config, root)
            }
        };
        let layer = config.as_ref().map_or_else(OptionLayer::default, |config| {
            let place = folder.strip_prefix(&root).ok().map(|below| below.join(name));
            let (_, met) = self.met.entry(root.clone()).or_insert_with(|| (config.clone(), BTreeSet::new()));
            met.extend((0..config.rules.len()).filter(|&rule| config.rules[rule].matches(place.as_deref(), name)));
            config.layer(place.as_deref(), name)
        });
        Ok((layer, config))
    }

    /// What the user should look at once each mesh of `inputs` has had its layer, a sentence each: files that are not read,
    /// rules for no mesh, parameters of a decomposition that nobody asks for. `is_cut` tells whether a file's meshes are cut
    /// all the same.
    pub fn warnings(&self, inputs: &[PathBuf], is_cut: impl Fn(&Path) -> bool) -> Vec<String> {
        let mut warnings: Vec<String> = self.unread.iter().map(|path| self.unread_warning(path)).collect();
        let folders: Vec<PathBuf> =
            inputs.iter().filter(|input| input.is_dir()).filter_map(|input| input.canonicalize().ok()).collect();
        for (root, (config, met)) in &self.met {
            let file = config.path.display();
            // Of a part of the folder, nothing is known of the meshes elsewhere.
            let is_whole = folders.iter().any(|folder| root.starts_with(folder));
            let idle = (0..).zip(&config.rules).filter(|(number, _)| is_whole && !met.contains(number));
            for (_, rule) in idle {
                let globs: Vec<String> = rule.files.iter().map(|glob| format!("`{}`", glob.text)).collect();
                warnings.push(format!("{file}:{}: no mesh matches {}", rule.line, globs.join(" or ")));
            }
            if let Some(key) = config.idle_parameter().filter(|_| !is_cut(&config.path)) {
                warnings.push(format!(
                    "{file}: {key} applies to nothing: its meshes are not decomposed; add decompose = true, or leave it out"
                ));
            }
        }
        warnings
    }

    fn unread_warning(&self, path: &Path) -> String {
        let file = shown_from(path, &self.project);
        let file = file.display();
        format!(
            "{file} lies above the folder that bake was started in and is not read; start bake there, or pass --config {file} \
             or --no-config"
        )
    }

    /// The nearest file in or above a canonical folder, which the user knows as `shown`.
    fn nearest(&mut self, folder: &Path, shown: &Path) -> Result<Option<Arc<Config>>, Failure> {
        if let Some(found) = self.found.get(folder) {
            return Ok(found.clone());
        }
        let mut found = None;
        for (steps, above) in folder.ancestors().enumerate() {
            let place = above.join(FILE_NAME);
            if kind_of(&place)?.is_some_and(|kind| kind.is_file()) {
                if let Some(config) = self.read.get(above) {
                    found = Some(config.clone());
                } else {
                    let config = Arc::new(Config::read(&shown_above(shown, steps, &place))?);
                    self.read.insert(above.to_owned(), config.clone());
                    found = Some(config);
                }
                break;
            }
            if self.is_root(above, folder)? {
                if !is_marked(above)? {
                    let mut files = above.ancestors().skip(1).map(|above| above.join(FILE_NAME));
                    self.unread.extend(files.find(|file| file.is_file()));
                }
                break;
            }
        }
        self.found.insert(folder.to_owned(), found.clone());
        Ok(found)
    }

    fn is_root(&self, above: &Path, folder: &Path) -> Result<bool, Failure> {
        if is_marked(above)? {
            return Ok(true);
        }
        if above != self.project || !folder.starts_with(&self.project) {
            return Ok(false);
        }
        for above in above.ancestors() {
            if is_marked(above)? {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// Whether a folder is the root of a project for all to see.
fn is_marked(folder: &Path) -> Result<bool, Failure> {
    for mark in ROOT_MARKS {
        if kind_of(&folder.join(mark))?.is_some() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// What there is at a path, if anything. What cannot be asked may be a file that counts: that is an error, lest meshes are baked
/// with other options than theirs.
fn kind_of(path: &Path) -> Result<Option<FileType>, Failure> {
    match std::fs::metadata(path) {
        Ok(metadata) => Ok(Some(metadata.file_type())),
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
        Err(error) => Err(cannot_search(path, &error)),
    }
}

fn cannot_search(path: &Path, error: &std::io::Error) -> Failure {
    Failure::usage(format!("{}: cannot search for {FILE_NAME}: {error}; --no-config goes without", path.display()))
}

/// The file as the user would name it: from the folder that was named, while that has so many folders above it.
fn shown_above(shown: &Path, steps: usize, canonical: &Path) -> PathBuf {
    let is_plain = !shown.components().any(|part| part == std::path::Component::ParentDir);
    let named = shown.ancestors().nth(steps).filter(|named| is_plain && *named != Path::new(""));
    let here = steps == shown.components().count() && shown.is_relative() && is_plain && shown != Path::new(".");
    match named {
        Some(named) => {
            let file = named.join(FILE_NAME);
            // `./hullmap.toml` reads as a file in this folder just as well without the dot.
            file.strip_prefix(".").map_or_else(|_| file.clone(), Path::to_owned)
        }
        None if here => PathBuf::from(FILE_NAME),
        None => canonical.to_owned(),
    }
}

/// The folder's canonical path; as it is where it is not there, so that reading it fails with a message of its own.
fn canonical(folder: &Path) -> Result<PathBuf, Failure> {
    match folder.canonicalize() {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(folder.to_owned()),
        result => result.map_err(|error| cannot_search(folder, &error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        folder
    }

    /// Unit scale that counts for a mesh, where each file sets its own.
    fn scale(configs: &mut Configs, root: &Path, mesh: &str) -> Option<f64> {
        configs.layer(&root.join(mesh)).unwrap().0.unit_scale
    }

    const FILES: [(&str, &str); 5] = [
        ("hullmap.toml", "[defaults]\nunit_scale = 1\n"),
        ("repo/assets/hullmap.toml", "[defaults]\nunit_scale = 2\n[[rule]]\nfiles = \"deep/*.obj\"\nunit_scale = 3\n"),
        ("repo/.git/HEAD", ""),
        ("repo/assets/deep/er/x.obj", ""),
        ("repo/other/x.obj", ""),
    ];

    #[test]
    fn the_nearest_file_up_to_the_root_counts() {
        let folder = folder(&FILES);
        let mut configs = Configs::new(None, false, folder.path()).unwrap();
        for (mesh, expected) in [
            ("x.obj", Some(1.0)),
            ("repo/assets/x.obj", Some(2.0)),
            ("repo/assets/deep/x.obj", Some(3.0)),
            ("repo/assets/deep/er/x.obj", Some(2.0)),
            ("repo/other/x.obj", None),
            ("repo/x.obj", None),
        ] {
            assert_eq!(scale(&mut configs, folder.path(), mesh), expected, "{mesh}");
        }
        assert_eq!(configs.read.len(), 2, "each is read once");
    }

    #[test]
    fn without_version_control_the_folder_of_the_start_is_the_root() {
        let folder = folder(&[("hullmap.toml", "[defaults]\nunit_scale = 1\n"), ("a/b/x.obj", "")]);
        let mut inside = Configs::new(None, false, &folder.path().join("a")).unwrap();
        assert_eq!(scale(&mut inside, folder.path(), "a/b/x.obj"), None);
        let warnings = inside.warnings(&[], |_| false);
        assert!(warnings.len() == 1 && warnings[0].starts_with("../hullmap.toml lies above"), "{warnings:?}");
        let mut outside = Configs::new(None, false, folder.path()).unwrap();
        assert_eq!(scale(&mut outside, folder.path(), "a/b/x.obj"), Some(1.0));
        assert!(outside.warnings(&[], |_| false).is_empty());
    }

    #[test]
    fn rules_for_no_mesh_are_told_where_the_whole_folder_is_built() {
        let text = "[defaults]\nvhacd_alpha = 0.5\n[[rule]]\nsplit = \"none\"\nfiles = [\"propz/**\", \"*.stl\"]\n\n[[rule]]\nfiles = \"b/*\"\n";
        let folder = folder(&[("a/hullmap.toml", text), ("a/b/x.obj", "")]);
        let mut configs = Configs::new(None, false, folder.path()).unwrap();
        configs.layer(&folder.path().join("a/b/x.obj")).unwrap();
        let warned = |input: &str| configs.warnings(&[folder.path().join(input)], |_| input == "a").join("|");
        assert!(warned("a").ends_with("a/hullmap.toml:5: no mesh matches `propz/**` or `*.stl`"), "{}", warned("a"));
        assert!(warned("a/b").contains("vhacd_alpha applies to nothing") && !warned("a/b").contains('|'));
        assert!(warned(".").contains('|'));
    }

    #[test]
    fn a_named_file_counts_for_all_and_none_for_nothing() {
        let folder = folder(&FILES);
        let named = folder.path().join("repo/assets/hullmap.toml");
        let mut configs = Configs::new(Some(&named), false, folder.path()).unwrap();
        assert_eq!(scale(&mut configs, folder.path(), "repo/other/x.obj"), Some(2.0));
        assert_eq!(scale(&mut configs, folder.path(), "repo/assets/deep/x.obj"), Some(3.0));
        let mut configs = Configs::new(None, true, folder.path()).unwrap();
        assert_eq!(scale(&mut configs, folder.path(), "repo/assets/x.obj"), None);
        assert!(Configs::new(Some(&folder.path().join("no.toml")), false, folder.path()).is_err());
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
    }
}
