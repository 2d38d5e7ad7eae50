//! Opens and checks `.hullmap` files.
//!
//! 1. Copy the file, or map it.
//! 2. Header: magic, version, length.
//! 3. Sections: cut the archive into slices ([`hullmap_format::sections`]). Later accesses use the
//!    slices; no offset in the file is followed again.
//! 4. Checksum (`file/mod.rs`).
//! 5. Structure, then every number that a query follows or returns ([`hullmap_format::check`]).
//!
//! After that, no query on the pack can panic, loop or read out of bounds. Functions whose names
//! end in `_skipping_contents` and `_skipping_checks` leave out steps.
//!
//! | constructor | memory | the file is written to or truncated | the file is replaced by renaming |
//! |---|---|---|---|
//! | [`Pack::open`] | a copy on read-only pages | no effect | no effect |
//! | [`Pack::from_bytes`] | a copy | no file | no file |
//! | [`Pack::from_static`] | the caller's, in place | no file | no file |
//! | [`Pack::map`], `unsafe` | the file's pages, shared by all processes | forbidden: wrong answers, SIGBUS | no effect |
//!
//! # Why mapping is `unsafe`
//! Rust lets the compiler assume that the bytes of a `&[u8]` do not change while it is borrowed.
//! Any process may write to a mapped file, so only the caller can promise that none does. `memmap2`
//! and `fst` make mapping `unsafe` for the same reason. The price of safety is a copy: opening a
//! large pack with [`Pack::open`] takes about twice as long as with [`Pack::map`]
//! (docs/contributors/RELIABILITY.md has figures). Map a pack if that time matters, if processes
//! should share its pages, or if there is not enough memory for a copy.
//!
//! If the promise is broken, the damage is bounded in practice: positions and lengths of all
//! sections were copied and checked in step 3, and all numbers that are still in the file are
//! values, or indices that are looked up with bounds checks. Queries then return wrong answers or
//! panic, or the process gets SIGBUS where a truncated file no longer has pages. They do not read
//! outside of the map. `tests/tests/packs/live_mapping.rs` rewrites a mapped file under running
//! queries to check it.
//!
//! # Cost of queries on a foreign pack
//! A pack states bounds on the work of its queries, and opening it compares them with the contents:
//! [`Hull::worst_cost`](crate::Hull::worst_cost) bounds a support query, and a contact takes at
//! most 10,000 of these. So a query of two hulls takes time at most proportional to the size of the
//! pack. docs/contributors/FORMAT.md, section 8, has a table. `hostile-packs --only large` measures
//! it.
//!
//! No signal handler is installed: the program decides what happens on a fault.
//!
//! The copy is on read-only pages and not in a sealed `memfd`, which needs a dependency. Only that
//! could be handed to other processes, but these can map the file themselves.

pub(crate) mod error;
#[cfg(feature = "mmap")]
mod map;
mod mass;
mod storage;

use std::path::Path;

use hullmap_format::{
    archive::ArchivedBvhNode,
    check,
    header::{FileKind, Header},
    repeats,
    sections::Sections,
};

use crate::facets::table::FacetTable;
use crate::file::checked::Checked;
use crate::file::{self, Bytes, check_checksum, check_options};
use crate::hull::Hull;
pub use error::{InvalidPack, NoHullNamed, NoSuchHull, OpenError};
use storage::Storage;

/// Maximum number of names in an error.
const MAX_NAMES: usize = 8;

/// An opened pack.
///
/// A [`Hull`] borrows from its pack. A [`SharedHull`](crate::SharedHull) keeps its pack alive.
/// Threads share a pack by reference or in an [`Arc`](std::sync::Arc).
///
/// # Examples
/// Reloading while other threads query the pack. A reader holds the lock only to clone the
/// [`Arc`](std::sync::Arc). The old pack is freed when its last reader drops it:
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("rock.hullmap");
/// # let write = |scale: f32| -> Result<(), Box<dyn std::error::Error>> {
/// #     let positions = shapes::families::rock(40, 1).into_iter().map(|p| p.map(|c| c * scale)).collect();
/// #     let points = hullmap_bake::PointSet { name: "rock".into(), positions, source_vertices: (0..40).collect(), ..Default::default() };
/// #     let baked = hullmap_bake::bake_hull(&points, hullmap_bake::IndexKind::Tree)?;
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
/// // `bake` has replaced the file.
/// let fresh = Arc::new(Pack::open(&path)?);
/// *current.write().expect("no writer panics") = fresh;
/// // The old pack still answers; new readers get the new one.
/// assert_eq!(pack.hull(0)?.support(Vec3::X).point.x, before);
/// assert_eq!(reader().hull(0)?.support(Vec3::X).point.x, 2.0 * before);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Pack {
    storage: Storage,
    header: Header,
    /// The face table of each hull that has one.
    facets: Box<[Option<FacetTable>]>,
}

