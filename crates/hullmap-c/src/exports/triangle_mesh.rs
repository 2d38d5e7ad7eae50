//! Triangle meshes: opening, and the triangles in them.
#![allow(unsafe_code)]

use std::ffi::c_char;

use super::pack::{native, not_opened};
use crate::border::{self, Out, call};
use crate::failure::Failure;
use crate::handles::TriangleMesh;
use crate::types::{MeshTriangle, Result};

/// Opens the file of a triangle mesh, which `bake build --keep-triangles` writes. The file is
/// copied into memory and checked completely, so that no file can harm a later query.
///
/// path: in UTF-8 on Windows, in the system's bytes elsewhere.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_triangle_mesh_open(path: *const c_char, mesh: *mut *mut TriangleMesh) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (out, path) = unsafe { (Out::of_handle("mesh", mesh)?, border::text("path", path)?) };
        let opened = hullmap::TriangleMesh::open(native(path)?);
        out.give(TriangleMesh::new(opened.map_err(not_opened)?));
        Ok(())
    })
}

/// Opens a triangle mesh that is in memory: all bytes of a file. They are copied, and may be freed
/// after the call; any alignment will do.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_triangle_mesh_from_memory(
    bytes: *const u8,
    length: usize,
    mesh: *mut *mut TriangleMesh,
) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header. Nothing keeps a reference
        // to the bytes after this call.
        let (out, bytes) = unsafe { (Out::of_handle("mesh", mesh)?, border::array("bytes", bytes, length)?) };
        let opened = hullmap::TriangleMesh::from_bytes(bytes);
        out.give(TriangleMesh::new(opened.map_err(|error| Failure::new(Result::InvalidPack, error))?));
        Ok(())
    })
}

/// Frees a triangle mesh; NULL is allowed. Shapes made from it stay valid, and keep its memory.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_triangle_mesh_free(mesh: *mut TriangleMesh) {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { border::free(mesh) }
}

/// Number of triangles of a mesh, at least 1; 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_triangle_mesh_triangle_count(mesh: *const TriangleMesh) -> usize {
    let mut count = 0;
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        count = unsafe { border::handle("mesh", mesh)? }.mesh().triangle_count();
        Ok(())
    });
    count
}

/// Number of vertices of a mesh; 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_triangle_mesh_vertex_count(mesh: *const TriangleMesh) -> usize {
    let mut count = 0;
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        count = unsafe { border::handle("mesh", mesh)? }.mesh().vertex_count();
        Ok(())
    });
    count
}

/// The triangle of index `index`, counted from 0, as answers of queries count them. O(1).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_triangle_mesh_triangle(
    mesh: *const TriangleMesh,
    index: usize,
    triangle: *mut MeshTriangle,
) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (mesh, out) = unsafe { (border::handle("mesh", mesh)?, Out::new("triangle", triangle)?) };
        out.write(mesh.triangle(index)?);
        Ok(())
    })
}
