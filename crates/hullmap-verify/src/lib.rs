//! The judge: verifies files against their sources.
//!
//! | module | concept |
//! |---|---|
//! | [`pack`] | verification of a pack, hull by hull |
//! | [`triangle_mesh`], [`height_field`] | verification of a triangle mesh, of a height field |
//! | [`index`] | proofs of direction indices |
//! | [`support`], [`truth`], [`directions`] | support queries against every point of the source |
//! | `joints` | rays at vertices, edges and seams |
//! | [`outside`] | simplified hulls: how far they extend beyond their source |
//! | [`fit`], [`soup`] | cover and protrusion of parts, by samples of the surface |
//! | [`mass`], `primitive` | recorded mass, voids and primitives |
//! | [`parts`] | whether an engine can use the parts of a mesh |
//! | [`geometry`] | vertices and faces of a hull as lists |
//! | [`random`] | seeded directions and points |
//!
//! Reference values are independent of the baker as far as possible: by brute force, in f64.

#![forbid(unsafe_code)]

pub mod directions;
pub mod fit;
pub mod geometry;
pub mod height_field;
pub mod index;
mod joints;
pub mod mass;
pub mod outside;
pub mod pack;
pub mod parts;
mod primitive;
pub mod random;
pub mod soup;
pub mod support;
pub mod triangle_mesh;
pub mod truth;
