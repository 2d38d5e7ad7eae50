//! Files, folders and processes that tests use outside of their own process, and clocks.
//!
//! | module | contents |
//! |---|---|
//! | [`clock`] | processor time |
//! | [`command`] | the `bake` command, built and run; cargo |
//! | [`files`] | the workspace's folder, files in a folder, inputs named by environment variables |
//!
//! It depends on no crate of the product, so that tests of rules compile in seconds.

#![forbid(unsafe_code)]

pub mod clock;
pub mod command;
pub mod files;
