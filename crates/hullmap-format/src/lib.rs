//! The file format of a `.hullmap` pack. The baker, which writes packs, and the runtime, which
//! reads them, both depend on this crate. Neither depends on the other.
//!
//! | module | concept |
//! |---|---|
//! | [`header`] | the first 64 bytes: magic, version, length, hashes, checksum |
//! | [`archive`] | the rkyv types after the header: vectors of plain numbers |
//! | [`quad`] | the four corners that stand for a face of many corners |
//! | [`cube`] | direction ↔ cell of the cube map |
//! | [`index_kind`] | the kinds of direction index: names, codes, leaf sizes |
//! | [`solid_kind`] | what counts as the inside of a mesh |
//! | [`mass`] | whether the recorded mass of a mesh can be the mass of a solid |
//! | [`voids`] | whether the recorded voids of parts can be true |
//! | [`primitive`], [`primitive_kind`] | primitives that may replace parts |
//! | [`version`] | the versions of the format |
//! | [`slot`] | the words of a direction index |
//! | [`node`] | the nodes of a direction index: positions of their numbers and slots |
//! | [`bvh`] | the tree of bounding boxes over a pack's hulls |
//! | [`walk`] | one pass over an index: whether it is well formed, and the worst cost of a query |
//! | [`sections`] | the archive as slices, each bounds-checked |
//! | [`check`] | whether a file meets the requirements that the runtime relies on |
//! | [`repeats`] | whether redundant values of a file agree |
//! | [`triangle_mesh`] | another kind of file: a static mesh that keeps its triangles |
//! | [`height_field`] | a third kind: static ground whose heights are on a grid |
//! | [`scale`] | coordinates between two bounds as numbers of 16 bits |
//!
//! `docs/contributors/FORMAT.md` describes the format byte by byte.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing))]

mod adjacency;
pub mod archive;
pub mod bvh;
pub mod check;
mod check_error;
pub mod cube;
mod cutter;
pub mod descent;
pub mod edge;
pub mod fan;
pub mod header;
pub mod height_field;
mod hull_check;
pub mod index_kind;
pub mod mass;
pub mod node;
pub mod primitive;
pub mod primitive_kind;
pub mod quad;
pub mod repeats;
pub mod scale;
pub mod sections;
pub mod slot;
pub mod solid_kind;
pub mod triangle_mesh;
pub mod version;
pub mod voids;
pub mod walk;

pub use index_kind::IndexKind;
pub use primitive_kind::PrimitiveKind;
pub use solid_kind::SolidKind;
pub use version::{FORMAT_VERSION, LEAN_FORMAT_VERSION};

/// File name extension of a pack, without the dot.
pub const EXTENSION: &str = "hullmap";
