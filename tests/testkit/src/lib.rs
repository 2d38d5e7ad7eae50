//! What the tests of several packages need: packs made in process, brute-force truths about pairs,
//! and random poses.
//!
//! | module | contents |
//! |---|---|
//! | [`packs`] | point sets, baked packs, valid checksums for damaged files |
//! | [`random`] | directions, rotations and poses, seeded |
//! | [`reach`] | how far a shape reaches in a direction, and from it the way out of a pair |
//! | [`polytope`] | a hull as points, face normals and edges |
//! | [`depth`] | signed depth by all facets of the Minkowski difference, and its slow twin |
//! | [`gap`] | distance with a certificate, and its slow twin |
//!
//! Depths and distances are computed in f64 without any code of the solver. A development
//! dependency alone.
//!
//! # Rounding error
//! Both truths are exact up to [`polytope::rounding_error`]: a facet's normal is computed to a few
//! units of rounding error over the facet's extent, and tilting a plane about a facet by that much
//! moves its support value by extent times tilt. So the value of an arbitrarily thin facet is off
//! by some units of the greatest length.

#![forbid(unsafe_code)]

pub mod depth;
pub mod gap;
pub mod packs;
pub mod polytope;
pub mod random;
pub mod reach;
