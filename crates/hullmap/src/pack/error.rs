//! Errors: a file cannot be opened, or a hull is not in a pack.

use std::{io, path::PathBuf};

use hullmap_format::{
    check::CheckError, header::HeaderError, height_field::check::FieldError, triangle_mesh::check::MeshError,
};

/// Why a pack, a triangle mesh or a height field could not be opened.
///
/// Its text states the cause, so it has no `source`: reports that print the sources of an error
/// would repeat it.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The file could not be read.
    #[error("{path}: cannot read the file: {cause}; {}", remedy(cause))]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        cause: io::Error,
    },
    /// The file is not one that this version reads.
    #[error("{path}: {cause}")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// The fault.
        cause: InvalidPack,
    },
}

/// Remedy for a file that the system does not read.
fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => "check the path, and the folder it starts from",
        io::ErrorKind::IsADirectory => "name a pack in this folder",
        io::ErrorKind::PermissionDenied => "check its permissions, and that it is a file",
        _ => "check the path and the file system",
    }
}

/// Fault in the bytes of a pack, a triangle mesh or a height field.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InvalidPack {
    /// The header, or the file's length.
    #[error(transparent)]
    Header(#[from] HeaderError),
    /// A byte has changed since the bake.
    #[error(
        "the file is damaged: the checksum of its bytes is {found:016x}, but its header states {expected:016x}; bake the \
         source again"
    )]
    Checksum {
        /// Checksum in the header.
        expected: u64,
        /// Checksum of the bytes.
        found: u64,
    },
    /// The hash of the recorded options differs from the hash in the header.
    #[error(
        "the file is damaged: the hash of its options is {found:016x}, but its header states {expected:016x}; bake the \
         source again"
    )]
    Options {
        /// Hash in the header.
        expected: u64,
        /// Hash of the recorded options.
        found: u64,
    },
    /// The archive after the header of a pack.
    #[error(transparent)]
    Content(#[from] CheckError),
    /// The archive after the header of a triangle mesh.
    #[error(transparent)]
    TriangleMesh(#[from] MeshError),
    /// The archive after the header of a height field.
    #[error(transparent)]
    HeightField(#[from] FieldError),
}

/// A pack has no hull of this index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("hull index {index} is out of range: the pack has {hull_count}, counted from 0")]
pub struct NoSuchHull {
    /// Requested index.
    pub index: usize,
    /// Number of hulls in the pack.
    pub hull_count: usize,
}

/// A pack has no hull of this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no hull has the name \"{name}\": the pack has {hull_count} ({})", listed(names, *hull_count))]
pub struct NoHullNamed {
    /// Requested name.
    pub name: String,
    /// Names of the first hulls of the pack.
    pub names: Vec<String>,
    /// Number of hulls in the pack.
    pub hull_count: usize,
}

fn listed(names: &[String], count: usize) -> String {
    let more = if names.len() < count { ", …" } else { "" };
    format!("{}{more}", names.join(", "))
}

#[cfg(test)]
mod tests {
    use crate::Pack;

    /// Python printed only "No such file or directory", and "No such device" for a folder.
    #[test]
    fn files_that_cannot_be_read_have_a_remedy() {
        let message = Pack::open("missing.hullmap").unwrap_err().to_string();
        assert!(message.starts_with("missing.hullmap: cannot read the file: "), "{message}");
        assert!(message.ends_with("; check the path, and the folder it starts from"), "{message}");
        #[cfg(unix)]
        assert!(Pack::open("/").unwrap_err().to_string().ends_with("; name a pack in this folder"));
    }
}
