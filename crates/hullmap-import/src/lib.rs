//! Import of OBJ, glTF, GLB, STL, PLY, COLLADA and MSH files: from the bytes of a file to the point
//! sets of hulls. Each point keeps the index of its vertex in the file.
//!
//! 1. [`read()`] loads the file, and the buffers beside a glTF file. `foreign` rejects other
//!    formats.
//! 2. `obj`, `gltf`, `stl`, `ply`, `collada` or `msh` parses it into a source `mesh`, within
//!    `limits`.
//! 3. `point_sets` selects the points and splits them by object (with `--split auto` by
//!    `conventions`). `placement` rotates, scales and recentres them.
//! 4. `far` warns about points too far from the origin for the precision of `f32`.
//!
//! | format | vertices, in index order | objects | materials of faces |
//! |---|---|---|---|
//! | OBJ | `v` lines | `o` lines | `usemtl` lines |
//! | glTF, GLB | positions of each instance, node by node | nodes with a mesh | of primitives |
//! | STL | distinct positions, by first appearance | `solid`s | none |
//! | PLY | instances of the element `vertex` | the file | none |
//! | COLLADA | positions of each instance, node by node | instances of geometries | not read |
//! | MSH | vertices | the file | none |
//!
//! Heights on a grid have readers of their own: [`height_field`].
//!
//! ```
//! use std::path::Path;
//! use hullmap_import::{ImportOptions, Limits, SourceFile, import};
//!
//! let source = SourceFile::alone(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9\nf 1 2 3\n".to_vec());
//! let options = ImportOptions::DEFAULT;
//! let imported = import("a.obj", "a", Path::new("a.obj"), &source, &options, &Limits::DEFAULT)?;
//! assert_eq!(imported.point_sets[0].source_vertices, [0, 1, 2]);
//! assert_eq!(imported.unreferenced_count, 1);
//! # Ok::<(), hullmap_import::ImportError>(())
//! ```

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing))]

mod arrays;
mod collada;
mod conventions;
mod coordinate;
mod ears;
mod encoding;
mod far;
mod fault;
mod foreign;
mod format;
mod gltf;
pub mod height_field;
mod import;
mod limits;
mod materials;
mod mesh;
mod msh;
mod obj;
mod options;
mod placement;
mod ply;
mod point_sets;
mod read;
mod scene_objects;
mod stl;
#[cfg(test)]
mod tests;
mod tokens;

pub use arrays::{MeshArrays, import_arrays};
pub use far::far_away;
pub use fault::ImportError;
pub use foreign::unread_format;
pub use format::{EXTENSIONS, NAMES, is_buffer, is_in_metres, is_source, is_y_up};
pub use import::{Imported, import};
pub use limits::Limits;
pub use materials::Materials;
pub use mesh::Polygons;
pub use options::{ImportOptions, Split, UpAxis, Vertices};
pub use point_sets::unique_names;
pub use read::{ReadError, SourceFile, buffers_of, open_regular, read};
pub use scene_objects::{SceneObject, scene_objects};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
