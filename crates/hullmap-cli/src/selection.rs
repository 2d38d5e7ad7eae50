//! Hulls named on the command line: `FILE`, `FILE#name` or `FILE#index`.

use std::path::{Path, PathBuf};

use hullmap_pipeline::outcome::Failure;
use hullmap_pipeline::packs::is_baked;

const NAMES_IN_MESSAGE: usize = 8;

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
}

/// Index of the hull `wanted` among the `names` of a pack. A name takes precedence over an index.
pub fn hull_index(file: &Path, wanted: &str, names: &[&str]) -> Result<usize, Failure> {
    let by_name = names.iter().position(|name| *name == wanted);
    let by_index = || wanted.parse().ok().filter(|&index: &usize| index < names.len());
    by_name.or_else(by_index).ok_or_else(|| {
        let listed = names[..names.len().min(NAMES_IN_MESSAGE)].join(", ");
        let more = if names.len() > NAMES_IN_MESSAGE { ", …" } else { "" };
        let file = file.display();
        Failure::usage(format!("{file}: no hull `{wanted}`; the pack holds {listed}{more} (indices from 0)"))
    })
}
