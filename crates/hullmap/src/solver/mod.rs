//! The solver: intersection, distance and contact of two convex shapes, from their support mappings alone.
//!
//! One file a phase. `discovery` and `refinement` are the two phases of Kenwright's Algorithm 1 (portal refinement), and
//! `barycentric` its last line; `closest` (distance) and `expansion` (least depth) go on where the paper stops, on the same Minkowski
//! difference. `intersection`, `distance` and `contact` put them together, once each.
//!
//! `lockstep` is the paper's algorithm in a fixed number of steps, for lanes.
//!
//! All arithmetic is in double precision, without allocation, angles or random numbers: the same input gives the same
//! bits. Lengths are compared only with lengths of the query, so nothing changes with the scene's scale.
//!
//! # What did not work
//! - Refining the portal to the surface before expanding: 3 to 20 support calls more (8 to 8,192 points).
//! - Keeping directions in the cache: each costs a support call to become a point again, and saves 5 to 12 % of all. Features
//!   cost none.
//! - Testing the last axis by way of the last features (`SupportMap::support_from`): 5 to 20 % slower than asking anew.
//! - Keeping every vertex of the last polytope: beyond about 60, on hulls of 500 vertices and more, small faces about the nearest one
//!   turn into dents, and twice as many calls as from nothing are needed to fill them.
//! - Compiling whole queries for AVX2, as the index's lookups are: within noise at 8 and 128 points. What counts is that directions
//!   and points stay in registers, or are read back in the pieces that they were written in: a quarter of the time.
//! - The horizon from one bit a face and every edge of the faces seen, with next to no branches, in place of the walk: 11 to 18 % slower
//!   contacts of deep pairs. The walk looks at five faces.
//! - Starting the closest-point search from the first support point in place of the centre: 4 % slower at 8 points, 6 % faster at 2,048.
//! - A lookup for trees alone, without the other kinds of index: no difference. Those for one to four blocks are worth 8 to 18 %.

#![forbid(unsafe_code)]

mod barycentric;
mod cache;
mod closest;
mod contact;
mod discovery;
mod distance;
mod expansion;
mod intersection;
mod lockstep;
mod polytope;
mod refinement;
mod seed;
mod settings;
mod status;

pub use cache::Cache;
pub use contact::{Contact, contact};
pub use distance::{Distance, distance};
pub use intersection::{Intersection, intersects};
pub use lockstep::contact_in_steps;
pub use settings::Settings;
pub use status::{Overlap, Status};