/// Payloads of at least this many bytes are checked by two threads. Smaller ones take at most about
/// two milliseconds.
#[cfg(feature = "parallel")]
const LARGE: usize = 8 << 20;

/// How much of a file is checked when it is opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Checks {
    /// The positions of the sections. Memory safety requires no more.
    Sections,
    /// Also the runs of each hull.
    Structure,
    /// Also the checksum and all numbers.
    All,
}

impl Checked for Pack {
    const KIND: FileKind = FileKind::Pack;

    fn new(header: Header, bytes: Bytes) -> Result<Self, InvalidPack> {
        Self::from_storage_bytes(header, bytes, Checks::All)
    }

    /// Opening a pack compares the checksum itself.
    fn check(header: Header, bytes: Bytes) -> Result<Self, InvalidPack> {
        Self::new(header, bytes)
    }
}

fn check_contents(header: &Header, storage: &Storage) -> Result<(), InvalidPack> {
    let sections = storage.sections();
    check::structure(sections, storage.payload())?;
    check::contents(sections)?;
    check_options(header, sections.options_text())
}

/// Checks the checksum and the contents. If both fail, the checksum is reported.
fn check_all(header: &Header, storage: &Storage) -> Result<(), InvalidPack> {
    // Both read the whole file, at the speed of one core's memory accesses.
    #[cfg(feature = "parallel")]
    if storage.payload().len() >= LARGE {
        let checksum = || check_checksum(header, storage.payload());
        let (intact, sound) = rayon::join(checksum, || check_contents(header, storage));
        return intact.and(sound);
    }
    check_checksum(header, storage.payload())?;
    check_contents(header, storage)
}

