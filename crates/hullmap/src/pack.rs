//! A `.hullmap` file, opened.
//!
//! 1. Map or copy the bytes.
//! 2. Header: magic, version, length.
//! 3. Checksum.
//! 4. Structure, then every number that a query could follow ([`hullmap_format::check`]).
//!
//! After that, no query on the pack can panic, loop or read out of bounds. [`Pack::open_skipping_contents`] and
//! [`Pack::open_skipping_checks`] leave out steps, and are named for them.
//!
//! | way | memory | the file is cut or written to | the file is replaced by renaming |
//! |---|---|---|---|
//! | [`Pack::open`] | the file's own pages, shared by all processes | not allowed: SIGBUS, zeros or other answers | safe |
//! | [`Pack::read`] | a copy | safe | safe |
//! | [`Pack::read_sealed`] | a copy on read-only pages: a stray write of this process faults instead of changing an answer | safe | safe |
//! | [`Pack::from_bytes`] | a copy of memory | no file | no file |
//!
//! No signal handler is installed: whether a fault under a map ends the process is the program's to say.
//!
//! A sealed `memfd` in place of read-only pages would add that other processes can be handed the copy. Those that open the same file share its
//! pages already; and it would take a dependency, or foreign calls, that the runtime does without.

use std::{
    fs::File,
    io,
    path::{Path, PathBuf},
};

use hullmap_format::{
    archive::ArchivedBvhNode,
    check::{self, CheckError},
    header::{Header, HeaderError, options_hash},
    repeats,
};
use rkyv::util::AlignedVec;

use crate::{
    hull::Hull,
    storage::{Bytes, Storage},
};

/// An opened pack. Hulls borrow from it; share it between threads by reference or in an `Arc`.
///
/// # Examples
/// Reloading while other threads ask. A reader holds the lock for as long as it takes to count one up, and asks without it. The old
/// pack, and its map, goes with its last reader:
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("rock.hullmap");
/// # let write = |scale: f32| -> Result<(), Box<dyn std::error::Error>> {
/// #     let positions = shapes::families::rock(40, 1).into_iter().map(|p| p.map(|c| c * scale)).collect();
/// #     let points = hullmap_bake::PointSet { name: "rock".into(), positions, source_vertices: (0..40).collect(), ..Default::default() };
/// #     let baked = hullmap_bake::bake_hull(&points, hullmap_bake::IndexKind::TREE)?;
/// #     let fresh = path.with_extension("fresh");
/// #     std::fs::write(&fresh, hullmap_bake::write_pack(&[baked], &Default::default())?)?;
/// #     Ok(std::fs::rename(&fresh, &path)?)
/// # };
/// # write(1.0)?;
/// use std::sync::{Arc, RwLock};
/// use hullmap::{Pack, glam::Vec3};
///
/// let current = RwLock::new(Arc::new(Pack::open(&path)?));
/// let reader = || current.read().expect("no writer panics").clone();
///
/// let pack = reader();
/// let before = pack.hull(0)?.support(Vec3::X).point.x;
/// # write(2.0)?;
/// // `bake` has renamed a new file over the old one.
/// let fresh = Arc::new(Pack::open(&path)?);
/// *current.write().expect("no writer panics") = fresh;
/// // Who asks on goes on with the old one; who asks anew gets the new one.
/// assert_eq!(pack.hull(0)?.support(Vec3::X).point.x, before);
/// assert_eq!(reader().hull(0)?.support(Vec3::X).point.x, 2.0 * before);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Pack {
    storage: Storage,
    header: Header,
}

/// Why a pack could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The file could not be read.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The file is no pack that this version reads.
    #[error("{path}: {source}")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: InvalidPack,
    },
}

