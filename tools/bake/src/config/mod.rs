//! `hullmap.toml`: the options of a project's meshes, kept beside them.
//!
//! 1. [`search`] finds the file that counts for a mesh: the nearest one above it.
//! 2. [`parse`] reads it; what it does not know is an error with line and the nearest right name.
//! 3. [`Config::layer`] lays defaults and the rules that match a mesh upon each other.

mod parse;
mod search;
mod template;

use std::path::{Path, PathBuf};

use globset::GlobMatcher;

use crate::option_layer::OptionLayer;
use crate::outcome::Failure;

pub use search::Configs;
pub use template::TEMPLATE;

/// Name of the file.
pub const FILE_NAME: &str = "hullmap.toml";

/// A `hullmap.toml`, read.
#[derive(Debug)]
pub struct Config {
    /// The file, as it was named or found.
    pub path: PathBuf,
    /// What holds for every mesh.
    defaults: OptionLayer,
    /// In the file's order: later ones win.
    rules: Vec<Rule>,
}

/// Options for the meshes that match one of some globs.
#[derive(Debug)]
struct Rule {
    /// Line of the globs in the file.
    line: usize,
    files: Vec<Glob>,
    layer: OptionLayer,
}

/// A glob, and what it is compared with.
#[derive(Debug)]
struct Glob {
    /// As the file has it.
    text: String,
    matcher: GlobMatcher,
    /// A pattern without `/` is compared with the file's name alone, as in `.gitignore`.
    is_of_name: bool,
}

impl Config {
    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read, is no TOML, or says what is not known; with file and line.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| Failure::usage(format!("{}: cannot read: {error}; check the path", path.display())))?;
        parse::parse(path, &text)
    }

    /// What the file says of the mesh at `place`, relative to the file's folder; `None` for a mesh outside of it, to which
    /// only the rules without `/` can apply.
    pub fn layer(&self, place: Option<&Path>, name: &Path) -> OptionLayer {
        let rules = self.rules.iter().filter(|rule| rule.matches(place, name));
        rules.fold(self.defaults.clone(), |lower, rule| rule.layer.clone().over(&lower))
    }

    /// A parameter of the decomposition in a file that asks for none.
    fn idle_parameter(&self) -> Option<&'static str> {
        let layers = || std::iter::once(&self.defaults).chain(self.rules.iter().map(|rule| &rule.layer));
        let is_asked_for = layers().any(|layer| layer.decompose == Some(true));
        layers().find_map(OptionLayer::first_of_decomposition).filter(|_| !is_asked_for)
    }
}

impl Rule {
    /// Whether it is for the mesh at `place`, as in [`Config::layer`].
    fn matches(&self, place: Option<&Path>, name: &Path) -> bool {
        self.files.iter().any(|glob| match (glob.is_of_name, place) {
            (true, _) => glob.matcher.is_match(name),
            (false, Some(place)) => glob.matcher.is_match(place),
            (false, None) => false,
        })
    }
}

#[cfg(test)]
mod tests {
    use hullmap_bake::IndexKind;

    use super::*;
    use crate::options::{BuildOptions, Simplify};
    use hullmap_import::Split;

    const TEXT: &str = r#"
[defaults]
index = "compact"
split = "object"

[[rule]]
files = "props/**"
unit_scale = 0.01

[[rule]]
files = ["*_col.obj", "props/big/*.glb"]
split = "none"
max_vertices = 64

[[rule]]
files = "props/big/exact_col.obj"
max_vertices = "none"
index = "cubemap"
resolution = 8
"#;

    fn options(config: &Config, place: &str) -> BuildOptions {
        let place = Path::new(place);
        config.layer(Some(place), Path::new(place.file_name().unwrap())).options()
    }

