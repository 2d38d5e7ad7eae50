//! Exit codes of a command, and the error that ends it early.

use std::fmt;
use std::process::ExitCode;

/// The exit codes. If several inputs end differently, the highest code is returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Exit {
    Done = 0,
    Rejected = 1,
    Usage = 2,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(exit as u8)
    }
}

#[derive(Clone, Debug)]
pub struct Failure {
    pub exit: Exit,
    /// The fault, the file and the remedy; empty if standard output has no reader.
    pub message: String,
}

impl Failure {
    pub fn usage(message: impl Into<String>) -> Self {
        Self { exit: Exit::Usage, message: message.into() }
    }

    pub fn rejected(message: impl Into<String>) -> Self {
        Self { exit: Exit::Rejected, message: message.into() }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

/// A closed pipe (`bake … | head`) ends the command silently and successfully.
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
