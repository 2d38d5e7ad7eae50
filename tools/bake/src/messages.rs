//! What goes to standard error: messages for people, never data.
//!
//! A closed standard error is no reason to end (`eprintln!` would panic): whoever closed it does not want to know.

use std::fmt::Display;
use std::io::{Write, stderr};

/// Something went wrong, or was found wanting.
pub fn error(message: impl Display) {
    say(format_args!("error: {message}"));
}

/// Something that the user may want to know.
pub fn note(message: impl Display) {
    say(format_args!("note: {message}"));
}

/// Something that the user should look at.
pub fn warning(message: impl Display) {
    say(format_args!("warning: {message}"));
}

/// A line as it is.
pub fn say(line: impl Display) {
    let _ = writeln!(stderr(), "{line}");
}
