//! Memory maps of pack files: constructors that are `unsafe`, because nothing stops another process
//! from writing to a mapped file.
//!
//! Rust lets the compiler assume that the bytes of a `&[u8]` do not change while it is borrowed. A
//! shared map of a file cannot guarantee that, so the caller has to promise it. `memmap2` and `fst`
//! draw the same line.
#![allow(unsafe_code)]

use std::path::Path;

use hullmap_format::header::FileKind;

use super::{Checks, OpenError, Pack};
use crate::file::map::map;

impl Pack {
    /// Maps the file and checks all of it.
    ///
    /// Processes that map the same file share its pages, and pages that no query reads can leave
    /// memory. Opening takes as long as [`Pack::open`], except for the copy: the checksum reads
    /// every byte in both cases.
    ///
    /// # Safety
    /// While the pack exists, no process may write to the file or truncate it. Replacing the file
    /// by renaming another one over it is allowed: the map keeps the old file. `bake` replaces
    /// packs in this way.
    ///
    /// If a process writes to the file in spite of this, the behaviour is undefined by the rules of
    /// Rust. In practice, queries return wrong answers, possibly NaN, or panic. If the file is
    /// truncated, reading past its new end raises SIGBUS on Unix. No query reads outside of the
    /// map: the positions of all sections were copied from the file and checked when it was opened.
    ///
    /// # Errors
    /// As [`Pack::open`].
    ///
    /// # Complexity
    /// One pass over the file. Memory as for [`Pack::open`], without the copy; the pack's texts
    /// (names, options, source path) are copied.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("rock.hullmap");
    /// # std::fs::write(&path, rock_and_cube())?;
    /// use hullmap::Pack;
    ///
    /// // SAFETY: only `bake` writes to this folder, and it replaces packs by renaming.
    /// let pack = unsafe { Pack::map(&path)? };
    /// assert_eq!(pack.hull(0)?.name(), "rock");
    /// # Ok(())
    /// # }
    /// ```
    pub unsafe fn map(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        // SAFETY: the caller upholds the contract of this function, which is the contract of
        // `map_file`.
        unsafe { map_file(path.as_ref(), Checks::All) }
    }

    /// Maps the file and checks its structure, as [`Pack::open_skipping_contents`] does with a
    /// copy.
    ///
    /// # Safety
    /// As [`Pack::map`].
    ///
    /// # Errors
    /// As [`Pack::open_skipping_contents`].
    ///
    /// # Complexity
    /// O(number of hulls). No allocation that grows with the file, except for the copies of the
    /// texts. The face tables of small hulls take at most 4 MiB and about 40 ms.
    pub unsafe fn map_skipping_contents(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        // SAFETY: the caller upholds the contract of this function, which is the contract of
        // `map_file`.
        unsafe { map_file(path.as_ref(), Checks::Structure) }
    }

    /// Maps the file and checks its header, its length, and the positions of its sections only, as
    /// [`Pack::open_skipping_checks`] does with a copy.
    ///
    /// # Safety
    /// As [`Pack::map`].
    ///
    /// # Errors
    /// As [`Pack::open_skipping_checks`].
    ///
    /// # Complexity
    /// O(length of the texts), which are copied, and the face tables, as in
    /// [`Pack::map_skipping_contents`].
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("rock.hullmap");
    /// # std::fs::write(&path, rock_and_cube())?;
    /// use hullmap::Pack;
    ///
    /// // SAFETY: the file was installed with the program and is never written to again.
    /// let pack = unsafe { Pack::map_skipping_checks(&path)? };
    /// assert_eq!(pack.hull_count(), 2);
    /// # Ok(())
    /// # }
    /// ```
    pub unsafe fn map_skipping_checks(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        // SAFETY: the caller upholds the contract of this function, which is the contract of
        // `map_file`.
        unsafe { map_file(path.as_ref(), Checks::Sections) }
    }
}

/// Maps a file and checks it.
///
/// # Safety
/// As [`Pack::map`].
unsafe fn map_file(path: &Path, checks: Checks) -> Result<Pack, OpenError> {
    // SAFETY: the caller upholds the contract of this function, which is the contract of `map`.
    let (header, bytes) = unsafe { map(path, FileKind::Pack)? };
    Pack::from_storage_bytes(header, bytes, checks).map_err(|cause| OpenError::Invalid { path: path.to_owned(), cause })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The system's message for a folder was "no such device".
    #[test]
    #[cfg(unix)]
    fn a_folder_is_named_as_such() {
        // SAFETY: a folder cannot be mapped.
        let error = unsafe { Pack::map("/") }.unwrap_err();
        assert!(error.to_string().ends_with("is a directory; name a pack in this folder"), "{error}");
    }
}
