//! Golden hashes: packs and answers are the same bits on every machine, in every build, on any
//! number of threads.
//!
//! The hashes are in one file, [`FILE`], and are renewed by one command, `cargo run -p
//! hullmap-golden -- --renew`. The hashes of packs belong to a format version: baked bytes are a
//! function of source, options and version, so different bytes require a new version.
//!
//! This is a separate package with few dependencies, so that its small set also runs under Miri,
//! for 32 bits, other processors and other byte orders.
#![forbid(unsafe_code)]

pub mod answers;
pub mod bits;
pub mod golden;
pub mod packs;

// It compiles the solver for the types of the answers, so that this package need not.
use hullmap_testkit as _;

/// The golden file, relative to this package.
pub const FILE: &str = "golden.txt";
