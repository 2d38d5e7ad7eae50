//! Globs that select meshes, in `hullmap.toml` and for `--exclude`.

use std::path::Path;

use globset::{GlobBuilder, GlobMatcher};

/// A glob. `*` stays within one folder, `**` does not; case is ignored.
#[derive(Clone, Debug)]
pub struct Glob {
    pub text: String,
    matcher: GlobMatcher,
    /// A glob without `/` is matched against the file name alone, as in `.gitignore`.
    matches_name: bool,
}

impl Glob {
    pub fn new(text: &str) -> Result<Self, String> {
        let matches_name = !text.trim_end_matches('/').contains('/');
        // A glob with `/` is relative to a folder anyway, so a leading `/` or `./` adds nothing.
        let below = text.strip_prefix("./").or_else(|| text.strip_prefix('/')).unwrap_or(text).trim_end_matches('/');
        let built = GlobBuilder::new(below).literal_separator(true).case_insensitive(true).build();
        let matcher = built.map_err(|error| format!("invalid glob `{text}`: {}", error.kind()))?.compile_matcher();
        Ok(Self { text: text.to_owned(), matcher, matches_name })
    }

    /// `below` is the mesh's path relative to the glob's folder; `None` for a mesh outside, to
    /// which only globs without `/` can apply. `name` is its file name.
    pub fn matches(&self, below: Option<&Path>, name: &Path) -> bool {
        match (self.matches_name, below) {
            (true, _) => self.matcher.is_match(name),
            (false, Some(below)) => self.matcher.is_match(below),
            (false, None) => false,
        }
    }

    /// Whether it matches a relative path, or a folder above it.
    pub fn matches_within(&self, path: &Path) -> bool {
        let mut places = path.ancestors().filter(|place| *place != Path::new(""));
        places.any(|place| self.matches(Some(place), Path::new(place.file_name().unwrap_or_default())))
    }

    /// Whether it is matched against names alone.
    pub fn is_of_names(&self) -> bool {
        self.matches_name
    }
}
