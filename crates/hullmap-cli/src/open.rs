//! Opening packs, with the exit code for each error, and the remarks in them.

use std::path::Path;

use hullmap::{OpenError, Pack};
use hullmap_import::open_regular;

use crate::outcome::Failure;

/// Maximum number of remarks from elsewhere about one mesh.
const MAX_REMARKS: usize = 100;

/// Maximum number of characters of such a remark.
const MAX_REMARK: usize = 10_000;

/// Reads a pack into memory and checks it. The error is [`Failure::usage`] if the file cannot be
/// read, and [`Failure::rejected`] if it is not a valid pack. Both name the file.
pub fn open_pack(path: &Path) -> Result<Pack, Failure> {
    // `Pack::open` would wait for a pipe.
    if path.exists()
        && !path.is_file()
        && let Err(error) = open_regular(path)
    {
        return Err(Failure::usage(format!("{}: cannot read: {error}; name the file of a pack", path.display())));
    }
    Pack::open(path).map_err(|error| match &error {
        OpenError::Io { .. } => Failure::usage(error.to_string()),
        OpenError::Invalid { .. } => Failure::rejected(error.to_string()),
    })
}

/// The warnings that a pack keeps, within limits: anybody may have written it.
pub fn kept_warnings(pack: &Pack) -> Vec<String> {
    bounded_remarks(pack.warnings(), str::to_owned)
}

/// Remarks from elsewhere within limits, each as `here` shows it.
pub fn bounded_remarks<'a>(remarks: impl Iterator<Item = &'a str>, here: impl Fn(&str) -> String) -> Vec<String> {
    let bounded = |text: &str| text.chars().take(MAX_REMARK).collect::<String>();
    // `here` may lengthen a remark.
    remarks.take(MAX_REMARKS).map(|text| bounded(&here(&bounded(text)))).collect()
}
