//! Opening packs, with the exit code for each error.

use std::path::Path;

use hullmap::{OpenError, Pack};

use crate::outcome::Failure;

/// Reads a pack into memory and checks it.
///
/// # Errors
/// [`Failure::usage`] if the file cannot be read, [`Failure::rejected`] if it is not a valid pack.
/// Both name the file.
pub fn open_pack(path: &Path) -> Result<Pack, Failure> {
    if path.is_dir() {
        return Err(Failure::usage(format!(
            "{}: is a folder, but one pack is expected; name a file in it",
            path.display()
        )));
    }
    Pack::open(path).map_err(|error| match &error {
        OpenError::Io { .. } => Failure::usage(error.to_string()),
        OpenError::Invalid { .. } => Failure::rejected(error.to_string()),
    })
}
