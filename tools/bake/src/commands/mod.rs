//! The subcommands, one module each. Results go to the given writer, messages to standard error.

pub mod build;
pub mod completions;
pub mod export;
pub mod init;
pub mod inspect;
pub mod query;
pub mod report;
pub mod verify;
