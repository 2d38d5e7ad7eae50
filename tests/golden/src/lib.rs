//! Golden hashes: packs and answers are the same bits on every machine, in every build, on any
//! number of threads.
//!
//! The hashes stand in one file, [`FILE`], and are renewed by one command, `cargo run -p
//! hullmap-golden -- --renew`. Those of packs belong to a format version: baked bytes are a
//! function of source, options and version, so other bytes need another version.
//!
//! A package of its own with few dependencies, so that the small set of it also runs under Miri,
//! for 32 bits, other processors and other byte orders.
#![forbid(unsafe_code)]

pub mod answers;
pub mod bits;
pub mod golden;
pub mod packs;

/// The golden file, relative to this package.
pub const FILE: &str = "golden.txt";
