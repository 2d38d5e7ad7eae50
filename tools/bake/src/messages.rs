//! Messages for people, on standard error. Data go to standard output.
//!
//! A closed standard error is ignored; `eprintln!` would panic.

use std::fmt::Display;
use std::io::{Write, stderr};

/// Prints an error.
pub fn error(message: impl Display) {
    say(format_args!("error: {message}"));
}

/// Prints a finding of interest.
pub fn note(message: impl Display) {
    say(format_args!("note: {message}"));
}

/// Prints a finding to act on.
pub fn warning(message: impl Display) {
    say(format_args!("warning: {message}"));
}

/// Prints a line as it is.
pub fn say(line: impl Display) {
    let _ = writeln!(stderr(), "{line}");
}
