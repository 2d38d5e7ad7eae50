//! Code shared by the functions of triangle meshes and of height fields.
#![allow(unsafe_code)]

use std::ffi::c_char;
use std::path::PathBuf;

use hullmap::{InvalidPack, OpenError};

use super::pack::{native, not_opened};
use crate::border::{self, Out, call};
use crate::failure::{Failure, Fallible};
use crate::types::{MeshTriangle, Result};

/// Opens a file. `name` is the name of the argument `handle`.
///
/// # Safety
/// The caller keeps the rules at the head of the header.
pub(super) unsafe fn open<F, H: From<F>>(
    name: &str,
    path: *const c_char,
    handle: *mut *mut H,
    open: impl FnOnce(PathBuf) -> std::result::Result<F, OpenError>,
) -> Result {
    call(|| {
        // SAFETY: this function's contract is the same.
        let (out, path) = unsafe { (Out::of_handle(name, handle)?, border::text("path", path)?) };
        out.give(open(native(path)?).map_err(not_opened)?.into());
        Ok(())
    })
}

/// Opens the bytes of a file. `name` is the name of the argument `handle`.
///
/// # Safety
/// The caller keeps the rules at the head of the header.
pub(super) unsafe fn from_memory<F, H: From<F>>(
    name: &str,
    bytes: *const u8,
    length: usize,
    handle: *mut *mut H,
    open: impl FnOnce(&[u8]) -> std::result::Result<F, InvalidPack>,
) -> Result {
    call(|| {
        // SAFETY: this function's contract is the same. Nothing keeps a reference to the bytes
        // after this call.
        let (out, bytes) = unsafe { (Out::of_handle(name, handle)?, border::array("bytes", bytes, length)?) };
        out.give(open(bytes).map_err(|error| Failure::new(Result::InvalidPack, error))?.into());
        Ok(())
    })
}

/// A number of a handle; 0 for NULL. `name` is the name of the argument.
///
/// # Safety
/// The caller keeps the rules at the head of the header.
pub(super) unsafe fn count<H>(name: &str, handle: *const H, count: impl FnOnce(&H) -> usize) -> usize {
    let mut found = 0;
    call(|| {
        // SAFETY: this function's contract is the same.
        found = count(unsafe { border::handle(name, handle)? });
        Ok(())
    });
    found
}

/// Writes a triangle of a handle. `name` is the name of the argument; `find` returns the triangle,
/// or why there is none.
///
/// # Safety
/// The caller keeps the rules at the head of the header.
pub(super) unsafe fn triangle<H>(
    name: &str,
    handle: *const H,
    triangle: *mut MeshTriangle,
    find: impl FnOnce(&H) -> Fallible<MeshTriangle>,
) -> Result {
    call(|| {
        // SAFETY: this function's contract is the same.
        let (handle, out) = unsafe { (border::handle(name, handle)?, Out::new("triangle", triangle)?) };
        out.write(find(handle)?);
        Ok(())
    })
}

/// The failure for a triangle that does not exist.
#[cold]
pub(super) fn no_triangle(index: usize, owner: &str, count: usize) -> Failure {
    let message = if index < count {
        format!("triangle {index} is in a hole of the {owner}: skip it")
    } else {
        format!("triangle {index} is out of range: the {owner} has {count}")
    };
    Failure::new(Result::NotFound, message)
}
