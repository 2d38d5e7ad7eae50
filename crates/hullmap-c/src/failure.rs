//! Failures: a code for the program, and a message for people, kept for each thread.

#![forbid(unsafe_code)]

use std::{cell::RefCell, ffi::c_char, fmt::Display};

use crate::types::Result as Code;

pub(crate) type Fallible<T> = std::result::Result<T, Failure>;

/// Why a call failed.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) code: Code,
    pub(crate) message: String,
}

impl Failure {
    #[cold]
    pub(crate) fn new(code: Code, message: impl Display) -> Self {
        // A hint for Rust.
        Self { code, message: message.to_string().replace(", or any kind with `Asset::open`", "") }
    }

    /// An argument is invalid: `name: error`.
    #[cold]
    pub(crate) fn argument(name: impl Display, error: impl Display) -> Self {
        Self::new(Code::InvalidArgument, format_args!("{name}: {error}"))
    }

    #[cold]
    pub(crate) fn unsupported(message: impl Display) -> Self {
        Self::new(Code::Unsupported, message)
    }

    /// The same failure, of the pair with this index in a batch.
    #[cold]
    pub(crate) fn of_pair(self, index: usize) -> Self {
        Self { message: format!("pairs[{index}]: {}", self.message), ..self }
    }

    /// Keeps the message for `hullmap_last_error`, and returns the code.
    #[cold]
    pub(crate) fn report(self) -> Code {
        LAST.with_borrow_mut(|last| write(last, &self.message));
        self.code
    }
}

/// Length of the longest message, with its terminator.
const CAPACITY: usize = 1024;

thread_local! {
    // Without a destructor, so that it works while a thread ends, and after `dlclose`.
    static LAST: RefCell<[u8; CAPACITY]> = const { RefCell::new([0; CAPACITY]) };
}

/// The last message of this thread, terminated; empty if no call has failed.
pub(crate) fn last() -> *const c_char {
    LAST.with(|last| last.as_ptr().cast_const().cast())
}

/// Writes `message` and its terminator. A message that is too long loses its start, because the
/// remedy is at the end.
fn write(last: &mut [u8; CAPACITY], message: &str) {
    let mut start = message.len().saturating_sub(CAPACITY - 1);
    while !message.is_char_boundary(start) {
        start += 1;
    }
    let bytes = message.as_bytes().get(start..).unwrap_or_default();
    for (to, from) in last.iter_mut().zip(bytes) {
        *to = if *from == 0 { b'?' } else { *from };
    }
    if let Some(end) = last.get_mut(bytes.len()) {
        *end = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(message: &str) -> String {
        let mut last = [7; CAPACITY];
        write(&mut last, message);
        std::ffi::CStr::from_bytes_until_nul(&last).unwrap().to_str().unwrap().to_owned()
    }

    #[test]
    fn messages_fit_and_keep_their_end() {
        for message in ["", "short", "schön"] {
            assert_eq!(written(message), message);
        }
        assert_eq!(written("a\0b"), "a?b");
        for filler in ["x", "ö", "面"] {
            for count in 300..1100 {
                let long = filler.repeat(count) + "; do this";
                let found = written(&long);
                assert!(found.ends_with("; do this") && long.ends_with(&found) && found.len() < CAPACITY);
                assert!(found.len() >= long.len().min(CAPACITY - 3));
            }
        }
    }
}
