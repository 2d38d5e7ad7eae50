//! `--cache DIR`: a folder of finished packs by key, which a team or a build server shares.
//!
//! The pack with a [key](crate::jobs::key) is the file `DIR/ab/abcd….hullmap`: the key, in a folder
//! named after its first two digits.
//!
//! Any number of processes may use the folder at the same time. An entry appears complete, by a
//! rename, and two writers of an entry write the same bytes. Entries are not trusted: a reader
//! copies one and judges the copy like any pack on disk, see [`one`](super::one).
//!
//! If the cache cannot be read or written, packs are baked as without it, and one warning says so.

use std::collections::BTreeSet;
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use hullmap_format::header::{FileKind, MAX_PACK_LEN};
use hullmap_import::open_regular;

use crate::pack_file::{folder_of, link_below, make_folder, put_in_place, sweep, write_beside};

/// Number of digits of a key that name a folder: 256 folders.
const FOLDER_DIGITS: usize = 2;

pub struct Cache {
    root: PathBuf,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// Folders without files of killed processes.
    swept: BTreeSet<PathBuf>,
    /// The first entry that could not be read or written, and why.
    first_fault: Option<String>,
    fault_count: usize,
}

impl Cache {
    /// The cache in a folder, which need not exist.
    pub fn new(root: &Path) -> Self {
        Self { root: root.to_owned(), state: Mutex::default() }
    }

    /// The place of the pack with this key, 64 hexadecimal digits.
    pub fn entry(&self, key: &str, kind: FileKind) -> Entry<'_> {
        let digits = key.get(..FOLDER_DIGITS).unwrap_or_default();
        Entry { cache: self, path: self.root.join(digits).join(format!("{key}.{}", kind.extension())) }
    }

    /// Warning about entries that could not be read or written since the last call, if any.
    pub fn take_trouble(&self) -> Option<String> {
        let mut state = self.state();
        let first = state.first_fault.take()?;
        let count = std::mem::take(&mut state.fault_count);
        let of = if count > 1 { format!(" (the first of {count})") } else { String::new() };
        Some(format!("--cache: {first}{of}; the build is complete; check the folder's permissions and free space"))
    }

    fn fault(&self, entry: &Path, what: &str, error: &io::Error) {
        let mut state = self.state();
        state.fault_count += 1;
        state.first_fault.get_or_insert_with(|| format!("{} could not be {what}: {error}", entry.display()));
    }

    fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

pub struct Entry<'c> {
    cache: &'c Cache,
    path: PathBuf,
}

impl Entry<'_> {
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its bytes, which may be anything; `None` if there is no file, or it cannot be read.
    pub fn read(&self) -> Option<Vec<u8>> {
        match self.read_bytes() {
            Ok(bytes) => Some(bytes),
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            Err(error) => {
                self.cache.fault(&self.path, "read", &error);
                None
            }
        }
    }

    fn read_bytes(&self) -> io::Result<Vec<u8>> {
        self.check_folder()?;
        let file = open_regular(&self.path)?;
        if file.metadata()?.len() > MAX_PACK_LEN as u64 {
            return Err(io::Error::new(ErrorKind::FileTooLarge, "it is larger than a pack can be"));
        }
        let mut bytes = Vec::new();
        file.take(MAX_PACK_LEN as u64).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    pub fn write(&self, bytes: &[u8]) {
        if let Err(error) = self.write_bytes(bytes) {
            self.cache.fault(&self.path, "written", &error);
        }
    }

    fn write_bytes(&self, bytes: &[u8]) -> io::Result<()> {
        let folder = folder_of(&self.path);
        self.check_folder()?;
        make_folder(folder)?;
        // Once for each folder and build, because a folder may hold many entries.
        if self.cache.state().swept.insert(folder.to_owned()) {
            sweep(folder);
        }
        put_in_place(write_beside(&self.path, bytes)?, &self.path)
    }

    /// Fails if the folder is a link: whoever put it there would choose where files are written.
    fn check_folder(&self) -> io::Result<()> {
        match link_below(&self.cache.root, folder_of(&self.path)) {
            Some(link) => Err(io::Error::other(format!("{} is a link; replace it by a folder", link.display()))),
            None => Ok(()),
        }
    }
}
