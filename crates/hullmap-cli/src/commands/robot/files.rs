use std::collections::BTreeSet;
use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf};

use hullmap_import::open_regular;

use hullmap_pipeline::mesh_file::obj;
use hullmap_pipeline::outcome::Failure;
use hullmap_pipeline::pack_file::{folder_of, link_below, make_folder, put_in_place, through_link, write_beside};

#[derive(Debug)]
pub struct Output {
    pub path: PathBuf,
    pub bytes: Vec<u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum State {
    Same,
    Other,
    Missing,
}

impl Output {
    pub fn state(&self) -> Result<State, Failure> {
        let fail = |error: std::io::Error| {
            Failure::usage(format!("{}: cannot read: {error}; check the path", self.path.display()))
        };
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
        let folder = folder_of(&self.path);
        if let Some(link) = link_below(out, folder) {
            return Err(Failure::usage(through_link(&self.path, &link)));
        }
        let fail = |error: std::io::Error| {
            let path = self.path.display();
            Failure::usage(format!("{path}: cannot write: {error}; check the folder's permissions and free space"))
        };
        make_folder(folder).map_err(fail)?;
        write_beside(&self.path, &self.bytes).and_then(|file| put_in_place(file, &self.path)).map_err(fail)
    }
}

pub fn starts_with(path: &Path, text: &str) -> bool {
    let mut start = Vec::new();
    let read = open_regular(path).and_then(|file| file.take(text.len() as u64).read_to_end(&mut start));
    read.is_ok() && start == text.as_bytes()
}

pub fn left_over(folder: &Path, used: &BTreeSet<PathBuf>) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let is_hull = |path: &PathBuf| {
        path.extension().is_some_and(|extension| extension == "obj") && starts_with(path, obj::FIRST_LINE)
    };
    let mut unused: Vec<PathBuf> = entries.filter(is_hull).filter(|path| !used.contains(path)).collect();
    unused.sort();
    unused
}
