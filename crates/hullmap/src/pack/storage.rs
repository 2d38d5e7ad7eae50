//! The bytes of a pack and the sections in them.
//!
//! A [`Storage`] finds the sections of its bytes once, when it is made, and keeps them as slices
//! ([`Sections`]). No later access reads an offset from the file.
//!
//! The texts of a mapped file (source path, options, names) are copied: a `str` must remain valid
//! UTF-8 for as long as it is borrowed, and code that reads it relies on this. The numbers stay in
//! the map, since all of their bit patterns are valid.

use std::sync::OnceLock;

use hullmap_format::{check::CheckError, sections::Sections};

use crate::file::Bytes;

/// The owner from which the sections borrow.
#[derive(Debug)]
struct Owner {
    bytes: Bytes,
    /// Copies of source path, options and names, if the bytes are shared.
    texts: OnceLock<[Box<[u8]>; 3]>,
}

impl Owner {
    fn sections(&self) -> Result<Sections<'_>, CheckError> {
        let mut sections = Sections::read(self.bytes.payload())?;
        if self.bytes.is_shared() {
            let copies = || [sections.source_path, sections.options, sections.names].map(Box::from);
            let [source_path, options, names] = self.texts.get_or_init(copies);
            (sections.source_path, sections.options, sections.names) = (source_path, options, names);
        }
        Ok(sections)
    }
}

self_cell::self_cell!(
    struct Cell {
        owner: Owner,
        #[covariant]
        dependent: Sections,
    }
    impl {Debug}
);

/// The bytes of a file and the sections in them.
///
/// Neither a map nor a buffer moves its bytes when the `Storage` moves.
#[derive(Debug)]
pub(super) struct Storage(Cell);

impl Storage {
    pub(super) fn new(bytes: Bytes) -> Result<Self, CheckError> {
        Cell::try_new(Owner { bytes, texts: OnceLock::new() }, Owner::sections).map(Self)
    }

    pub(super) fn file(&self) -> &[u8] {
        self.0.borrow_owner().bytes.as_slice()
    }

    pub(super) fn payload(&self) -> &[u8] {
        self.0.borrow_owner().bytes.payload()
    }

    #[inline]
    pub(super) fn sections(&self) -> &Sections<'_> {
        self.0.borrow_dependent()
    }
}
