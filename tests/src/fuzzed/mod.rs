//! The code of the fuzz targets. It is in this library so that tests can replay the corpora without
//! libFuzzer.
//!
//! | function | bytes are | must hold |
//! |---|---|---|
//! | [`open_and_query`] | a pack; its header is corrected | it is rejected, or every query ends soundly |
//! | [`open_sheets`] | a triangle mesh and a height field; as above | as above |
//! | [`solver`] | two shapes and their poses | no NaN, no limit exceeded, intervals true by brute force |
//! | [`build_open_verify`] | point sets, an index, directions | the baked pack opens and is exact |
//! | [`import`] | a format, options, a source file | points with indices in range, or an error that names the file |
//!
//! Each panics if its requirement is violated. [`bytes`] defines how bytes are read, so that the
//! inputs of the corpora keep their meaning.

pub mod bytes;
mod corpus;
mod packs;
mod pipeline;
mod solver;
mod source_files;

pub use corpus::unpack;
pub use packs::{change_pack, open_and_query, open_sheets};
pub use pipeline::build_open_verify;
pub use solver::solver;
pub use source_files::import;

/// A target, by the name of its corpus.
pub type Target = (&'static str, fn(&[u8]));

/// All targets of this module.
pub const TARGETS: [Target; 5] = [
    ("open_and_query", open_and_query),
    ("solver", solver),
    ("build_open_verify", build_open_verify),
    ("import", import),
    ("open_sheets", open_sheets),
];
