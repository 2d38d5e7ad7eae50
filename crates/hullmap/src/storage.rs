//! Where a pack's bytes live: a memory map, or a buffer of our own. One of the two modules of the crate with unsafe code; the
//! other is `simd/avx2.rs`.
//!
//! A storage is checked once, when it is made, and never changes after; [`Storage::archive`] then reads it in place.
#![allow(unsafe_code)]

use hullmap_format::{
    archive::ArchivedPack,
    check::{self, CheckError},
    header::HEADER_LEN,
};
use rkyv::util::AlignedVec;

/// Bytes of a whole file, header included, whose archive has passed [`check::access`].
#[derive(Debug)]
pub(crate) struct Storage {
    bytes: Bytes,
}

#[derive(Debug)]
pub(crate) enum Bytes {
    /// A read-only map: of a file, or of memory of our own.
    #[cfg(feature = "mmap")]
    Mapped(memmap2::Mmap),
    /// A copy, aligned as the archive needs it.
    Owned(AlignedVec<HEADER_LEN>),
}

impl Bytes {
    pub(crate) fn as_slice(&self) -> &[u8] {
        match self {
            #[cfg(feature = "mmap")]
            Self::Mapped(map) => map,
            Self::Owned(buffer) => buffer,
        }
    }

    /// What follows the header.
    pub(crate) fn payload(&self) -> &[u8] {
        self.as_slice().get(HEADER_LEN..).unwrap_or_default()
    }
}

/// Maps `file` read-only.
#[cfg(feature = "mmap")]
pub(crate) fn map(file: &std::fs::File) -> std::io::Result<Bytes> {
    // SAFETY: the map is only ever read, and as plain bytes until it has been checked. That no other process cuts or
    // rewrites the file while it is mapped is what `Pack::open` asks of its caller: packs are replaced by renaming, as
    // `bake` does, which leaves a mapped file as it was.
    unsafe { memmap2::Mmap::map(file) }.map(Bytes::Mapped)
}

/// Reads `len` bytes of `file` into pages of our own, and makes them read-only.
#[cfg(feature = "mmap")]
pub(crate) fn sealed(file: &mut std::fs::File, len: usize) -> std::io::Result<Bytes> {
    let mut pages = memmap2::MmapMut::map_anon(len)?;
    std::io::Read::read_exact(file, &mut pages)?;
    pages.make_read_only().map(Bytes::Mapped)
}

impl Storage {
    /// Takes bytes that hold a header and the archive behind it; checks the bounds of the archive's vectors.
    pub(crate) fn new(bytes: Bytes) -> Result<Self, CheckError> {
        check::access(bytes.payload())?;
        Ok(Self { bytes })
    }

    /// The whole file.
    pub(crate) fn file(&self) -> &[u8] {
        self.bytes.as_slice()
    }

    /// The archive, in place.
    pub(crate) fn archive(&self) -> &ArchivedPack {
        let payload = self.bytes.payload();
        // SAFETY: `new` ran rkyv's checked access, with the same type, over the same bytes; neither a map nor an owned
        // buffer moves its bytes when the `Storage` moves, and nothing here writes to them.
        unsafe { rkyv::access_unchecked::<ArchivedPack>(payload) }
    }
}
