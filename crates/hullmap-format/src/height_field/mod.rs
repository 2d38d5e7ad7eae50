//! The file of a height field: a static ground whose heights are known on a regular grid.
//!
//! The file has a pack's header ([`crate::header`]) with another magic, then an archive of plain
//! numbers. Triangles, their neighbours and the classes of edges and vertices follow from the grid.

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
