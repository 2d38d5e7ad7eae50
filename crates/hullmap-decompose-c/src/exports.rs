//! The exported functions: they copy and check their arguments, call the safe modules, and write
//! the answer. No panic crosses this border.
//!
//! A pointer from C can be checked for NULL and alignment, not for its target. The rules for
//! callers are at the head of the header (`cbindgen.toml`).
#![allow(unsafe_code)]
#![allow(clippy::missing_safety_doc, reason = "the rules are at the head of the header")]

use std::ffi::c_char;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;
use std::slice;

use hullmap_bake::progress::Progress as Shared;

use crate::decomposition::{self, Decomposition};
use crate::failure::{self, Failure};
use crate::types::{self, Facts, Options, Part, Result as Code};

/// Progress of a decomposition, which another thread may read, and by which it may cancel.
#[derive(Debug, Default)]
pub struct Progress(Shared);

/// Runs a call: a failure or a panic becomes a code and a message.
fn call(body: impl FnOnce() -> Result<(), Failure>) -> Code {
    match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(())) => Code::Ok,
        Ok(Err(failure)) => failure.report(),
        Err(payload) => {
            // The destructor of an unknown type could panic in turn.
            std::mem::forget(payload);
            Failure::new(Code::Panic, "bug in hullmap; please report it, with the mesh").report()
        }
    }
}

/// Checks that a pointer is neither NULL nor misaligned.
fn checked<T>(name: &str, pointer: *const T) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::new(Code::Null, format_args!("{name} is NULL")));
    }
    if !pointer.is_aligned() {
        let text = format_args!("{name}: the pointer is not aligned to {} bytes", align_of::<T>());
        return Err(Failure::new(Code::InvalidArgument, text));
    }
    Ok(())
}

/// An array of triples of numbers, as a slice.
///
/// # Safety
/// If `pointer` is not NULL, `count` triples of initialised numbers are there, and no thread writes
/// to them during the call.
unsafe fn triples<'a, T>(name: &str, pointer: *const T, count: usize) -> Result<&'a [[T; 3]], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    checked(name, pointer)?;
    if count > isize::MAX as usize / size_of::<[T; 3]>() {
        return Err(Failure::new(Code::InvalidArgument, format_args!("{name}: {count} is more than memory can hold")));
    }
    // SAFETY: the pointer is neither NULL nor misaligned, the length is in the range of an object,
    // and the memory is there by this function's contract. An array has the alignment of its items.
    Ok(unsafe { slice::from_raw_parts(pointer.cast(), count) })
}

/// Checks the size that the caller has written into a struct.
///
/// # Safety
/// If `pointer` is not NULL, it points to an initialised `usize`.
unsafe fn check_size<T>(name: &str, pointer: *const T) -> Result<(), Failure> {
    checked(name, pointer)?;
    // SAFETY: the size is there by this function's contract, and `T` starts with a `usize`.
    let found = unsafe { pointer.cast::<usize>().read() };
    if found == size_of::<T>() {
        return Ok(());
    }
    let expected = size_of::<T>();
    let text = format_args!("{name}.struct_size: expected {expected}, found {found}; use the header of this version");
    Err(Failure::new(Code::InvalidArgument, text))
}

/// Message of the last call that failed on this thread: what went wrong and what to do, in UTF-8;
/// "" if no call has failed. Valid until the next failure on this thread.
#[unsafe(no_mangle)]
pub extern "C" fn hullmap_decompose_last_error() -> *const c_char {
    failure::last()
}

/// Makes a progress, to be freed by hullmap_decompose_progress_free().
#[unsafe(no_mangle)]
pub extern "C" fn hullmap_decompose_progress_new() -> *mut Progress {
    Box::into_raw(Box::default())
}

/// The share that is done, from 0 to 1. It never decreases. 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_decompose_progress_share(progress: *const Progress) -> f64 {
    // SAFETY: it is NULL or a live handle, by the rules for callers.
    unsafe { progress.as_ref() }.map_or(0.0, |progress| progress.0.share())
}

