//! Exit codes of a command, and the error that ends it early.

use std::fmt;
use std::process::ExitCode;

/// The exit codes. If several inputs end differently, the highest code is returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Exit {
    /// Success.
    Done = 0,
    /// An input was rejected.
    Rejected = 1,
    /// Wrong usage, or a file could not be read or written.
    Usage = 2,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(exit as u8)
    }
}

/// Why a command ended early.
#[derive(Debug)]
pub struct Failure {
    /// The code to exit with.
    pub exit: Exit,
    /// What is wrong, with which file, and what to do; empty if standard output has no reader.
    pub message: String,
}

impl Failure {
    /// Wrong usage, or a file that cannot be read or written.
    pub fn usage(message: impl Into<String>) -> Self {
        Self { exit: Exit::Usage, message: message.into() }
    }

    /// A rejected input.
    pub fn rejected(message: impl Into<String>) -> Self {
        Self { exit: Exit::Rejected, message: message.into() }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

/// Writing to standard output failed. A closed pipe (`bake … | head`) ends the command silently and
/// successfully.
impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        match error.kind() {
            std::io::ErrorKind::BrokenPipe => Self { exit: Exit::Done, message: String::new() },
            _ => Self::usage(format!("cannot write the results: {error}")),
        }
    }
}

/// The result of a command that ends with `exit` after its output was `written`. A closed pipe does
/// not change `exit`. Fails if the output could not be written.
pub fn end(exit: Exit, written: Result<(), Failure>) -> Result<Exit, Failure> {
    match written {
        Err(failure) if !failure.message.is_empty() => Err(failure),
        _ => Ok(exit),
    }
}
