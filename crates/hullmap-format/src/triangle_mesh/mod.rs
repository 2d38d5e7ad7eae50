//! The file of a triangle mesh: a static shape with its triangles, such as a level or a terrain.
//!
//! The file has the header of a pack ([`crate::header`]) with a magic of its own, then an archive
//! of plain numbers. Triangles are in the order of the leaves of a tree of boxes, so that the tree
//! needs no pointers ([`tree`]).
//!
//! | module | concept |
//! |---|---|
//! | [`archive`] | the rkyv types after the header |
//! | [`class`] | what an edge or a vertex is: border, flat, convex, concave, … |
//! | [`tree`] | the boxes: which triangles a node has, and the numbers of its box |
//! | [`sections`] | the archive as slices, each bounds-checked |
//! | [`check`] | whether a file meets the requirements that the runtime relies on |

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
