//! Source files in memory, with the buffers beside them and a hash of all bytes.

use std::fs::{File, Metadata};
use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf};

use hullmap_format::header::source_hash;

use crate::fault::{Fault, ImportError, LineFault};
use crate::foreign;
use crate::format::Format;
use crate::gltf;
use crate::limits::Limits;

/// All bytes of a source: a file, and the buffers beside a glTF file.
#[derive(Clone, Debug, Default)]
pub struct SourceFile {
    /// Bytes of the file.
    pub bytes: Vec<u8>,
    /// Required files beside it, with their relative paths: the buffers of a glTF file, in the
    /// document's order, or the image of a terrain's holes.
    pub beside: Vec<(String, Vec<u8>)>,
    /// XXH3-128 of the file's bytes; with files beside it, of the hashes of the file and then of
    /// these, each as 16 bytes in little-endian order.
    pub hash: u128,
}

impl SourceFile {
    /// A file without others beside it.
    pub fn alone(bytes: Vec<u8>) -> Self {
        Self::new(bytes, Vec::new())
    }

    fn new(bytes: Vec<u8>, beside: Vec<(String, Vec<u8>)>) -> Self {
        let mut hash = source_hash(&bytes);
        if !beside.is_empty() {
            let others = beside.iter().map(|(_, bytes)| source_hash(bytes));
            let hashes: Vec<u8> = std::iter::once(hash).chain(others).flat_map(u128::to_le_bytes).collect();
            hash = source_hash(&hashes);
        }
        Self { bytes, beside, hash }
    }
}

/// Error of [`read`].
#[derive(Debug)]
pub enum ReadError {
    /// The file, or a buffer that exists, cannot be opened or read.
    Io(std::io::Error),
    /// The file is too large or damaged, or a buffer is missing.
    Import(ImportError),
}

impl ReadError {
    /// Whether the file and its buffers exceed [`Limits::input_bytes`].
    pub fn is_too_large(&self) -> bool {
        matches!(self, Self::Import(ImportError { fault: Fault::InputTooLarge { .. }, .. }))
    }
}

/// Reads a file, whose name in messages is `file`, and the required buffers beside it.
///
/// # Errors
/// The file or a buffer cannot be read or is not a regular file, or they are larger than the limit.
pub fn read(file: &str, path: &Path, limits: &Limits) -> Result<SourceFile, ReadError> {
    read_beside(file, path, limits, "buffer", |bytes| {
        let is_gltf = foreign::format_of(path, bytes).map_err(Fault::of_file)? == Format::Gltf;
        if is_gltf { gltf::buffer_paths(bytes) } else { Ok(Vec::new()) }
    })
}

/// Reads a file, and files beside it that `names` finds in its bytes, each a `kind` in messages.
pub(crate) fn read_beside(
    file: &str,
    path: &Path,
    limits: &Limits,
    kind: &str,
    names: impl FnOnce(&[u8]) -> Result<Vec<String>, LineFault>,
) -> Result<SourceFile, ReadError> {
    let fault = |LineFault { line, fault }| ReadError::Import(ImportError { file: file.to_owned(), line, fault });
    let mut left = limits.input_bytes;
    let bytes = read_bounded(path, &mut left).map_err(ReadError::Io)?;
    let too_large = || fault(Fault::InputTooLarge { limit: limits.input_bytes }.of_file());
    let bytes = bytes.ok_or_else(too_large)?;
    let mut beside = Vec::new();
    for name in names(&bytes).map_err(fault)? {
        let folder = path.parent().unwrap_or(Path::new(""));
        let other = read_bounded(&folder.join(&name), &mut left).map_err(|error| match error.kind() {
            ErrorKind::NotFound => {
                let text = format!("{kind} {name} cannot be read: {error}; restore it beside the file");
                fault(LineFault::of_file(text))
            }
            error_kind => ReadError::Io(std::io::Error::new(error_kind, format!("{kind} {name}: {error}"))),
        })?;
        beside.push((name, other.ok_or_else(too_large)?));
    }
    Ok(SourceFile::new(bytes, beside))
}

/// Paths of the required buffers beside a glTF file, for instance to watch them for changes. Empty
/// for other formats, and for faulty or missing files.
///
/// # Errors
/// The file exists but cannot be read.
pub fn buffers_of(path: &Path) -> std::io::Result<Vec<PathBuf>> {
    if Format::detect(path, &[]) != Format::Gltf {
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

/// Opens a regular file for reading, also through links. Nothing else is opened: a pipe would
/// block, a device may never end, and opening one can act on it.
///
/// # Errors
/// There is no such file, it is not a regular one, or it cannot be opened.
pub fn open_regular(path: &Path) -> std::io::Result<File> {
    check_regular(&std::fs::metadata(path)?)?;
    let mut options = File::options();
    options.read(true);
    // The path may name a pipe by now, which this flag opens without blocking.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK);
    let file = options.open(path)?;
    check_regular(&file.metadata()?)?;
    Ok(file)
}

fn check_regular(metadata: &Metadata) -> std::io::Result<()> {
    if metadata.is_file() {
        return Ok(());
    }
    Err(std::io::Error::other(format!("it is {}, not a regular file", kind_of(metadata))))
}

#[cfg(unix)]
fn kind_of(metadata: &Metadata) -> &'static str {
    use std::os::unix::fs::FileTypeExt as _;
    let kind = metadata.file_type();
    match (kind.is_dir(), kind.is_fifo(), kind.is_socket()) {
        (true, ..) => "a folder",
        (_, true, _) => "a pipe",
        (.., true) => "a socket",
        _ => "a device",
    }
}

#[cfg(not(unix))]
fn kind_of(metadata: &Metadata) -> &'static str {
    if metadata.is_dir() { "a folder" } else { "a pipe or a device" }
}

/// Bytes of a file, or `None` if there are more than `left`. Subtracts them from `left`.
fn read_bounded(path: &Path, left: &mut u64) -> std::io::Result<Option<Vec<u8>>> {
    let file = open_regular(path)?;
    // The length is only a hint: a file may grow.
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