impl Pack {
    /// Reads the file into memory of this process and checks all of it.
    ///
    /// With the feature `mmap`, the memory is made read-only: a stray write of this process faults
    /// instead of changing answers.
    ///
    /// # Errors
    /// [`OpenError`] names the file, what is wrong with it, and what to do.
    ///
    /// # Complexity
    /// One read and one pass over the file. Besides the copy, memory for the widest level of a
    /// hull's direction index, a few times that level's words.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        Self::copy(path.as_ref(), Checks::All)
    }

    /// Reads the file into memory of this process and checks its structure: header, length, and
    /// where each hull's data are. **Skips the contents**: the checksum, and all numbers that
    /// queries follow or return.
    ///
    /// Use it for a file that has passed [`Pack::open`] since it was written, for instance when it
    /// was installed. If the file is damaged, queries may return wrong answers or panic. They never
    /// read out of bounds.
    ///
    /// # Errors
    /// As [`Pack::open`], for what is checked.
    ///
    /// # Complexity
    /// One read of the file, then O(number of hulls): the face tables of hulls of at most 32
    /// vertices take about 1 µs a vertex. They take at most 4 MiB and 40 ms: if they would take
    /// more, there are none.
    pub fn open_skipping_contents(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        Self::copy(path.as_ref(), Checks::Structure)
    }

    /// Reads the file into memory of this process and checks its header, its length, and the
    /// positions of its sections. **Skips all other checks**.
    ///
    /// Use it for files that are trusted as much as the program itself. If the file is damaged,
    /// hulls may be missing, and queries may return wrong answers or panic. They never read out of
    /// bounds: positions of sections are checked, and every index is looked up with a bounds check.
    /// So this function is safe.
    ///
    /// # Errors
    /// As [`Pack::open`], for what is checked.
    ///
    /// # Complexity
    /// One read of the file, then the face tables of small hulls, as in
    /// [`Pack::open_skipping_contents`].
    pub fn open_skipping_checks(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        Self::copy(path.as_ref(), Checks::Sections)
    }

    fn copy(path: &Path, checks: Checks) -> Result<Self, OpenError> {
        let invalid = |cause: InvalidPack| OpenError::Invalid { path: path.to_owned(), cause };
        let (header, bytes) = file::read(path, Some(FileKind::Pack))?;
        Self::from_storage_bytes(header, bytes, checks).map_err(invalid)
    }

    /// Copies the bytes of a whole file and checks all of them.
    ///
    /// # Errors
    /// The bytes are rejected; the error states the first fault.
    ///
    /// # Complexity
    /// One copy and one pass.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, InvalidPack> {
        Self::copy_bytes(bytes, Checks::All)
    }

    /// Copies the bytes of a whole file and checks their structure. **Skips the contents**, as
    /// [`open_skipping_contents`](Self::open_skipping_contents) does, under the same conditions.
    ///
    /// # Errors
    /// As [`Pack::from_bytes`], for what is checked.
    ///
    /// # Complexity
    /// One copy, then O(number of hulls), as for
    /// [`open_skipping_contents`](Self::open_skipping_contents).
    pub fn from_bytes_skipping_contents(bytes: &[u8]) -> Result<Self, InvalidPack> {
        Self::copy_bytes(bytes, Checks::Structure)
    }

    fn copy_bytes(bytes: &[u8], checks: Checks) -> Result<Self, InvalidPack> {
        let header = Header::read(bytes)?;
        Self::from_storage_bytes(header, file::copy_of(bytes), checks)
    }

    /// Uses the bytes of a whole file in place, and checks all of them. No copy is made.
    ///
    /// For packs that are part of the program, or that stay in memory until it ends. The bytes must
    /// start on a multiple of 64 bytes, which `include_bytes!` alone does not promise: put them
    /// into a type with `#[repr(align(64))]`.
    ///
    /// # Errors
    /// As [`Pack::from_bytes`], and if the bytes are not aligned.
    ///
    /// # Complexity
    /// One pass.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
    /// # fn main() -> Result<(), hullmap::InvalidPack> {
    /// use hullmap::Pack;
    ///
    /// /// In a program: `static ROCK: Aligned<[u8; N]> = Aligned(*include_bytes!("rock.hullmap"));`
    /// #[repr(align(64))]
    /// struct Aligned<T: ?Sized>(T);
    ///
    /// # let file: Vec<u8> = rock_and_cube();
    /// # let mut memory = Aligned([0_u8; 1 << 16]);
    /// # memory.0[..file.len()].copy_from_slice(&file);
    /// # let memory: &'static Aligned<[u8; 1 << 16]> = Box::leak(Box::new(memory));
    /// # let bytes: &'static [u8] = &memory.0[..file.len()];
    /// let pack = Pack::from_static(bytes)?;
    /// assert_eq!(pack.hull_count(), 2);
    /// # let moved: &'static [u8] = Box::leak([&[0; 8][..], bytes].concat().into_boxed_slice());
    /// # assert!(Pack::from_static(&moved[8..]).is_err());
    /// # Ok(())
    /// # }
    /// ```
    pub fn from_static(bytes: &'static [u8]) -> Result<Self, InvalidPack> {
        Self::from_storage_bytes(Header::read(bytes)?, Bytes::Static(bytes), Checks::All)
    }

    /// Uses the bytes of a whole file in place, as [`from_static`](Self::from_static) does, and
    /// checks their structure. **Skips the contents**, as
    /// [`open_skipping_contents`](Self::open_skipping_contents) does, under the same conditions.
    ///
    /// # Errors
    /// As [`Pack::from_static`], for what is checked.
    ///
    /// # Complexity
    /// O(number of hulls), as for [`open_skipping_contents`](Self::open_skipping_contents).
    pub fn from_static_skipping_contents(bytes: &'static [u8]) -> Result<Self, InvalidPack> {
        Self::from_storage_bytes(Header::read(bytes)?, Bytes::Static(bytes), Checks::Structure)
    }

    fn from_storage_bytes(header: Header, bytes: Bytes, checks: Checks) -> Result<Self, InvalidPack> {
        crate::support::simd::read_variable();
        header.check_length(bytes.as_slice().len() as u64)?;
        if checks == Checks::All && Sections::read(bytes.payload()).is_err() {
            // A damaged file is reported as damaged even if the damage is in the root.
            check_checksum(&header, bytes.payload())?;
        }
        let storage = Storage::new(bytes)?;
        if let Err(error) = check::layout(storage.sections(), header.layout()) {
            if checks == Checks::All {
                check_checksum(&header, storage.payload())?;
            }
            return Err(error.into());
        }
        match checks {
            Checks::Sections => {}
            Checks::Structure => check::structure(storage.sections(), storage.payload())?,
            Checks::All => check_all(&header, &storage)?,
        }
        let sections = storage.sections();
        let facets = FacetTable::of_pack(sections);
        Ok(Self { storage, header, facets })
    }

    /// Compares the data that the file holds twice: index blocks repeat vertices, and edges are the
    /// directions between vertices.
    ///
    /// No query requires the two to agree in order to be safe, so [`Pack::open`] does not compare
    /// them. `bake verify` does.
    ///
    /// # Errors
    /// The first hull that contradicts itself.
    ///
    /// # Complexity
    /// O(file), about ten times as long as opening it.
    pub fn check_repeats(&self) -> Result<(), InvalidPack> {
        Ok(repeats::repeats(self.storage.sections())?)
    }

    /// Header of the file, as it was when the pack was opened.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Length of the file in bytes.
    pub fn byte_len(&self) -> usize {
        self.storage.file().len()
    }

    /// Bytes of the whole file: header and payload.
    pub fn bytes(&self) -> &[u8] {
        self.storage.file()
    }

    /// Path of the source relative to the pack's folder, with `/` between folders. Empty if none
    /// was recorded.
    pub fn source_path(&self) -> &str {
        std::str::from_utf8(self.storage.sections().source_path).unwrap_or_default()
    }

    /// The options that shaped the bake, in the form in which `bake` records them: one line.
    pub fn options(&self) -> &str {
        self.record().next().unwrap_or_default()
    }

    /// Warnings of the bake about the mesh and its hulls, each with its remedy. `bake build` shows
    /// them again when the pack is fresh.
    pub fn warnings(&self) -> impl Iterator<Item = &str> {
        self.record().skip(1)
    }

    /// The lines of the section `options`.
    fn record(&self) -> impl Iterator<Item = &str> {
        self.storage.sections().options_text().split('\n')
    }

    /// Whether this is a lean pack (option `lean`), without the data that only manifolds,
    /// hints and walks over the surface need: see [`Hull::is_lean`].
    pub fn is_lean(&self) -> bool {
        self.storage.sections().is_lean()
    }

    /// Number of hulls. At least 1 in a pack whose structure was checked.
    pub fn hull_count(&self) -> usize {
        self.storage.sections().hulls.len()
    }

    /// The hull of index `index`, counted from 0.
    ///
    /// # Errors
    /// [`NoSuchHull`] if `index` is not below [`hull_count`](Self::hull_count).
    ///
    /// # Complexity
    /// O(1), no allocation.
    pub fn hull(&self, index: usize) -> Result<Hull<'_>, NoSuchHull> {
        let facets = self.facets.get(index).and_then(Option::as_ref);
        Hull::new(self.storage.sections(), facets, index).ok_or(NoSuchHull { index, hull_count: self.hull_count() })
    }

    pub(crate) fn nodes(&self) -> &[ArchivedBvhNode] {
        self.storage.sections().nodes
    }

    /// The first hull named `name`. A hull has the name of the object, node or part that it was
    /// baked from.
    ///
    /// # Errors
    /// [`NoHullNamed`], with the names of the hulls, if there is no such hull.
    ///
    /// # Complexity
    /// O(number of hulls). Keep the hull or its index.
    pub fn hull_named(&self, name: &str) -> Result<Hull<'_>, NoHullNamed> {
        self.hulls().find(|hull| hull.name() == name).ok_or_else(|| self.no_hull_named(name))
    }

    pub(crate) fn no_hull_named(&self, name: &str) -> NoHullNamed {
        let names = self.hulls().take(MAX_NAMES).map(|hull| hull.name().to_owned()).collect();
        NoHullNamed { name: name.to_owned(), names, hull_count: self.hull_count() }
    }

    /// All hulls, in the order of the file.
    pub fn hulls(&self) -> impl Iterator<Item = Hull<'_>> {
        (0..self.hull_count()).filter_map(|index| self.hull(index).ok())
    }
}
