//! C interface of hullmap's convex decomposition, for programs that have meshes in memory and need
//! no packs.
//!
//! Programs in C and C++ use the header `include/hullmap_decompose.h`, which is generated from this
//! crate. `include/hullmap_vhacd.hpp` has the class and the names of V-HACD on top of it.
//!
//! | module | what |
//! |---|---|
//! | `types` | structs and enums of the header |
//! | `exports` | the exported functions: they check pointers, and turn panics into codes |
//! | `decomposition` | from arrays to parts, without pointers |
//! | `failure` | error codes, and the message of the last error |
#![deny(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing))]

pub mod decomposition;
pub mod exports;
mod failure;
pub mod types;
