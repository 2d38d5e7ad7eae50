//! Hulls named on the command line: `FILE`, `FILE#name` or `FILE#index`.

use std::path::{Path, PathBuf};

use hullmap_pipeline::outcome::Failure;
use hullmap_pipeline::packs::is_baked;

const NAMES_IN_MESSAGE: usize = 8;

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selection {
    pub file: PathBuf,
    /// Name or index of the hull; `None` for the whole pack.
    pub hull: Option<String>,
}

impl Selection {
    /// Splits `text` at a `#`: after the longest prefix that names an existing file; otherwise
    /// after the first prefix that ends in `.hullmap` or `.hullmesh`; otherwise at the last `#`. So
    /// both files and hulls may have a `#` in their names.
    pub fn parse(text: &str) -> Self {
        let whole = || Self { file: PathBuf::from(text), hull: None };
        if Path::new(text).is_file() {
            return whole();
        }
        let cuts: Vec<(&str, &str)> = text.match_indices('#').map(|(at, _)| (&text[..at], &text[at + 1..])).collect();
        let existing = cuts.iter().rfind(|(file, _)| Path::new(file).is_file());
        let named = || cuts.iter().find(|(file, _)| is_baked(Path::new(file)));
        match existing.or_else(named).or(cuts.last()) {
            Some((file, hull)) => Self { file: PathBuf::from(file), hull: Some((*hull).to_owned()) },
            None => whole(),
        }
    }

    /// Index of the selected hull among `names`. A name takes precedence over an index. Fails if
    /// there is no such hull, or no hull is selected and there are several.
    pub fn choose(&self, names: &[&str]) -> Result<usize, Failure> {
        let file = self.file.display();
        let listed = names[..names.len().min(NAMES_IN_MESSAGE)].join(", ");
        let more = if names.len() > NAMES_IN_MESSAGE { ", …" } else { "" };
        let Some(wanted) = &self.hull else {
            if names.len() == 1 {
                return Ok(0);
            }
            let count = names.len();
            return Err(Failure::usage(format!(
                "{file}: holds {count} hulls; select one as {file}#name or {file}#index: {listed}{more}"
            )));
        };
        let by_name = names.iter().position(|name| name == wanted);
        let by_index = || wanted.parse().ok().filter(|&index: &usize| index < names.len());
        by_name.or_else(by_index).ok_or_else(|| {
            Failure::usage(format!("{file}: no hull `{wanted}`; the pack holds {listed}{more} (indices from 0)"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hulls_and_files_may_have_a_hash_in_their_names() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["x.hullmap", "a#b.hullmap"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        for (text, file, hull) in [
            ("x.hullmap", "x.hullmap", None),
            ("a#b.hullmap", "a#b.hullmap", None),
            ("gone.hullmap", "gone.hullmap", None),
            ("x.hullmap#left#2", "x.hullmap", Some("left#2")),
            ("x.hullmap##", "x.hullmap", Some("#")),
            ("x.hullmap#a.hullmap#b", "x.hullmap", Some("a.hullmap#b")),
            ("a#b.hullmap#c#d", "a#b.hullmap", Some("c#d")),
            ("gone.hullmap#left#2", "gone.hullmap", Some("left#2")),
            ("a#b/x.hullmap#left", "a#b/x.hullmap", Some("left")),
        ] {
            let selection = Selection::parse(folder.path().join(text).to_str().unwrap());
            assert_eq!(
                selection,
                Selection { file: folder.path().join(file), hull: hull.map(str::to_owned) },
                "{text}"
            );
        }
    }

    #[test]
    fn names_take_precedence_over_indices() {
        let choose = |text: &str, names: &[&str]| Selection::parse(text).choose(names).map_err(|f| f.message);
        assert_eq!(choose("x", &["only"]), Ok(0));
        assert_eq!(choose("x#b", &["a", "b"]), Ok(1));
        assert_eq!(choose("x#0", &["a", "0"]), Ok(1));
        assert_eq!(choose("x#1", &["a", "b"]), Ok(1));
        assert!(choose("x#2", &["a", "b"]).unwrap_err().contains("no hull `2`"));
        assert!(choose("x#", &["a"]).is_err());
        assert!(choose("x", &["a", "b"]).unwrap_err().contains("holds 2 hulls"));
    }
}
