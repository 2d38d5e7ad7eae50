//! Puts written files in place, if their bytes differ from what is there. Each is complete or
//! absent. A file that `bake` did not write is replaced only on request.
//!
//! Freshness is judged by bytes, as for [packs](crate::runner::freshness): nothing is recorded
//! beside the files.

use std::fs;
use std::io::{self, ErrorKind, Read as _};
use std::path::{Path, PathBuf};

use hullmap_import::open_regular;

use super::seal::is_sealed;
use crate::outcome::Failure;
use crate::pack_file::{
    Unplaced, folder_of, link_below, make_folder, put_in_free_place, put_in_place, through_link, write_beside,
};

/// Maximum size of a file whose seal is checked, in bytes. A larger one is never replaced.
const MAX_SEALED: u64 = 1 << 30;

#[derive(Debug)]
pub struct OutputFile {
    pub path: PathBuf,
    pub bytes: Vec<u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum State {
    Same,
    Other,
    Missing,
}

impl OutputFile {
    /// Compares it with the file in its place.
    pub fn state(&self) -> Result<State, Failure> {
        let fail =
            |error: io::Error| Failure::usage(format!("{}: cannot read: {error}; check the path", self.path.display()));
        let mut file = match open_regular(&self.path) {
            Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
                return Ok(State::Missing);
            }
            other => other.map_err(fail)?,
        };
        if file.metadata().map_err(fail)?.len() != self.bytes.len() as u64 {
            return Ok(State::Other);
        }
        let mut bytes = Vec::with_capacity(self.bytes.len());
        file.read_to_end(&mut bytes).map_err(fail)?;
        Ok(if bytes == self.bytes { State::Same } else { State::Other })
    }

    pub fn write_if_changed(&self) -> Result<(), Failure> {
        if self.state()? == State::Same { Ok(()) } else { self.write(folder_of(&self.path)) }
    }

    /// Creates the folder and writes the file, unless the file is below a link in `out`.
    pub fn write(&self, out: &Path) -> Result<(), Failure> {
        self.put(out, put_in_place)
    }

    fn put(&self, out: &Path, place: fn(Unplaced, &Path) -> io::Result<()>) -> Result<(), Failure> {
        let folder = folder_of(&self.path);
        if let Some(link) = link_below(out, folder) {
            return Err(Failure::usage(through_link(&self.path, &link)));
        }
        let made = make_folder(folder).and_then(|()| write_beside(&self.path, &self.bytes));
        made.and_then(|file| place(file, &self.path)).map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => exists(&self.path),
            _ => Failure::usage(format!("{}: cannot write: {error}; check the path", self.path.display())),
        })
    }
}

/// Writes the files that differ from what is there, and returns what was in each place. Writes none
/// if one would replace a file that is not sealed, without `force`.
pub fn update(files: &[OutputFile], out: &Path, force: bool) -> Result<Vec<State>, Failure> {
    let states = files.iter().map(OutputFile::state).collect::<Result<Vec<_>, _>>()?;
    let changed = || files.iter().zip(&states).filter(|(_, state)| **state != State::Same);
    if !force {
        changed().try_for_each(|(file, _)| check_free(&file.path))?;
    }
    for (file, state) in changed() {
        let is_new = *state == State::Missing && !force;
        file.put(out, if is_new { put_in_free_place } else { put_in_place })?;
    }
    Ok(states)
}

/// Fails if a link is at a path, or a file that is not sealed.
pub fn check_free(path: &Path) -> Result<(), Failure> {
    let Ok(found) = fs::symlink_metadata(path) else { return Ok(()) };
    let read = || {
        let mut bytes = Vec::new();
        open_regular(path)?.take(MAX_SEALED).read_to_end(&mut bytes).map(|_| bytes)
    };
    let is_own = found.is_file() && found.len() <= MAX_SEALED && read().is_ok_and(is_sealed);
    if is_own { Ok(()) } else { Err(exists(path)) }
}

pub fn exists(path: &Path) -> Failure {
    let path = path.display();
    Failure::usage(format!(
        "{path}: exists, and is not as bake wrote it, so it was not changed; name another path, or replace it with \
         --force"
    ))
}
