//! The oracle of all tests: depth, distance, time and ray by one brute force each, exact where it
//! decides; packs baked in process; random poses. With the feature `processes`, what tests use
//! outside of their own process.
//!
//! | module | contents |
//! |---|---|
//! | [`clock`] | processor time |
//! | [`command`] | the `bake` command, built and run; cargo |
//! | [`files`] | the workspace's folder, files in a folder, inputs named by environment variables |
//! | [`compiled`] | the solver, compiled once for all tests |
//! | [`packs`] | point sets, baked packs, valid checksums for damaged files |
//! | [`random`] | directions, rotations and poses, seeded |
//! | [`reach`] | how far a shape reaches in a direction, and from it the way out of a pair |
//! | [`polytope`] | a hull as points, face normals and edges |
//! | [`depth`] | signed depth by all facets of the Minkowski difference, and its slow twin |
//! | [`exact_depth`] | the depth of small hulls without rounding |
//! | [`entry`] | when a moving hull enters another, by all facets |
//! | [`ray`] | where a ray meets a triangle or a polytope, without rounding |
//! | [`dyadic`] | numbers and vectors without rounding |
//! | [`faceless`] | a shape without its faces and its core |
//! | [`gap`] | distance with a certificate, and its slow twin |
//! | [`triangles`] | the distance of a point from a triangle, and how often a surface winds around it |
//!
//! No truth uses code of the solver. Packages use this one only as a development dependency.
//!
//! # Rounding error
//! Truths in f64 are exact up to [`polytope::rounding_error`]. The error of a facet's normal is a
//! few units of rounding error divided by the facet's extent. A plane that is tilted by this angle
//! about the facet changes its support value by extent times tilt. So the error of even an
//! arbitrarily thin facet is a few units of the greatest length.

#![forbid(unsafe_code)]

#[cfg(feature = "processes")]
pub mod clock;
#[cfg(feature = "processes")]
pub mod command;
#[cfg(feature = "processes")]
pub mod files;

#[cfg(feature = "truths")]
pub mod compiled;
#[cfg(feature = "truths")]
pub mod depth;
#[cfg(feature = "truths")]
pub mod dyadic;
#[cfg(feature = "truths")]
pub mod entry;
#[cfg(feature = "truths")]
pub mod exact_depth;
#[cfg(feature = "truths")]
pub mod faceless;
#[cfg(feature = "truths")]
pub mod gap;
#[cfg(feature = "truths")]
pub mod packs;
#[cfg(feature = "truths")]
pub mod polytope;
#[cfg(feature = "truths")]
pub mod random;
#[cfg(feature = "truths")]
pub mod ray;
#[cfg(feature = "truths")]
pub mod reach;
#[cfg(feature = "truths")]
pub mod triangles;
