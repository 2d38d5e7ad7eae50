//! Triangle meshes: opening, and the triangles in them.
#![allow(unsafe_code)]

use std::ffi::c_char;

use super::sheet;
use crate::border;
use crate::handles::TriangleMesh;
use crate::types::{MeshTriangle, Result};

/// Opens the file of a triangle mesh, which `bake build --keep-triangles` writes. The file is
/// copied into memory and checked completely, so that no file can harm a later query.
///
/// path: in UTF-8 on Windows, in the system's bytes elsewhere.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_triangle_mesh_open(path: *const c_char, mesh: *mut *mut TriangleMesh) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { sheet::open("mesh", path, mesh, hullmap::TriangleMesh::open) }
}

/// Opens a triangle mesh that is in memory: all bytes of a file. They are copied, and may be freed
/// after the call; any alignment will do.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_triangle_mesh_from_memory(
    bytes: *const u8,
    length: usize,
    mesh: *mut *mut TriangleMesh,
) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { sheet::from_memory("mesh", bytes, length, mesh, hullmap::TriangleMesh::from_bytes) }
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
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { sheet::count("mesh", mesh, |mesh| mesh.0.triangle_count()) }
}

/// Number of vertices of a mesh; 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_triangle_mesh_vertex_count(mesh: *const TriangleMesh) -> usize {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { sheet::count("mesh", mesh, |mesh| mesh.0.vertex_count()) }
}

/// The triangle of index `index`, counted from 0, as answers of queries count them. O(1).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_triangle_mesh_triangle(
    mesh: *const TriangleMesh,
    index: usize,
    triangle: *mut MeshTriangle,
) -> Result {
    let find = |mesh: &TriangleMesh| {
        let found = MeshTriangle::from_mesh(&mesh.0, index);
        found.ok_or_else(|| sheet::no_triangle(index, "mesh", mesh.0.triangle_count()))
    };
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { sheet::triangle("mesh", mesh, triangle, find) }
}
