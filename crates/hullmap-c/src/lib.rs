//! C interface of [`hullmap`]: handles, plain structs and error codes.
//!
//! Programs in C and C++ use the header `include/hullmap.h`, which is generated from this crate,
//! and `include/hullmap.hpp`, a thin layer of C++ on top of it. The README of the crate says how to
//! install them. Programs in Rust use [`hullmap`] itself.
//!
//! | module | what |
//! |---|---|
//! | `types` | structs and enums of the header |
//! | `exports` | the exported functions: they check pointers, and call the modules below |
//! | `border` | pointers and panics at the border |
//! | `failure` | error codes, and the message of the last error |
//! | `handles` | packs, shapes, caches and manifolds behind opaque pointers |
//! | `query` | a query of two shapes of any kind |
//! | `batch` | many pairs on all cores |
#![deny(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing))]

mod batch;
mod border;
pub mod exports;
mod failure;
pub mod handles;
mod query;
#[cfg(test)]
mod tests;
pub mod types;
