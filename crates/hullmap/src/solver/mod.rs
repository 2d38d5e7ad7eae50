//! The solver: intersection, distance and contact of two convex shapes, from their support mappings alone.
//!
//! One file a phase. `discovery` and `refinement` are the two phases of Kenwright's Algorithm 1 (portal refinement), and
//! `barycentric` its last line; `closest` (distance) and `expansion` (least depth) go on where the paper stops, on the same Minkowski
//! difference. `intersection`, `distance` and `contact` put them together, once each.
//!
//! All arithmetic is in double precision, without allocation, angles or random numbers: the same input gives the same
//! bits. Lengths are compared only with lengths of the query, so nothing changes with the scene's scale.
//!
//! # What did not work
//! - Refining the portal to the surface before expanding: 3 to 20 support calls more (8 to 8,192 points).
//! - Starting the expansion from the directions of the last nearest face instead of a portal: 4 % more calls along a
//!   trajectory than starting cold, where starting phase one from the last portal saves 8 %.

#![forbid(unsafe_code)]

mod barycentric;
mod cache;
mod closest;
mod contact;
mod discovery;
mod distance;
mod expansion;
mod intersection;
mod polytope;
mod refinement;
mod seed;
mod settings;
mod status;

pub use cache::Cache;
pub use contact::{Contact, contact};
pub use distance::{Distance, distance};
pub use intersection::{Intersection, intersects};
pub use settings::Settings;
pub use status::{Overlap, Status};
