//! What the fuzz targets do with their bytes: here, so that the tests replay the kept inputs without libFuzzer.
//!
//! | function | bytes are | must hold |
//! |---|---|---|
//! | [`open_and_query`] | a pack, its header made right | it is refused, or every query ends soundly |
//! | [`solver`] | two shapes and how they lie | no NaN, caps held, intervals true by brute force |
//! | [`build_open_verify`] | point sets, an index, directions | what was baked opens and is exact |
//! | [`import`] | a format, options, a source file | points with their numbers in range, or a fault that names the file |
//!
//! Each panics where its claim fails. The bytes are read by [`bytes`], whose rules are our own, so that kept inputs keep their
//! meaning.

pub mod bytes;
mod packs;
mod pipeline;
pub mod seeds;
mod solver;
mod source_files;

pub use packs::{change_pack, open_and_query};
pub use pipeline::build_open_verify;
pub use solver::solver;
pub use source_files::import;

/// A target, by the name of its folder in the corpus.
pub type Target = (&'static str, fn(&[u8]));

/// All targets of this module.
pub const TARGETS: [Target; 4] = [
    ("open_and_query", open_and_query),
    ("solver", solver),
    ("build_open_verify", build_open_verify),
    ("import", import),
];
