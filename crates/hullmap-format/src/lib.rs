//! What is on disk in a `.hullmap` pack, and nothing else: the one place that both the baker (which writes) and the
//! runtime (which reads) look at, so that neither sees the other.
//!
//! | module | concept |
//! |---|---|
//! | [`header`] | the fixed 64 bytes in front: magic, version, length, hashes, checksum |
//! | [`archive`] | the rkyv types behind it: plain vectors of plain numbers |
//! | [`cube`] | direction ↔ cell of the cube map |
//! | [`slot`] | the words of a direction index |
//! | [`bvh`] | the tree of bounding boxes over a pack's hulls |
//! | [`walk`] | one pass over an index: is it well formed, and what does a query cost at worst |
//! | [`check`] | whether a file keeps the promises that the runtime relies on |
//! | [`repeats`] | whether what a file holds twice agrees |
//!
//! `docs/FORMAT.md` describes the same byte by byte.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing))]

pub mod archive;
pub mod bvh;
pub mod check;
pub mod cube;
pub mod edge;
pub mod fan;
pub mod header;
pub mod repeats;
pub mod slot;
pub mod walk;

/// File name extension of a pack, without the dot.
pub const EXTENSION: &str = "hullmap";

/// Version of the format that this crate writes and reads.
///
/// Any change to the bytes, or to what they mean, raises it; `docs/FORMAT.md` keeps the history.
pub const FORMAT_VERSION: u32 = 3;
