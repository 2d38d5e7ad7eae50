//! Scenes of Rapier with baked hulls, and the same scenes with parry's own convex polyhedra.
//!
//! - [`pit`]: bodies that fall into a pit. Does the pile come to rest?
//! - [`relief`]: uneven ground for bodies that come to rest.
//! - [`rest`]: one body falls on a floor. Does it come to rest, and is it lost?
//! - [`sheets`], [`slab`], [`slab_sheet`]: triangle meshes, height fields and slabs.
//! - [`slide`]: one body slides or rolls over a slab that is cut into parts. Does it stumble?
//! - [`stack`]: upright prisms, one or ten of them, that must stand.
//!
//! The tests run few seeds. The example `pile` prints the time of a step and the bodies at rest.

#![allow(dead_code, reason = "the tests and the example use different parts")]

pub mod floor;
pub mod model;
pub mod pit;
pub mod relief;
pub mod rest;
pub mod sheets;
pub mod slab;
pub mod slab_sheet;
pub mod slide;
pub mod stack;
pub mod way;
