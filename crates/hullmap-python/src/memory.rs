//! All unsafe code of this crate: maps of files, and NumPy arrays over the memory of a pack.
#![allow(unsafe_code)]

use std::path::Path;

use hullmap::{OpenError, Pack};
use numpy::ndarray::ArrayView2;
use numpy::{Element, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

/// Maps the file of a pack and checks it.
///
/// The user promises that no process writes to the file or truncates it while the pack is in use:
/// `hullmap.open` documents it, as `numpy.memmap` does, and has an argument that copies instead.
pub fn map(path: &Path) -> Result<Pack, OpenError> {
    // SAFETY: the promise above is the contract of `Pack::map`.
    unsafe { Pack::map(path) }
}

/// A read-only array over `numbers`, rows of `N`, which must be memory that `owner` keeps alive and
/// unchanged. The array keeps `owner` alive.
pub fn view<'py, T: Element, const N: usize>(owner: Bound<'py, PyAny>, numbers: &[[T; N]]) -> Bound<'py, PyArray2<T>> {
    let view = ArrayView2::from(numbers);
    // SAFETY: `owner` is a hull of a pack. It is immutable and holds the memory until it is
    // dropped, which is after the array. The array is made read-only before anyone else sees it,
    // and NumPy does not let users undo that: the base object exports no writable buffer.
    let array = unsafe { PyArray2::borrow_from_array(&view, owner) };
    drop(array.readwrite().make_nonwriteable());
    array
}
