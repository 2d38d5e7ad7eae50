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

/// Minimum length of a copy for which huge pages are requested, in bytes: four huge pages of
/// x86-64. A huge page is one entry of the processor's address cache (TLB), as is a page of 4 KiB.
#[cfg(feature = "mmap")]
const HUGE_PAGES_FROM: usize = 8 << 20;

/// Zeroed pages of this process.
#[cfg(feature = "mmap")]
fn pages(len: usize) -> io::Result<memmap2::MmapMut> {
    let pages = memmap2::MmapMut::map_anon(len)?;
    // An error means that the system has no huge pages. Ordinary pages will do.
    #[cfg(target_os = "linux")]
    if len >= HUGE_PAGES_FROM {
        let _ = pages.advise(memmap2::Advice::HugePage);
    }
    Ok(pages)
}

/// A copy of `file`.
pub(super) fn copy_of(file: &[u8]) -> Bytes {
    #[cfg(feature = "mmap")]
    if file.len() >= HUGE_PAGES_FROM
        && let Ok(sealed) = sealed_copy_of(file)
    {
        return sealed;
    }
    let mut buffer = AlignedVec::with_capacity(file.len());
    buffer.extend_from_slice(file);
    Bytes::Owned(buffer)
}

#[cfg(feature = "mmap")]
fn sealed_copy_of(file: &[u8]) -> io::Result<Bytes> {
    let mut pages = pages(file.len())?;
    pages.copy_from_slice(file);
    pages.make_read_only().map(Bytes::Sealed)
}

/// A file of `len` bytes, of which `head` has been read and the rest is read from `file`.
#[cfg(feature = "mmap")]
pub(super) fn copy(file: &mut File, head: &[u8], len: u64) -> io::Result<Bytes> {
    let len = usize::try_from(len).map_err(io::Error::other)?;
    let mut pages = pages(len)?;
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

#[cfg(all(test, feature = "mmap"))]
mod tests {
    use super::*;

    #[test]
    fn large_copies_are_sealed_pages() {
        for (len, is_sealed) in [(0, false), (100, false), (HUGE_PAGES_FROM - 1, false), (HUGE_PAGES_FROM + 1, true)] {
            let file: Vec<u8> = (0..len).map(|i| (i % 251) as u8).collect();
            let copy = copy_of(&file);
            assert!(copy.as_slice() == file, "{len} bytes");
            assert_eq!(matches!(copy, Bytes::Sealed(_)), is_sealed, "{len} bytes");
        }
    }

    /// The kernel lists the flags of each map; `hg` is the request for huge pages.
    #[test]
    #[cfg(target_os = "linux")]
    fn large_copies_request_huge_pages() {
        if !std::path::Path::new("/sys/kernel/mm/transparent_hugepage").exists() {
            println!("skipped: this kernel has no transparent huge pages");
            return;
        }
        let flags_of = |len: usize| {
            let pages = pages(len).unwrap();
            let address = pages.as_ptr().addr();
            let maps = std::fs::read_to_string("/proc/self/smaps").unwrap();
            let mut is_here = false;
            let flags = maps.lines().find_map(|line| {
                if let Some((range, _)) = line.split_once(' ')
                    && let Some((low, high)) = range.split_once('-')
                    && let (Ok(low), Ok(high)) = (usize::from_str_radix(low, 16), usize::from_str_radix(high, 16))
                {
                    is_here = (low..high).contains(&address);
                }
                line.strip_prefix("VmFlags:").filter(|_| is_here)
            });
            flags.unwrap().to_owned()
        };
        assert!(flags_of(HUGE_PAGES_FROM).contains(" hg"));
    }
}
