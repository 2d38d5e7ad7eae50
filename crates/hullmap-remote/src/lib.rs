//! Client of the [Remote Execution API](https://github.com/bazelbuild/remote-apis), version 2.
//!
//! An [`ActionSpec`] describes a command line with its input files. [`ActionSpec::action`] turns it
//! into an [`Action`] with a digest, which depends on nothing else. [`Client`] looks the digest up
//! in the action cache, or uploads the inputs and lets a worker run the action, and fetches output
//! files.
//!
//! | module | concept |
//! |---|---|
//! | `digest` | SHA-256 and size, the name of a blob |
//! | `action` | commands and trees of input files as messages |
//! | `settings` | address, headers, limits |
//! | `client` | connection and retries |
//! | `strip_header` | strips a response header that makes the transport panic |
//! | `store` | the content-addressed store (CAS): which blobs are missing, upload, download |
//! | `execution` | the action cache, actions in progress, and how they are resumed |
//!
//! The server is not trusted: blobs are compared with their digests, sizes and counts are bounded,
//! and every wait has an end. Methods block, and may be called from several threads at once.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing))]

mod action;
mod client;
mod digest;
mod error;
mod execution;
mod settings;
mod store;
mod strip_header;

pub use action::{Action, ActionSpec, Blob, Data, InputFile};
pub use client::Client;
pub use digest::Digest;
pub use error::RemoteError;
pub use execution::{Outcome, OutputFile};
pub use settings::{Address, Identity, Settings};
