//! `hullmap.toml`: build options for the meshes of a project, kept beside them.
//!
//! 1. `search` finds the file for a mesh: the nearest one above it.
//! 2. `parse` reads it. Anything unknown is an error with line number and suggestion.
//! 3. [`Config::layer`] lays the rules that match a mesh over the defaults.

mod parse;
mod rules;
mod search;

use std::io::{self, Read as _};
use std::path::Path;

use hullmap_import::open_regular;

use crate::outcome::Failure;

pub(crate) use parse::most_similar;
pub use rules::Config;
pub use search::{Chosen, Configs};

/// Name of the file.
pub const FILE_NAME: &str = "hullmap.toml";

/// Maximum size of the file in bytes: some ten thousand rules.
const MAX_BYTES: u64 = 1 << 20;

impl Config {
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let text = read_bounded(path)
            .map_err(|error| Failure::usage(format!("{}: cannot read: {error}; check the path", path.display())))?;
        parse::parse(path, &text)
    }
}

fn read_bounded(path: &Path) -> io::Result<String> {
    let mut bytes = Vec::new();
    open_regular(path)?.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(io::Error::other(format!("it has more than {MAX_BYTES} bytes")));
    }
    String::from_utf8(bytes).map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is not UTF-8 text"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::table::{OPTIONS, Scope};
    use crate::options::{BuildOptions, OptionLayer, name, template};

    #[test]
    fn the_template_lists_every_option_at_its_default() {
        let template = template();
        let config = parse::parse(Path::new("hullmap.toml"), &template).unwrap();
        assert_eq!(config.layer(Some(Path::new("x.obj")), Path::new("x.obj")), OptionLayer::default());
        let is_option = |line: &&str| {
            let key = line.strip_prefix("# ").and_then(|rest| rest.split_once(" = ")).map_or("", |(key, _)| key);
            OPTIONS.iter().any(|option| name(option.key) == key)
        };
        let bare = |line: &str| line.strip_prefix("# ").unwrap_or(line).to_owned();
        let head = template.split("# [[rule]]").next().unwrap();
        let lines: Vec<String> =
            head.lines().map(|line| if is_option(&line) { bare(line) } else { line.to_owned() }).collect();
        // Rules choose the terrains.
        for option in OPTIONS.iter().filter(|option| option.key != "terrain") {
            let key = name(option.key);
            assert!(lines.iter().any(|line| line.starts_with(&format!("{key} = "))), "{key}");
        }
        // One by one, because some exclude each other.
        for line in lines.iter().filter(|line| line.contains(" = ") && !line.starts_with('#')) {
            let of_terrains = OPTIONS.iter().any(|own| own.scope == Scope::Terrains && line.starts_with(own.key));
            let text = format!("[{}]\n{line}", if of_terrains { "terrain" } else { "defaults" });
            let config = parse::parse(Path::new("hullmap.toml"), &text).unwrap_or_else(|error| panic!("{error}"));
            let options = config.layer(None, Path::new("x.obj")).resolve();
            assert_eq!(options, BuildOptions::default(), "{line}");
        }
        let example = &template[template.find("# [[rule]]").unwrap()..];
        let example: String = example.lines().map(|line| format!("{}\n", line.trim_start_matches("# "))).collect();
        let config = parse::parse(Path::new("hullmap.toml"), &example).unwrap();
        assert_eq!(config.rules.len(), 5);
    }
}
