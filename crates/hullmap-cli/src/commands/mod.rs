//! The subcommands, one module each. Results go to the given writer, messages to standard error.

pub mod build;
pub mod completions;
pub mod decompose;
pub mod export;
pub mod init;
pub mod inspect;
pub mod key;
pub mod man;
pub mod plan;
pub mod query;
pub mod report;
pub mod robot;
pub mod status;
pub mod task;
pub mod verify;
