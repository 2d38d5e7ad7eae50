//! Failures: a code for the program, and a message for people, kept for each thread.

#![forbid(unsafe_code)]

use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::fmt::Display;

use crate::types::Result as Code;

/// Why a call failed.
#[derive(Debug)]
pub struct Failure {
    /// The code.
    pub code: Code,
    /// The cause and the remedy.
    pub message: String,
}

impl Failure {
    /// A failure with this message.
    pub fn new(code: Code, message: impl Display) -> Self {
        Self { code, message: message.to_string() }
    }

    /// Keeps the message for `hullmap_decompose_last_error`, and returns the code.
    pub(crate) fn report(self) -> Code {
        let text = CString::new(self.message.replace('\0', "?")).unwrap_or_default();
        // A thread that ends has no message.
        let _ = LAST.try_with(|last| last.replace(text));
        self.code
    }
}

thread_local! {
    static LAST: RefCell<CString> = RefCell::new(CString::default());
}

/// The last message of this thread; empty if no call has failed.
pub(crate) fn last() -> *const c_char {
    LAST.try_with(|last| last.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}
