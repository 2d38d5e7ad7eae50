//! The bytes of a height field and the sections in them.

use hullmap_format::{check::CheckError, height_field::sections::Sections};

use crate::file::Bytes;

self_cell::self_cell!(
    struct Cell {
        owner: Bytes,
        #[covariant]
        dependent: Sections,
    }
    impl {Debug}
);

/// The bytes of a file and the sections in them.
#[derive(Debug)]
pub(super) struct Storage(Cell);

impl Storage {
    /// Takes the bytes of a file, which no other process may change, and finds its sections.
    pub(super) fn new(bytes: Bytes) -> Result<Self, CheckError> {
        Cell::try_new(bytes, |bytes| Sections::read(bytes.payload())).map(Self)
    }

    /// The whole file.
    pub(super) fn bytes(&self) -> &Bytes {
        self.0.borrow_owner()
    }

    #[inline]
    pub(super) fn sections(&self) -> &Sections<'_> {
        self.0.borrow_dependent()
    }
}
