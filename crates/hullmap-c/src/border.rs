//! The boundary to C: turns pointers into values, copies answers out, and turns panics into result
//! codes.
//!
//! A pointer from C can be checked for NULL and alignment, not for what it points to. So each
//! function here is unsafe, and its contract is the part of the header's rules that the caller in C
//! has to keep: the memory is there, is initialised where it is read, and no other thread writes to
//! it during the call. Input is copied at once, and answers are written at the end, so that
//! an answer may overlap an argument.
#![allow(unsafe_code)]

use std::{
    any::Any,
    ffi::{CStr, c_char},
    mem::MaybeUninit,
    panic::{AssertUnwindSafe, catch_unwind},
    slice,
};

use crate::{
    failure::{Failure, Fallible},
    types::Result as Code,
};

/// Runs a call: a failure or a panic becomes a code and a message.
#[inline(always)]
pub(crate) fn call(body: impl FnOnce() -> Fallible<()>) -> Code {
    match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(())) => Code::Ok,
        Ok(Err(failure)) => failure.report(),
        Err(payload) => panicked(payload).report(),
    }
}

#[cold]
fn panicked(payload: Box<dyn Any + Send>) -> Failure {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("no message");
    let failure = Failure::new(Code::Panic, format_args!("bug in hullmap: {text}; please report it"));
    // The destructor of any other type could panic in turn.
    if !payload.is::<String>() && !payload.is::<&str>() {
        std::mem::forget(payload);
    }
    failure
}

/// Checks that `pointer` is neither NULL nor misaligned.
#[inline(always)]
fn checked<T>(name: &str, pointer: *const T) -> Fallible<()> {
    if pointer.is_null() {
        return Err(null(name));
    }
    if !pointer.is_aligned() {
        return Err(misaligned(name, align_of::<T>()));
    }
    Ok(())
}

#[cold]
fn null(name: &str) -> Failure {
    Failure::new(Code::Null, format_args!("{name} is NULL"))
}

#[cold]
fn misaligned(name: &str, alignment: usize) -> Failure {
    Failure::argument(name, format_args!("the pointer is not aligned to {alignment} bytes"))
}

/// A handle.
///
/// # Safety
/// If not NULL, `pointer` is a handle of this library that is not freed during `'a`.
#[inline(always)]
pub(crate) unsafe fn handle<'a, T>(name: &str, pointer: *const T) -> Fallible<&'a T> {
    checked(name, pointer)?;
    // SAFETY: it is not NULL, and a live handle by this function's contract. Handles are shared
    // between threads as `&T` only.
    Ok(unsafe { &*pointer })
}

/// A handle, or NULL.
///
/// # Safety
/// As [`handle`].
#[inline(always)]
pub(crate) unsafe fn optional_handle<'a, T>(name: &str, pointer: *const T) -> Fallible<Option<&'a T>> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: this function's contract is the contract of `handle`.
    unsafe { handle(name, pointer) }.map(Some)
}

/// A copy of a struct.
///
/// # Safety
/// If not NULL, `pointer` points to a `T` that is initialised, and that no thread writes to during
/// the call.
#[inline(always)]
pub(crate) unsafe fn read<T: Copy>(name: &str, pointer: *const T) -> Fallible<T> {
    checked(name, pointer)?;
    // SAFETY: it is not NULL and aligned, and readable by this function's contract.
    Ok(unsafe { pointer.read() })
}

/// A copy of a struct that starts with its own size, or `None` for NULL.
///
/// # Safety
/// As [`read`], but only as many bytes need to be there as the struct states, at least a `usize`.
#[inline(always)]
pub(crate) unsafe fn read_sized<T: Copy>(name: &str, pointer: *const T) -> Fallible<Option<T>> {
    if pointer.is_null() {
        return Ok(None);
    }
    checked(name, pointer)?;
    // SAFETY: the size is there by this function's contract, and is aligned, since `T` starts with
    // a `usize`.
    let found = unsafe { pointer.cast::<usize>().read() };
    // Versions that add fields will accept the size that this one has.
    if found != size_of::<T>() {
        return Err(wrong_size(name, found, size_of::<T>()));
    }
    // SAFETY: all of its bytes are there, and are initialised, by this function's contract.
    Ok(Some(unsafe { pointer.read() }))
}

/// Checks the size that the caller has written into an answer.
///
/// # Safety
/// If not NULL, `pointer` points to an initialised `usize`.
pub(crate) unsafe fn check_size<T>(name: &str, pointer: *const T) -> Fallible<()> {
    checked(name, pointer)?;
    // SAFETY: the size is there by this function's contract, and is aligned, since `T` starts with
    // a `usize`.
    let found = unsafe { pointer.cast::<usize>().read() };
    if found == size_of::<T>() { Ok(()) } else { Err(wrong_size(name, found, size_of::<T>())) }
}

