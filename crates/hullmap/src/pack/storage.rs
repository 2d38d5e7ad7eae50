//! Storage of a pack's bytes, in a memory map of the file or in memory of this process, and the
//! sections in them.
//!
//! A [`Storage`] finds the sections of its bytes once, when it is made, and keeps them as slices
//! ([`Sections`]). No later access reads an offset from the file.
//!
//! The texts of a mapped file (source path, options, names) are copied: a `str` must remain valid
//! UTF-8 for as long as it is borrowed, and code that reads it relies on this. The numbers stay in
//! the map, since all of their bit patterns are valid.

use std::{
    fs::File,
    io::{self, Read},
    sync::OnceLock,
};

use hullmap_format::{check::CheckError, header::HEADER_LEN, sections::Sections};
use rkyv::util::AlignedVec;

/// Bytes of a whole file, header included.
#[derive(Debug)]
pub(super) enum Bytes {
    /// The file itself, mapped read-only. Other processes may write to it.
    #[cfg(feature = "mmap")]
    File(memmap2::Mmap),
    /// A copy on pages of this process, which are read-only.
    #[cfg(feature = "mmap")]
    Sealed(memmap2::Mmap),
    /// A copy, aligned as the archive requires.
    Owned(AlignedVec<HEADER_LEN>),
    /// Memory of the caller that never changes, such as a static of the program.
    Static(&'static [u8]),
}

impl Bytes {
    pub(super) fn as_slice(&self) -> &[u8] {
        match self {
            #[cfg(feature = "mmap")]
            Self::File(map) | Self::Sealed(map) => map,
            Self::Owned(buffer) => buffer,
            Self::Static(bytes) => bytes,
        }
    }

    /// All bytes after the header.
    pub(super) fn payload(&self) -> &[u8] {
        self.as_slice().get(HEADER_LEN..).unwrap_or_default()
    }

    /// Whether another process may change the bytes.
    fn is_shared(&self) -> bool {
        match self {
            #[cfg(feature = "mmap")]
            Self::File(_) => true,
            #[cfg(feature = "mmap")]
            Self::Sealed(_) => false,
            Self::Owned(_) | Self::Static(_) => false,
        }
    }
}

/// A file of `len` bytes, of which `head` has been read and the rest is read from `file`.
#[cfg(feature = "mmap")]
pub(super) fn copy(file: &mut File, head: &[u8], len: u64) -> io::Result<Bytes> {
    let len = usize::try_from(len).map_err(io::Error::other)?;
    let mut pages = memmap2::MmapMut::map_anon(len)?;
    let (start, rest) = pages.split_at_mut_checked(head.len()).ok_or(io::ErrorKind::UnexpectedEof)?;
    start.copy_from_slice(head);
    file.read_exact(rest)?;
    pages.make_read_only().map(Bytes::Sealed)
}

/// A file of `len` bytes, of which `head` has been read and the rest is read from `file`.
#[cfg(not(feature = "mmap"))]
pub(super) fn copy(file: &mut File, head: &[u8], len: u64) -> io::Result<Bytes> {
    let mut buffer = AlignedVec::with_capacity(usize::try_from(len).map_err(io::Error::other)?);
    buffer.extend_from_slice(head);
    let rest = len.saturating_sub(head.len() as u64);
    buffer.extend_from_reader(&mut file.take(rest))?;
    Ok(Bytes::Owned(buffer))
}

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
    /// Takes the bytes of a file and finds its sections.
    pub(super) fn new(bytes: Bytes) -> Result<Self, CheckError> {
        Cell::try_new(Owner { bytes, texts: OnceLock::new() }, Owner::sections).map(Self)
    }

    /// The whole file.
    pub(super) fn file(&self) -> &[u8] {
        self.0.borrow_owner().bytes.as_slice()
    }

    /// All bytes after the header.
    pub(super) fn payload(&self) -> &[u8] {
        self.0.borrow_owner().bytes.payload()
    }

    #[inline]
    pub(super) fn sections(&self) -> &Sections<'_> {
        self.0.borrow_dependent()
    }
}
