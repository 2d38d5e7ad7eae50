//! The bytes of a file, in a memory map or in memory of this process, and its checksum.

pub(crate) mod checked;
#[cfg(feature = "mmap")]
pub(crate) mod map;

use std::{
    fs::File,
    io::{self, Read},
    path::Path,
};

use hullmap_format::{
    check::MAX_PACK_LEN,
    header::{FileKind, HEADER_LEN, Header, options_hash},
};
use rkyv::util::AlignedVec;

use crate::pack::error::{InvalidPack, OpenError};

/// Bytes of a whole file, header included.
#[derive(Debug)]
pub(crate) enum Bytes {
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
    pub(crate) fn as_slice(&self) -> &[u8] {
        match self {
            #[cfg(feature = "mmap")]
            Self::File(map) | Self::Sealed(map) => map,
            Self::Owned(buffer) => buffer,
            Self::Static(bytes) => bytes,
        }
    }

    /// All bytes after the header.
    pub(crate) fn payload(&self) -> &[u8] {
        self.as_slice().get(HEADER_LEN..).unwrap_or_default()
    }

    /// Whether another process may change the bytes.
    pub(crate) fn is_shared(&self) -> bool {
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

pub(crate) fn copy_of(file: &[u8]) -> Bytes {
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
pub(crate) fn copy(file: &mut File, head: &[u8], len: u64) -> io::Result<Bytes> {
    let len = usize::try_from(len).map_err(io::Error::other)?;
    let mut pages = pages(len)?;
    let (start, rest) = pages.split_at_mut_checked(head.len()).ok_or(io::ErrorKind::UnexpectedEof)?;
    start.copy_from_slice(head);
    file.read_exact(rest)?;
    pages.make_read_only().map(Bytes::Sealed)
}

/// A file of `len` bytes, of which `head` has been read and the rest is read from `file`.
#[cfg(not(feature = "mmap"))]
pub(crate) fn copy(file: &mut File, head: &[u8], len: u64) -> io::Result<Bytes> {
    let mut buffer = AlignedVec::with_capacity(usize::try_from(len).map_err(io::Error::other)?);
    buffer.extend_from_slice(head);
    let rest = len.saturating_sub(head.len() as u64);
    buffer.extend_from_reader(&mut file.take(rest))?;
    Ok(Bytes::Owned(buffer))
}

/// Reads a file of this kind, or of any, into memory of this process, and the header at its start.
/// Nothing else is checked, except that the length of the file is the stated one.
pub(crate) fn read(path: &Path, kind: Option<FileKind>) -> Result<(Header, Bytes), OpenError> {
    let io_error = |cause| OpenError::Io { path: path.to_owned(), cause };
    let invalid = |cause: InvalidPack| OpenError::Invalid { path: path.to_owned(), cause };
    let mut file = File::open(path).map_err(io_error)?;
    let mut head = Vec::with_capacity(HEADER_LEN);
    (&mut file).take(HEADER_LEN as u64).read_to_end(&mut head).map_err(io_error)?;
    let kind = kind.or_else(|| FileKind::from_start(&head)).unwrap_or(FileKind::Pack);
    let header = Header::read_kind(&head, kind).map_err(|error| invalid(error.into()))?;
    let metadata = file.metadata().map_err(io_error)?;
    let bytes = if metadata.is_file() {
        // Checked before memory is allocated, in case the length is wrong.
        header.check_length(metadata.len()).map_err(|error| invalid(error.into()))?;
        copy(&mut file, &head, metadata.len()).map_err(io_error)?
    } else {
        // A pipe has no length. The length of the longest file is read in addition to the header,
        // so an excess is detected.
        let mut buffer = AlignedVec::new();
        buffer.extend_from_slice(&head);
        buffer.extend_from_reader(&mut file.take(MAX_PACK_LEN as u64)).map_err(io_error)?;
        Bytes::Owned(buffer)
    };
    Ok((header, bytes))
}

/// Compares the checksum in the header with the payload's.
pub(crate) fn check_checksum(header: &Header, payload: &[u8]) -> Result<(), InvalidPack> {
    let (expected, found) = (header.checksum, header.checksum_of(payload));
    if found == expected { Ok(()) } else { Err(InvalidPack::Checksum { expected, found }) }
}

/// Compares the hash of the options in the header with the hash of the recorded options.
pub(crate) fn check_options(header: &Header, text: &str) -> Result<(), InvalidPack> {
    let (expected, found) = (header.options_hash, options_hash(text));
    if found == expected { Ok(()) } else { Err(InvalidPack::Options { expected, found }) }
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
