//! The file of a triangle mesh: a static shape with its triangles, such as a level or a terrain.
//!
//! The file has the header of a pack ([`crate::header`]) with a magic of its own, then an archive
//! of plain numbers. Triangles are in the order of the leaves of a tree of boxes, so that the tree
//! needs no pointers ([`tree`]).

pub mod archive;
pub mod check;
pub mod class;
pub mod sections;
pub mod tree;

/// File name extension of a triangle mesh, without the dot.
pub const EXTENSION: &str = "hullmesh";

/// Version of the format of triangle meshes that this crate writes and reads.
pub const FORMAT_VERSION: u32 = 1;

/// Maximum number of triangles: node numbers of the tree have 32 bits.
pub const MAX_TRIANGLES: usize = 1 << 28;