#[cold]
fn wrong_size(name: &str, found: usize, expected: usize) -> Failure {
    let message = format_args!(
        "struct_size is {found}, but this version of the library has {expected}: set it with sizeof, and use the \
         header of the library"
    );
    Failure::argument(name, message)
}

/// An array. NULL is allowed if it is empty.
///
/// # Safety
/// If not empty, `pointer` points to `count` initialised elements that no thread writes to during
/// `'a`.
#[inline(always)]
pub(crate) unsafe fn array<'a, T>(name: &str, pointer: *const T, count: usize) -> Fallible<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    checked(name, pointer)?;
    check_count::<T>(name, count)?;
    // SAFETY: it is not NULL, aligned, and readable by this function's contract; its size in bytes
    // is at most `isize::MAX`.
    Ok(unsafe { slice::from_raw_parts(pointer, count) })
}

/// An array of answers, which need not be initialised. NULL is allowed if it is empty.
///
/// # Safety
/// If not empty, `pointer` points to memory for `count` elements, which nothing else reads or
/// writes during `'a`.
#[inline(always)]
pub(crate) unsafe fn answers<'a, T>(name: &str, pointer: *mut T, count: usize) -> Fallible<&'a mut [MaybeUninit<T>]> {
    if count == 0 {
        return Ok(&mut []);
    }
    checked(name, pointer)?;
    check_count::<T>(name, count)?;
    // SAFETY: it is not NULL, aligned, and exclusive by this function's contract; its size in bytes
    // is at most `isize::MAX`. Any bytes are a valid `MaybeUninit`.
    Ok(unsafe { slice::from_raw_parts_mut(pointer.cast(), count) })
}

fn check_count<T>(name: &str, count: usize) -> Fallible<()> {
    let limit = isize::MAX.unsigned_abs() / size_of::<T>().max(1);
    if count <= limit {
        return Ok(());
    }
    Err(Failure::argument(name, format_args!("{count} elements do not fit into memory: check the count")))
}

/// A text that ends with NUL.
///
/// # Safety
/// If not NULL, `pointer` points to bytes that end with NUL, and that no thread writes to during
/// `'a`.
pub(crate) unsafe fn text<'a>(name: &str, pointer: *const c_char) -> Fallible<&'a CStr> {
    checked(name, pointer)?;
    // SAFETY: it is not NULL, and ends with NUL by this function's contract.
    Ok(unsafe { CStr::from_ptr(pointer) })
}

/// Where an answer goes.
pub(crate) struct Out<T>(*mut T);

impl<T> Out<T> {
    /// # Safety
    /// If not NULL, `pointer` points to memory for a `T`, which no other thread accesses during the
    /// call.
    #[inline(always)]
    pub(crate) unsafe fn new(name: &str, pointer: *mut T) -> Fallible<Self> {
        checked(name, pointer)?;
        Ok(Self(pointer))
    }

    #[inline(always)]
    pub(crate) fn write(self, answer: T) {
        // SAFETY: `new` has checked the pointer, and its contract promises the memory.
        // The old value is not dropped, since it may be uninitialised.
        unsafe { self.0.write(answer) }
    }
}

impl<T> Out<*mut T> {
    /// Where a handle goes; NULL is written at once, so that a failed call leaves NULL behind.
    ///
    /// # Safety
    /// As [`Out::new`].
    pub(crate) unsafe fn of_handle(name: &str, pointer: *mut *mut T) -> Fallible<Self> {
        checked(name, pointer)?;
        // SAFETY: it is not NULL and aligned, and writable by this function's contract.
        unsafe { pointer.write(std::ptr::null_mut()) };
        Ok(Self(pointer))
    }

    pub(crate) fn give(self, handle: T) {
        self.write(Box::into_raw(Box::new(handle)));
    }
}

/// Frees a handle; NULL is allowed.
///
/// # Safety
/// If not NULL, `pointer` is from [`Out::give`], is not freed yet, and no other call uses it.
pub(crate) unsafe fn free<T>(pointer: *mut T) {
    if !pointer.is_null() {
        // SAFETY: it is from `Box::into_raw`, and nothing else uses it, by this function's
        // contract.
        let handle = unsafe { Box::from_raw(pointer) };
        // Destructors of handles do not panic. If one did, C could not do anything about it.
        call(|| {
            drop(handle);
            Ok(())
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_a_code() {
        assert_eq!(call(|| panic!("no {}", 1)), Code::Panic);
        // SAFETY: the message ends with NUL, and lives until the next failure of this thread.
        let message = unsafe { CStr::from_ptr(crate::failure::last()) }.to_str().unwrap();
        assert_eq!(message, "bug in hullmap: no 1; please report it");

        struct Bomb;
        impl Drop for Bomb {
            fn drop(&mut self) {
                panic!("again");
            }
        }
        assert_eq!(call(|| std::panic::panic_any(Bomb)), Code::Panic);
        assert_eq!(call(|| Ok(())), Code::Ok);
    }
}
