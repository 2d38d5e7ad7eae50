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
    ///
    /// # Examples
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// use hullmap::TriangleMesh;
    /// # use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
    /// # let positions = [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0]];
    /// # let baked = bake_triangle_mesh(&Triangles { positions: &positions, corners: &[[0, 1, 2]], materials: &[] })?;
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("level.hullmesh");
    /// # std::fs::write(&path, write_triangle_mesh(baked, &Default::default())?)?;
    ///
    /// // SAFETY: the file was installed with the program and is never written to again.
    /// let level = unsafe { TriangleMesh::map(&path)? };
    /// assert_eq!(level.triangle_count(), 1);
    /// # Ok(())
    /// # }
    /// ```
    pub unsafe fn map(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        // SAFETY: the caller upholds the contract of this function, which is the contract of
        // `open`.
        unsafe { map::open(path.as_ref()) }
    }
}
