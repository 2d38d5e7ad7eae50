//! Exceptions: one class for each kind of wrong input, all of them `hullmap.Error`.
#![allow(missing_docs, reason = "the macro's types; their documentation is the last argument")]

use hullmap::OpenError;
use pyo3::exceptions::{PyOSError, PyUserWarning, PyValueError};
use pyo3::prelude::*;

pyo3::create_exception!(hullmap, Error, PyValueError, "Wrong input. The base of all exceptions of hullmap.");
pyo3::create_exception!(hullmap, ArrayError, Error, "An array has a wrong shape, type or value.");
pyo3::create_exception!(hullmap, PoseError, Error, "Numbers are not a rigid pose.");
pyo3::create_exception!(hullmap, ShapeError, Error, "A shape cannot be made, or cannot be queried this way.");
pyo3::create_exception!(hullmap, BakeError, Error, "A mesh cannot be baked, or an option is wrong.");
pyo3::create_exception!(hullmap, InvalidPack, Error, "A file is not a pack, or is damaged.");
pyo3::create_exception!(hullmap, BakeWarning, PyUserWarning, "A finding of a bake to act on.");

/// `InvalidPack` for a bad file; `FileNotFoundError` and its kin for one that cannot be read.
pub fn of_open(error: OpenError) -> PyErr {
    match error {
        OpenError::Io { ref cause, .. } => of_io(cause, error.to_string()),
        OpenError::Invalid { .. } => InvalidPack::new_err(error.to_string()),
    }
}

/// The subclass of `OSError` for `error`, with this message.
pub fn of_io(error: &std::io::Error, message: String) -> PyErr {
    match error.raw_os_error() {
        // Python chooses the subclass by the number, and prints it before the message.
        Some(number) => PyOSError::new_err((number, message.replace(&format!(" (os error {number})"), ""))),
        None => PyErr::from(std::io::Error::new(error.kind(), message)),
    }
}
