//! Errors: file, line, cause and remedy.

use std::fmt;
use std::path::{Path, PathBuf};

/// Why a description was not read or not edited.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotError {
    /// The faulty file.
    pub file: PathBuf,
    /// The line in it, from 1; `None` if the whole file is meant.
    pub line: Option<u32>,
    /// The cause, and what to do.
    pub message: String,
    /// Whether the file could not be read, rather than being rejected.
    pub is_unreadable: bool,
}

impl RobotError {
    pub(crate) fn rejected(file: &Path, line: Option<u32>, message: impl Into<String>) -> Self {
        Self { file: file.to_owned(), line, message: message.into(), is_unreadable: false }
    }

    pub(crate) fn unreadable(file: &Path, message: impl Into<String>) -> Self {
        Self { file: file.to_owned(), line: None, message: message.into(), is_unreadable: true }
    }
}

impl fmt::Display for RobotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.file.display(), self.message),
            None => write!(f, "{}: {}", self.file.display(), self.message),
        }
    }
}

impl std::error::Error for RobotError {}
