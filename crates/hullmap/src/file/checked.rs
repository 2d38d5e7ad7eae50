//! Files that are opened with all checks.

use std::path::Path;

use hullmap_format::header::{FileKind, Header};

use super::{Bytes, check_checksum, copy_of, read};
use crate::pack::error::{InvalidPack, OpenError};

/// Content of a file of one kind that has passed all checks.
pub(crate) trait Checked: Sized {
    /// The kind.
    const KIND: FileKind;

    /// Checks the payload, and the record of the options. The length and the checksum are those
    /// that the header states.
    fn new(header: Header, bytes: Bytes) -> Result<Self, InvalidPack>;

    /// Checks all bytes of a file.
    fn check(header: Header, bytes: Bytes) -> Result<Self, InvalidPack> {
        header.check_length(bytes.as_slice().len() as u64)?;
        // A damaged file is reported as damaged even if the damage is in the root.
        check_checksum(&header, bytes.payload())?;
        Self::new(header, bytes)
    }
}

/// Reads a file into memory of this process and checks all of it.
pub(crate) fn open<F: Checked>(path: &Path) -> Result<F, OpenError> {
    let (header, bytes) = read(path, Some(F::KIND))?;
    F::check(header, bytes).map_err(|cause| OpenError::Invalid { path: path.to_owned(), cause })
}

/// Copies the bytes of a whole file and checks all of them.
pub(crate) fn from_bytes<F: Checked>(bytes: &[u8]) -> Result<F, InvalidPack> {
    let header = Header::read_kind(bytes, F::KIND)?;
    F::check(header, copy_of(bytes))
}
