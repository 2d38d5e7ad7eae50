use std::path::Path;

use hullmap::{HeightField, OpenError};
use hullmap_import::open_regular;

use crate::outcome::Failure;

pub fn open(path: &Path) -> Result<HeightField, Failure> {
    // `HeightField::open` would wait for a pipe.
    if path.exists()
        && !path.is_file()
        && let Err(error) = open_regular(path)
    {
        return Err(Failure::usage(format!("{}: cannot read: {error}; name a height field", path.display())));
    }
    HeightField::open(path).map_err(|error| match &error {
        OpenError::Io { .. } => Failure::usage(error.to_string()),
        OpenError::Invalid { .. } => Failure::rejected(error.to_string()),
    })
}
