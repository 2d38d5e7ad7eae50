//! Hulls by name on the command line: `FILE`, `FILE#name` or `FILE#number`.

use std::path::{Path, PathBuf};

use crate::outcome::Failure;
use crate::packs::is_pack;

/// Most hull names that a message lists.
const NAMES_IN_MESSAGE: usize = 8;

/// A pack, and which hull of it is meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selection {
    /// The pack.
    pub file: PathBuf,
    /// Name or number of the hull; `None` where the pack's only hull is meant.
    pub hull: Option<String>,
}

impl Selection {
    /// Takes `text` apart at a `#`: after the longest part that names a file; where none does, after the first one that is
    /// called like a pack, else at the last `#`. So both files and hulls may have a `#` in their names.
    pub fn parse(text: &str) -> Self {
        let whole = || Self { file: PathBuf::from(text), hull: None };
        if Path::new(text).is_file() {
            return whole();
        }
        let cuts: Vec<(&str, &str)> = text.match_indices('#').map(|(at, _)| (&text[..at], &text[at + 1..])).collect();
        let existing = cuts.iter().rfind(|(file, _)| Path::new(file).is_file());
        let named = || cuts.iter().find(|(file, _)| is_pack(Path::new(file)));
        match existing.or_else(named).or(cuts.last()) {
            Some((file, hull)) => Self { file: PathBuf::from(file), hull: Some((*hull).to_owned()) },
            None => whole(),
        }
    }

    /// The number of the hull that is meant among those with `names`. A name goes before a number.
    ///
    /// # Errors
    /// No such hull, or none chosen of several.
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
                "{file}: holds {count} hulls; choose one as {file}#name or {file}#number: {listed}{more}"
            )));
        };
        let by_name = names.iter().position(|name| name == wanted);
        let by_number = || wanted.parse().ok().filter(|&number: &usize| number < names.len());
        by_name.or_else(by_number).ok_or_else(|| {
            Failure::usage(format!("{file}: no hull `{wanted}`; it holds {listed}{more}, numbered from 0"))
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
            ("x.hullmap#left#2", "x.hullmap", "left#2"),
            ("x.hullmap##", "x.hullmap", "#"),
            ("x.hullmap#a.hullmap#b", "x.hullmap", "a.hullmap#b"),
            ("a#b.hullmap#c#d", "a#b.hullmap", "c#d"),
            ("gone.hullmap#left#2", "gone.hullmap", "left#2"),
        ] {
            let selection = Selection::parse(folder.path().join(text).to_str().unwrap());
            assert_eq!(selection, Selection { file: folder.path().join(file), hull: Some(hull.to_owned()) }, "{text}");
        }
    }

    #[test]
    fn a_hash_behind_a_pack_divides() {
        let selection = Selection::parse("a#b/x.hullmap#left");
        assert_eq!(selection.file, Path::new("a#b/x.hullmap"));
        assert_eq!(selection.hull.as_deref(), Some("left"));
        assert_eq!(Selection::parse("x.hullmap").hull, None);
    }

    #[test]
    fn a_file_with_a_hash_in_its_name_is_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a#b.hullmap");
        std::fs::write(&path, "").unwrap();
        let text = path.to_str().unwrap();
        assert_eq!(Selection::parse(text), Selection { file: path.clone(), hull: None });
        assert_eq!(Selection::parse(&format!("{text}#2")), Selection { file: path, hull: Some("2".to_owned()) });
    }

    #[test]
    fn names_go_before_numbers() {
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
