//! A file mapped read-only.
//!
//! Unsafe code of the crate is here, in the two constructors that call this (`pack/map.rs`,
//! `triangle_mesh/map.rs`), and in `support/simd/avx2.rs`.
#![allow(unsafe_code)]

use std::{fs::File, path::Path};

use hullmap_format::header::{FileKind, Header, HeaderError};

use super::{Bytes, checked::Checked};
use crate::pack::OpenError;

/// Maps a file of this kind, and reads the header at its start. Nothing else is checked.
///
/// # Safety
/// While the bytes exist, no process may write to the file or truncate it.
pub(crate) unsafe fn map(path: &Path, kind: FileKind) -> Result<(Header, Bytes), OpenError> {
    let io_error = |cause| OpenError::Io { path: path.to_owned(), cause };
    let invalid = |error: HeaderError| OpenError::Invalid { path: path.to_owned(), cause: error.into() };
    let file = File::open(path).map_err(io_error)?;
    let metadata = file.metadata().map_err(io_error)?;
    if metadata.is_dir() {
        // The system's own message is "no such device".
        return Err(io_error(std::io::ErrorKind::IsADirectory.into()));
    }
    if metadata.len() == 0 {
        // An empty file cannot be mapped.
        return Err(invalid(HeaderError::TooShort { found: 0 }));
    }
    // SAFETY: the caller promises that no process writes to the file or truncates it while the
    // bytes exist. They own the map.
    let map = unsafe { memmap2::Mmap::map(&file) }.map_err(io_error)?;
    let header = Header::read_kind(&map, kind).map_err(invalid)?;
    Ok((header, Bytes::File(map)))
}

/// Maps a file and checks all of it.
///
/// # Safety
/// As for [`map`].
pub(crate) unsafe fn open<F: Checked>(path: &Path) -> Result<F, OpenError> {
    // SAFETY: the caller upholds the contract of this function, which is the contract of `map`.
    let (header, bytes) = unsafe { map(path, F::KIND)? };
    F::check(header, bytes).map_err(|cause| OpenError::Invalid { path: path.to_owned(), cause })
}
