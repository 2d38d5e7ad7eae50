//! hullmap baker: builds the convex hulls of point sets, indexes them, and writes them as the bytes
//! of a `.hullmap` pack.
//!
//! | module | from | to |
//! |---|---|---|
//! | [`decompose`] | concave mesh | points of its convex parts |
//! | [`fit`] | mesh and convex parts | bounds on what they leave out and how far they protrude |
//! | [`hull`] | source points | certified convex hull of rank 3, 2, 1 or 0 |
//! | [`mass`], [`interior`], [`diameter`] | hull | properties stored in the pack |
//! | [`outer`] | hull | outer hull: a coarse polytope that contains the hull |
//! | [`primitive`] | parts and their mesh | boxes, balls, capsules and cylinders that may replace parts |
//! | [`simplify`] | hull | simplified hull: fewer vertices, contains the hull |
//! | [`gauss_map`] | hull | normal cones |
//! | [`index`] | normal cones | proven direction index: cube map or tree, as words and blocks |
//! | [`bvh`] | bounds of the hulls | bounding volume hierarchy over the hulls |
//! | [`pack`] | baked hulls | bytes |
//! | [`triangle_mesh`] | triangles of a level or terrain | bytes of a static triangle mesh |
//! | [`height_field`] | heights of a terrain on a grid | bytes of a static height field |
//! | [`parts`] | meshes and parameters | parts, measured, with estimates for people |
//! | [`advice`] | baked hulls | warnings and notes for people |
//!
//! The crate reads no files and has no command line: it turns points into bytes. Its output is a
//! pure function of its input, for any number of threads.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod advice;
mod baked_hull;
pub mod bvh;
pub mod deadline;
pub mod decompose;
pub mod diameter;
mod error;
mod file;
pub mod fit;
pub mod gauss_map;
mod groups;
pub mod height_field;
pub mod hull;
pub mod index;
pub mod interior;
mod limit;
pub mod mass;
pub mod outer;
pub mod pack;
pub mod parts;
pub mod primitive;
pub mod progress;
pub mod simplify;
mod spread;
pub mod symmetry;
#[cfg(test)]
mod test_meshes;
pub mod triangle_mesh;

pub use baked_hull::{BakedHull, SourceRecord, bake_hull, bake_hull_in, bake_simplified_hull};
pub use error::{BakeError, CONTAINMENT, CertificateError};
pub use fit::Fit;
pub use hullmap_format::{IndexKind, SolidKind, archive::NO_SOURCE_VERTEX};
pub use hullmap_geometry::{MAX_POINTS, PointSet};
pub use pack::{write_lean_pack, write_owned_pack, write_pack};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
