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

/// Methods of the content of a file, which is in `storage`, after its `header`.
macro_rules! impl_checked {
    ($file:ident) => {
        impl $file {
            /// Reads the file into memory of this process and checks all of it.
            ///
            /// # Errors
            /// [`OpenError`] names the file, what is wrong with it, and what to do.
            ///
            /// # Complexity
            /// One read and a few passes over the file.
            pub fn open(path: impl AsRef<std::path::Path>) -> Result<Self, OpenError> {
                checked::open(path.as_ref())
            }

            /// Copies the bytes of a whole file and checks all of them.
            ///
            /// # Errors
            /// The bytes are rejected; the error states the first fault.
            ///
            /// # Complexity
            /// One copy, and a few passes.
            pub fn from_bytes(bytes: &[u8]) -> Result<Self, InvalidPack> {
                checked::from_bytes(bytes)
            }

            /// Path of the source relative to the folder of the file, with `/` between folders;
            /// empty if it was not recorded.
            pub fn source_path(&self) -> &str {
                std::str::from_utf8(self.sections().source_path).unwrap_or_default()
            }

            /// The options that shaped the bake, in the form in which `bake` records them: one
            /// line.
            pub fn options(&self) -> &str {
                self.sections().options_text().split('\n').next().unwrap_or_default()
            }

            /// Warnings of the bake, each with its remedy.
            pub fn warnings(&self) -> impl Iterator<Item = &str> {
                self.sections().options_text().split('\n').skip(1)
            }

            /// Header of the file.
            pub fn header(&self) -> &Header {
                &self.header
            }

            /// Bytes of the whole file.
            pub fn bytes(&self) -> &[u8] {
                self.storage.borrow_owner().as_slice()
            }

            #[inline]
            fn sections(&self) -> &Sections<'_> {
                self.storage.borrow_dependent()
            }
        }
    };
}
pub(crate) use impl_checked;

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
