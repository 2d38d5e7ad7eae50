//! Memory maps of triangle meshes: a constructor that is `unsafe`, for the same reason as maps of
//! packs.
#![allow(unsafe_code)]

use std::path::Path;

use super::TriangleMesh;
use crate::file::map;
use crate::pack::OpenError;

impl TriangleMesh {
    /// Maps the file and checks all of it. As [`Pack::map`](crate::Pack::map).
    ///
    /// # Safety
    /// As for [`Pack::map`](crate::Pack::map): while the mesh exists, no process may write to the
    /// file or truncate it. Replacing it by renaming another one over it is allowed.
    ///
    /// If a process writes to it in spite of this, the behaviour is undefined by the rules of Rust.
    /// In practice, queries return wrong answers, or panic, and if the file is truncated, reading
    /// past its new end raises SIGBUS on Unix. No query reads outside of the map: the places of all
    /// sections were read once, at opening.
    ///
    /// # Errors
    /// As [`TriangleMesh::open`].
    ///
    /// # Complexity
    /// A few passes over the file, without a copy.
    pub unsafe fn map(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        // SAFETY: the caller upholds the contract of this function, which is the contract of
        // `open`.
        unsafe { map::open(path.as_ref()) }
    }
}