    #[test]
    fn later_rules_win_over_earlier_ones_and_over_defaults() {
        let config = parse::parse(Path::new("hullmap.toml"), TEXT).unwrap();
        let plain = options(&config, "rock.obj");
        assert_eq!((plain.index, plain.import.split), (IndexKind::COMPACT, Split::Object));
        assert_eq!((plain.import.unit_scale, plain.simplify), (1.0, Simplify::None));
        assert_eq!(options(&config, "props/deep/er/x.obj").import.unit_scale, 0.01);
        assert_eq!(options(&config, "other/props/x.obj").import.unit_scale, 1.0, "globs start at the file's folder");
        let collider = options(&config, "a/b/x_col.obj");
        assert_eq!((collider.import.split, collider.simplify), (Split::None, Simplify::MaxVertices(64)));
        assert_eq!(options(&config, "a/b/X_COL.OBJ"), collider, "case does not count");
        assert_eq!(options(&config, "props/big/x.glb").simplify, Simplify::MaxVertices(64));
        assert_eq!(options(&config, "props/big/deep/x.glb").simplify, Simplify::None, "a star stays in its folder");
        let exact = options(&config, "props/big/exact_col.obj");
        assert_eq!((exact.simplify, exact.import.unit_scale), (Simplify::None, 0.01));
        assert_eq!((exact.index, exact.import.split), (IndexKind::CubeMap { resolution: 8 }, Split::None));
    }

    #[test]
    fn a_mesh_outside_the_folder_meets_rules_of_names_alone() {
        let config = parse::parse(Path::new("hullmap.toml"), TEXT).unwrap();
        let layer = |name: &str| config.layer(None, Path::new(name)).options();
        assert_eq!(layer("x_col.obj").simplify, Simplify::MaxVertices(64));
        assert_eq!(layer("exact_col.obj").simplify, Simplify::MaxVertices(64));
    }

    #[test]
    fn the_template_is_the_defaults_and_names_every_option() {
        let config = parse::parse(Path::new("hullmap.toml"), TEMPLATE).unwrap();
        assert_eq!(config.layer(Some(Path::new("x.obj")), Path::new("x.obj")), OptionLayer::default());
        // With the marks taken off the lines that are options, it still reads, and says what holds anyway.
        let is_option = |line: &&str| {
            let key = line.strip_prefix("# ").and_then(|rest| rest.split_once(" = ")).map_or("", |(key, _)| key);
            crate::option_layer::KEYS.iter().any(|(known, _)| *known == key)
        };
        let bare = |line: &str| line.strip_prefix("# ").unwrap_or(line).to_owned();
        let head = TEMPLATE.split("# [[rule]]").next().unwrap();
        let lines: Vec<String> =
            head.lines().map(|line| if is_option(&line) { bare(line) } else { line.to_owned() }).collect();
        for (key, _) in crate::option_layer::KEYS {
            assert!(lines.iter().any(|line| line.starts_with(&format!("{key} = "))), "{key}");
        }
        // Those that exclude each other are tried one by one.
        for line in lines.iter().filter(|line| line.contains(" = ") && !line.starts_with('#')) {
            let text = match line.split(' ').next() {
                Some("resolution") => format!("[defaults]\nindex = \"cubemap\"\n{line}"),
                _ => format!("[defaults]\n{line}"),
            };
            let config = parse::parse(Path::new("hullmap.toml"), &text).unwrap_or_else(|error| panic!("{error}"));
            let options = config.layer(None, Path::new("x.obj")).options();
            let is_example = ["index_budget", "resolution"].iter().any(|key| line.starts_with(key));
            assert!(is_example || options == BuildOptions::DEFAULT, "{line}");
        }
        let example = &TEMPLATE[TEMPLATE.find("# [[rule]]").unwrap()..];
        let example: String = example.lines().map(|line| format!("{}\n", line.trim_start_matches("# "))).collect();
        let config = parse::parse(Path::new("hullmap.toml"), &example).unwrap();
        assert_eq!(config.rules.len(), 2);
    }
}
