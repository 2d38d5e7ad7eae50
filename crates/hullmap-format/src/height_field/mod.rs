//! The file of a height field: a static ground whose heights are known on a regular grid.
//!
//! The file has the header of a pack ([`crate::header`]) with a magic of its own, then an archive
//! of plain numbers. Triangles are not stored: they follow from the grid, and so do their
//! neighbours and the classes of edges and vertices.
//!
//! | module | concept |
//! |---|---|
//! | [`archive`] | the rkyv types after the header |
//! | [`layout`] | where the vertices are, and which triangles the cells have |
//! | [`pyramid`] | the tree of height ranges: which cells a node has |
//! | [`ranges`] | the least and the greatest height below each node |
//! | [`sections`] | the archive as slices, each bounds-checked |
//! | [`check`] | whether a file meets the requirements that the runtime relies on |

pub mod archive;
pub mod check;
pub mod layout;
pub mod pyramid;
pub mod ranges;
pub mod sections;

/// File name extension of a height field, without the dot.
pub const EXTENSION: &str = "hullfield";

/// Version of the format of height fields that this crate writes and reads.
pub const FORMAT_VERSION: u32 = 1;

/// Maximum number of cells: triangles and nodes of the tree have 32-bit numbers.
pub const MAX_CELLS: usize = 1 << 27;
