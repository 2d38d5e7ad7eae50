//! Opening packs, with the exit code for each error.

use std::path::Path;

use hullmap::{OpenError, Pack};
use hullmap_import::open_regular;

use crate::outcome::Failure;

/// Reads a pack into memory and checks it.
///
/// # Errors
/// [`Failure::usage`] if the file cannot be read, [`Failure::rejected`] if it is not a valid pack.
/// Both name the file.
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
