//! Height fields: opening, the grid, the triangles and the ground.
#![allow(unsafe_code)]

use std::ffi::c_char;

use super::sheet;
use crate::border::{self, Out, call};
use crate::failure::Failure;
use crate::handles::HeightField;
use crate::types::{FieldLayout, Ground, MeshTriangle, Result};

/// Opens the file of a height field, which `bake build --terrain` writes. The file is copied
/// into memory and checked completely, so that no file can harm a later query.
///
/// path: in UTF-8 on Windows, in the system's bytes elsewhere.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_height_field_open(path: *const c_char, field: *mut *mut HeightField) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { sheet::open("field", path, field, hullmap::HeightField::open) }
}

/// Opens a height field that is in memory: all bytes of a file. They are copied, and may be freed
/// after the call; any alignment will do.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_height_field_from_memory(
    bytes: *const u8,
    length: usize,
    field: *mut *mut HeightField,
) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { sheet::from_memory("field", bytes, length, field, hullmap::HeightField::from_bytes) }
}

/// Frees a height field; NULL is allowed. Shapes made from it stay valid, and keep its memory.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_height_field_free(field: *mut HeightField) {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { border::free(field) }
}

/// Number of triangles of a height field, including the triangles of holes: two for each cell; 0
/// for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_height_field_triangle_count(field: *const HeightField) -> usize {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { sheet::count("field", field, |field| field.0.triangle_count()) }
}

/// The grid of a height field.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_height_field_layout(field: *const HeightField, layout: *mut FieldLayout) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (field, out) = unsafe { (border::handle("field", field)?, Out::new("layout", layout)?) };
        out.write(FieldLayout::from_field(&field.0));
        Ok(())
    })
}

/// The triangle of index `index`, counted from 0, as answers of queries count them. A triangle in a
/// hole is HULLMAP_RESULT_NOT_FOUND. O(1).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_height_field_triangle(
    field: *const HeightField,
    index: usize,
    triangle: *mut MeshTriangle,
) -> Result {
    let find = |field: &HeightField| {
        let found = MeshTriangle::from_field(&field.0, index);
        found.ok_or_else(|| sheet::no_triangle(index, "field", field.0.triangle_count()))
    };
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { sheet::triangle("field", field, triangle, find) }
}

/// The ground at (x, y), in the frame of the field. On a shared edge or vertex, the triangle is the
/// one with the lowest index. HULLMAP_RESULT_NOT_FOUND in a hole, and beyond the field. O(1).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_height_field_height_at(
    field: *const HeightField,
    x: f64,
    y: f64,
    ground: *mut Ground,
) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (field, out) = unsafe { (border::handle("field", field)?, Out::new("ground", ground)?) };
        let found = field.0.height_at(x, y).ok_or_else(|| {
            let message = format_args!("({x}, {y}) is in a hole or beyond the field: it has no ground there");
            Failure::new(Result::NotFound, message)
        })?;
        out.write(found);
        Ok(())
    })
}
