//! How a command ends: exit codes and the error that ends one early.

use std::fmt;
use std::process::ExitCode;

/// The exit codes. The greater one wins where several inputs end differently.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Exit {
    /// Done, and nothing was found wrong.
    Done = 0,
    /// An input was judged and found wanting.
    Wanting = 1,
    /// Wrong usage, or something could not be read or written.
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
    /// What happened, to which file, and what to do next; empty where nobody is left to read it.
    pub message: String,
}

impl Failure {
    /// Wrong usage, or a file that cannot be read or written.
    pub fn usage(message: impl Into<String>) -> Self {
        Self { exit: Exit::Usage, message: message.into() }
    }

    /// An input that was judged and found wanting.
    pub fn wanting(message: impl Into<String>) -> Self {
        Self { exit: Exit::Wanting, message: message.into() }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

/// Writing to standard output failed. A reader that has gone away (`bake … | head`) has all it wanted: that ends the
/// command quietly and well.
impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        match error.kind() {
            std::io::ErrorKind::BrokenPipe => Self { exit: Exit::Done, message: String::new() },
            _ => Self::usage(format!("cannot write the results: {error}")),
        }
    }
}

/// The result of a command that ends with `exit` once `written` tells that its answer is out. A reader that has gone away
/// changes nothing about how the work itself ended.
///
/// # Errors
/// The answer could not be written.
pub fn end(exit: Exit, written: Result<(), Failure>) -> Result<Exit, Failure> {
    match written {
        Err(failure) if !failure.message.is_empty() => Err(failure),
        _ => Ok(exit),
    }
}
