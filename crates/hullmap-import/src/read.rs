//! A source file in memory, with the files it draws on, and the hash of all that was read.

use std::fs::File;
use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf};

use hullmap_format::header::source_hash;

use crate::fault::{Fault, ImportError, LineFault};
use crate::format::Format;
use crate::gltf;
use crate::limits::Limits;

/// All bytes that a pack is baked from.
#[derive(Clone, Debug, Default)]
pub struct SourceFile {
    /// The file's own.
    pub bytes: Vec<u8>,
    /// Buffers beside a glTF file, by their paths relative to it, in the document's order.
    pub beside: Vec<(String, Vec<u8>)>,
    /// XXH3-128 of the file's bytes. Where there are buffers beside it, that of a list of hashes, of 16 bytes each, the
    /// lowest first: the file's, then each buffer's. (The file itself names the buffers.)
    pub hash: u128,
}

impl SourceFile {
    /// A file that draws on no other.
    pub fn alone(bytes: Vec<u8>) -> Self {
        let hash = source_hash(&bytes);
        Self { bytes, beside: Vec::new(), hash }
    }
}

/// Why a source file could not be read.
#[derive(Debug)]
pub enum ReadError {
    /// It, or a file that it draws on and that is there, cannot be opened or read.
    Io(std::io::Error),
    /// It is too large, or a file that it draws on is missing or damaged.
    Import(ImportError),
}

/// Reads a file and the buffers beside it. `file` is its name in messages.
///
/// # Errors
/// The file cannot be read, is too large, or names buffers that cannot be.
pub fn read(file: &str, path: &Path, limits: &Limits) -> Result<SourceFile, ReadError> {
    let fault = |LineFault { line, fault }| ReadError::Import(ImportError { file: file.to_owned(), line, fault });
    let mut left = limits.input_bytes;
    let bytes = read_bounded(path, &mut left).map_err(ReadError::Io)?;
    let bytes = bytes.ok_or_else(|| fault(too_large(limits)))?;
    if Format::of(path, &bytes) != Format::Gltf {
        return Ok(SourceFile::alone(bytes));
    }
    let mut beside = Vec::new();
    for name in gltf::buffer_paths(&bytes).map_err(fault)? {
        let folder = path.parent().unwrap_or(Path::new(""));
        let buffer = read_bounded(&folder.join(&name), &mut left).map_err(|error| match error.kind() {
            ErrorKind::NotFound => {
                let text = format!("its buffer {name} cannot be read: {error}; put it back beside the file");
                fault(Fault::format(text).of_file())
            }
            kind => ReadError::Io(std::io::Error::new(kind, format!("its buffer {name}: {error}"))),
        })?;
        beside.push((name, buffer.ok_or_else(|| fault(too_large(limits)))?));
    }
    if beside.is_empty() {
        return Ok(SourceFile::alone(bytes));
    }
    let hashes = std::iter::once(&bytes).chain(beside.iter().map(|(_, bytes)| bytes));
    let hashes: Vec<u8> = hashes.flat_map(|bytes| source_hash(bytes).to_le_bytes()).collect();
    Ok(SourceFile { bytes, beside, hash: source_hash(&hashes) })
}

/// Paths of the buffers that a glTF file names beside it, for those who watch files; none where it is faulty or not there.
///
/// # Errors
/// It is there and cannot be read.
pub fn buffers_of(path: &Path) -> std::io::Result<Vec<PathBuf>> {
    if Format::of(path, &[]) != Format::Gltf {
        return Ok(Vec::new());
    }
    let mut left = Limits::DEFAULT.input_bytes;
    let bytes = match read_bounded(path, &mut left) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
        read => read.ok().flatten().unwrap_or_default(),
    };
    let names = gltf::buffer_paths(&bytes).unwrap_or_default();
    Ok(names.iter().map(|name| path.with_file_name(name)).collect())
}

fn too_large(limits: &Limits) -> LineFault {
    Fault::format(format!(
        "more than {} bytes, and importing may take eight times as much memory; split the file, or raise --max-input-bytes",
        limits.input_bytes
    ))
    .of_file()
}

/// The bytes of a file, unless there are more than are `left`, from which they are taken.
fn read_bounded(path: &Path, left: &mut u64) -> std::io::Result<Option<Vec<u8>>> {
    let file = File::open(path)?;
    // The length is a hint: pipes and the like have none, and a file may grow.
    let length = file.metadata()?.len();
    if length > *left {
        return Ok(None);
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length as usize + 1).map_err(|_| std::io::ErrorKind::OutOfMemory)?;
    file.take(left.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > *left {
        return Ok(None);
    }
    *left -= bytes.len() as u64;
    Ok(Some(bytes))
}