/// What is wrong with the bytes of a pack.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidPack {
    /// The first 64 bytes.
    #[error(transparent)]
    Header(#[from] HeaderError),
    /// A byte changed since the bake.
    #[error("damaged: its checksum does not match its bytes; bake the source again")]
    Checksum,
    /// The options recorded are not those whose hash the header holds.
    #[error("damaged: its options are not those that its header states; bake the source again")]
    Options,
    /// The archive behind the header.
    #[error(transparent)]
    Content(#[from] CheckError),
}

/// Files from this length on are worth a second thread, where the caller has some: smaller ones take less than a millisecond or two.
#[cfg(feature = "parallel")]
const LARGE: usize = 8 << 20;

/// Checksum and contents. Neither needs the other; what is told first is damage.
fn check_all(header: &Header, payload: &[u8]) -> Result<(), InvalidPack> {
    let contents = || {
        let pack = check::structure(payload)?;
        check::contents(pack)?;
        let stated = options_hash(pack.options_text()) == header.options_hash;
        if stated { Ok(()) } else { Err(InvalidPack::Options) }
    };
    // Both read all of the file, which is as fast as one core's memory is.
    #[cfg(feature = "parallel")]
    if payload.len() >= LARGE {
        let (intact, sound) = rayon::join(|| header.matches_checksum(payload), contents);
        return if intact { sound } else { Err(InvalidPack::Checksum) };
    }
    if header.matches_checksum(payload) { contents() } else { Err(InvalidPack::Checksum) }
}

/// How much of a file is looked at when it is opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Checks {
    /// The vectors' bounds: nothing else keeps memory safe.
    Bounds,
    /// And where each hull's numbers stand.
    Structure,
    /// And all numbers.
    All,
}

/// No hull has that number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no hull {index}: the pack holds {hull_count}, counted from 0")]
pub struct NoSuchHull {
    /// Number asked for.
    pub index: usize,
    /// Number of hulls in the pack.
    pub hull_count: usize,
}

impl Pack {
    /// Maps the file and checks all of it.
    ///
    /// The file must not be cut or written to while it is mapped: replace packs by renaming a new file over the old
    /// one, as `bake` does. Else queries answer from other bytes than were checked, and on Unix the process gets SIGBUS where the
    /// file no longer reaches. Where it cannot be promised, use [`Pack::read`] or [`Pack::read_sealed`].
    ///
    /// # Errors
    /// [`OpenError`] names the file, what is wrong with it, and what to do.
    ///
    /// # Complexity
    /// One pass over the file; memory for the widest level of a hull's direction index, a few times that level's words.
    #[cfg(feature = "mmap")]
    pub fn open(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        Self::map(path.as_ref(), Checks::All)
    }

    /// Maps the file and checks its structure: header, length, and where each hull's numbers stand. **Skips the contents**: the
    /// checksum, and every number that a query follows or returns.
    ///
    /// For a file that has passed [`Pack::open`] since it was written, as at the end of an installation. If it is damaged all the
    /// same, queries may answer wrongly, not end, or panic; they never read out of bounds.
    ///
    /// # Errors
    /// As [`Pack::open`], for what is looked at.
    ///
    /// # Complexity
    /// O(number of hulls). No allocation that grows with the file.
    #[cfg(feature = "mmap")]
    pub fn open_skipping_contents(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        Self::map(path.as_ref(), Checks::Structure)
    }

    /// Maps the file and looks at its header, its length and the places of its sections alone. **Skips all else**, that each hull's
    /// numbers are there included.
    ///
    /// For files that are trusted as the program itself is, where each microsecond of start-up counts. If one is damaged all the same,
    /// a hull may be told to be missing, and queries may answer wrongly, not end, or panic; they never read out of bounds.
    ///
    /// # Errors
    /// As [`Pack::open`], for what is looked at.
    ///
    /// # Complexity
    /// O(1).
    #[cfg(feature = "mmap")]
    pub fn open_skipping_checks(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        Self::map(path.as_ref(), Checks::Bounds)
    }

    #[cfg(feature = "mmap")]
    fn map(path: &Path, checks: Checks) -> Result<Self, OpenError> {
        let io_error = |source| OpenError::Io { path: path.to_owned(), source };
        let file = File::open(path).map_err(io_error)?;
        if file.metadata().map_err(io_error)?.len() == 0 {
            // An empty file cannot be mapped.
            let source = HeaderError::TooShort { found: 0 }.into();
            return Err(OpenError::Invalid { path: path.to_owned(), source });
        }
        let map = crate::storage::map(&file).map_err(io_error)?;
        Self::from_storage_bytes(map, checks).map_err(|source| OpenError::Invalid { path: path.to_owned(), source })
    }