/// Asks the decomposition to end soon with HULLMAP_DECOMPOSE_RESULT_CANCELLED. Does nothing for
/// NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_decompose_progress_cancel(progress: *const Progress) {
    // SAFETY: it is NULL or a live handle, by the rules for callers.
    if let Some(progress) = unsafe { progress.as_ref() } {
        progress.0.cancel();
    }
}

/// Frees a progress that no call uses. Does nothing for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_decompose_progress_free(progress: *mut Progress) {
    if !progress.is_null() {
        // SAFETY: it was made by `hullmap_decompose_progress_new`, and is freed once, by the rules.
        drop(unsafe { Box::from_raw(progress) });
    }
}

/// Decomposes a mesh into convex parts.
///
/// points has three coordinates for each of point_count points, and triangles three indices of
/// points for each of triangle_count triangles. options may be NULL, for the defaults, and so may
/// progress. On success, *out is a decomposition, to be freed by hullmap_decomposition_free(); on
/// failure, it is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_decompose(
    points: *const f64,
    point_count: usize,
    triangles: *const u32,
    triangle_count: usize,
    options: *const Options,
    progress: *const Progress,
    out: *mut *mut Decomposition,
) -> types::Result {
    call(|| {
        checked("out", out)?;
        // SAFETY: it is neither NULL nor misaligned, and writable by the rules for callers.
        unsafe { out.write(ptr::null_mut()) };
        let options = if options.is_null() {
            None
        } else {
            // SAFETY: it is not NULL, so that its size is there, by the rules for callers.
            unsafe { check_size("options", options) }?;
            // SAFETY: it is aligned, and as large as its size says, which was checked.
            Some(unsafe { options.read() })
        };
        // SAFETY: the arrays have these lengths, by the rules for callers.
        let (points, triangles) =
            unsafe { (triples("points", points, point_count)?, triples("triangles", triangles, triangle_count)?) };
        // SAFETY: it is NULL or a live handle, by the rules for callers.
        let progress = unsafe { progress.as_ref() }.map(|progress| &progress.0);
        let found = Box::new(decomposition::decompose(points, triangles, options, progress)?);
        // SAFETY: as above.
        unsafe { out.write(Box::into_raw(found)) };
        Ok(())
    })
}

/// Writes facts about a decomposition to *out. The caller sets out->struct_size first.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_decomposition_facts(
    decomposition: *const Decomposition,
    out: *mut Facts,
) -> types::Result {
    call(|| {
        checked("decomposition", decomposition)?;
        // SAFETY: if it is not NULL, its size is there, by the rules for callers.
        unsafe { check_size("out", out) }?;
        // SAFETY: the handle is live by the rules for callers.
        let facts = unsafe { &*decomposition }.facts();
        // SAFETY: it is neither NULL nor misaligned, and as large as its size says.
        unsafe { out.write(facts) };
        Ok(())
    })
}

/// Writes the part with this index to *out. Its arrays are valid until the decomposition is freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_decomposition_part(
    decomposition: *const Decomposition,
    index: usize,
    out: *mut Part,
) -> types::Result {
    call(|| {
        checked("decomposition", decomposition)?;
        checked("out", out)?;
        // SAFETY: the handle is live by the rules for callers.
        let found = unsafe { &*decomposition };
        let count = found.facts().part_count;
        let part = found.part(index).ok_or_else(|| {
            Failure::new(Code::InvalidArgument, format_args!("index: {index} is out of range, of {count} parts"))
        })?;
        // SAFETY: it is neither NULL nor misaligned, and writable by the rules for callers.
        unsafe { out.write(part) };
        Ok(())
    })
}

/// Frees a decomposition. Does nothing for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_decomposition_free(decomposition: *mut Decomposition) {
    if !decomposition.is_null() {
        // SAFETY: it was made by `hullmap_decompose`, and is freed once, by the rules for callers.
        drop(unsafe { Box::from_raw(decomposition) });
    }
}
