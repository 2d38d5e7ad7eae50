//! Opening packs, with errors that know the exit code.

use std::path::Path;

use hullmap::{OpenError, Pack};

use crate::outcome::Failure;

/// Maps and checks a pack.
///
/// # Errors
/// Usage for a file that cannot be read, wanting for one that is no valid pack. Both name it.
pub fn open_pack(path: &Path) -> Result<Pack, Failure> {
    if path.is_dir() {
        return Err(Failure::usage(format!(
            "{}: a folder, where one pack is expected; name a file in it",
            path.display()
        )));
    }
    Pack::open(path).map_err(|error| match &error {
        OpenError::Io { .. } => Failure::usage(format!("{error}; check the path")),
        OpenError::Invalid { .. } => Failure::wanting(error.to_string()),
    })
}