    /// Reads the file into memory of our own and checks all of it.
    ///
    /// # Errors
    /// As [`Pack::open`].
    ///
    /// # Complexity
    /// One read and one pass over the file.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        let path = path.as_ref();
        let io_error = |source| OpenError::Io { path: path.to_owned(), source };
        let mut buffer = AlignedVec::new();
        buffer.extend_from_reader(&mut File::open(path).map_err(io_error)?).map_err(io_error)?;
        Self::from_storage_bytes(Bytes::Owned(buffer), Checks::All)
            .map_err(|source| OpenError::Invalid { path: path.to_owned(), source })
    }

    /// Reads the file into memory of our own, makes its pages read-only, and checks all of it: neither another process nor a stray
    /// write of this one changes an answer.
    ///
    /// # Errors
    /// As [`Pack::open`].
    ///
    /// # Complexity
    /// One read and one pass over the file; whole pages.
    #[cfg(feature = "mmap")]
    pub fn read_sealed(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        let path = path.as_ref();
        let io_error = |source| OpenError::Io { path: path.to_owned(), source };
        let mut file = File::open(path).map_err(io_error)?;
        let length = file.metadata().map_err(io_error)?.len();
        let invalid = |source| OpenError::Invalid { path: path.to_owned(), source };
        if length == 0 {
            return Err(invalid(HeaderError::TooShort { found: 0 }.into()));
        }
        let length = usize::try_from(length).map_err(|error| io_error(io::Error::other(error)))?;
        let pages = crate::storage::sealed(&mut file, length).map_err(io_error)?;
        Self::from_storage_bytes(pages, Checks::All).map_err(invalid)
    }

    /// Copies the bytes of a whole file and checks all of them.
    ///
    /// # Errors
    /// What is wrong with the bytes.
    ///
    /// # Complexity
    /// One copy and one pass.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, InvalidPack> {
        let mut buffer = AlignedVec::with_capacity(bytes.len());
        buffer.extend_from_slice(bytes);
        Self::from_storage_bytes(Bytes::Owned(buffer), Checks::All)
    }

    fn from_storage_bytes(bytes: Bytes, checks: Checks) -> Result<Self, InvalidPack> {
        crate::simd::read_variable();
        let header = Header::read(bytes.as_slice())?;
        header.check_length(bytes.as_slice().len())?;
        let payload = bytes.payload();
        match checks {
            Checks::Bounds => {}
            Checks::Structure => {
                check::structure(payload)?;
            }
            Checks::All => check_all(&header, payload)?,
        }
        Ok(Self { storage: Storage::new(bytes)?, header })
    }

    /// Compares what the file holds twice: index blocks repeat their vertices, and edges are directions between vertices. No query
    /// needs it to be safe, so that [`Pack::open`] leaves it out; `bake verify` asks.
    ///
    /// # Errors
    /// The first hull that contradicts itself.
    ///
    /// # Complexity
    /// O(file), some ten times as long as opening it.
    pub fn check_repeats(&self) -> Result<(), InvalidPack> {
        Ok(repeats::repeats(self.storage.archive())?)
    }

    /// The file's header.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Length of the file, in bytes.
    pub fn byte_len(&self) -> usize {
        self.storage.file().len()
    }

    /// Path of the source relative to the pack's folder, with `/` between folders; empty if none was recorded.
    pub fn source_path(&self) -> &str {
        std::str::from_utf8(&self.storage.archive().source_path).unwrap_or_default()
    }

    /// The options that shaped the bake, as `bake` spells them out.
    pub fn options(&self) -> &str {
        self.storage.archive().options_text()
    }

    /// Number of hulls, at least 1 in a pack that was checked.
    pub fn hull_count(&self) -> usize {
        self.storage.archive().hulls.len()
    }

    /// Hull number `index`, counted from 0.
    ///
    /// # Errors
    /// [`NoSuchHull`] past the last one.
    ///
    /// # Complexity
    /// O(1), no allocation.
    pub fn hull(&self, index: usize) -> Result<Hull<'_>, NoSuchHull> {
        Hull::new(self.storage.archive(), index).ok_or(NoSuchHull { index, hull_count: self.hull_count() })
    }

    /// The tree of boxes over the hulls.
    pub(crate) fn nodes(&self) -> &[ArchivedBvhNode] {
        &self.storage.archive().nodes
    }

    /// The hull of this name: that of the object, node or part it was baked from, as `bake inspect` shows it. `None` where there is none.
    ///
    /// # Complexity
    /// O(number of hulls): keep the hull, or its number.
    pub fn hull_named(&self, name: &str) -> Option<Hull<'_>> {
        self.hulls().find(|hull| hull.name() == name)
    }

    /// All hulls, in the file's order.
    pub fn hulls(&self) -> impl Iterator<Item = Hull<'_>> {
        (0..self.hull_count()).filter_map(|index| self.hull(index).ok())
    }
}
