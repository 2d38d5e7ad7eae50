//! Convex collision solver: intersection, distance and contact of two shapes by their support
//! mappings.
//!
//! Each algorithm has a file or a folder of its own:
//!
//! | where | what |
//! |---|---|
//! | `minkowski` | the Minkowski difference (CSO) that all algorithms search |
//! | `mpr` | MPR: portal discovery and portal refinement, the two phases of Kenwright's Algorithm 1 |
//! | `gjk` | GJK: the closest point of the difference to the origin, and thus the distance |
//! | `epa` | EPA, the expanding polytope: the penetration depth |
//! | `sat` | SAT, the separating axis test: the penetration depth of small hulls |
//! | `barycentric` | closest points of simplices, and the weights that give witness points |
//! | `intersection`, `distance`, `contact` | the queries, composed of these algorithms |
//! | `line` | where a line enters the difference: rays and shape casts |
//! | `rounded` | the same for rounded shapes, by Newton's method on the distance of the cores |
//! | `ray`, `cast`, `signed_distance`, `motion` | rays, shape casts and points, composed of these algorithms |
//! | `queries` | the other public functions; they solve rounded shapes by their cores |
//! | `cache` | what one pair keeps from query to query (warm start) |
//! | `scratch` | memory for the largest polytopes, for threads with a small stack |
//! | `steps` | how a query is driven: to its end, or in turns with others |
//!
//! All arithmetic is in f64. There is no allocation, no angle and no random number, so the same
//! input always gives the same bits. Lengths are compared only with other lengths of the query, so
//! nothing changes with the scale of the scene.
//!
//! # Tried and rejected
//! - *Refine the portal to the surface before the expansion.* It takes 3 to 20 more support calls
//!   (hulls of 8 to 8,192 points).
//! - *Keep directions in the cache.* Each costs a support call to become a point again, and
//!   together they save 5 to 12 % of the calls. Features cost no call.
//! - *Test the last axis from the last features* (`SupportMap::support_point_from`). It is 5 to 20
//!   % slower than a new support query.
//! - *Keep every vertex of the last polytope.* From about 60 vertices on, for hulls of 500 vertices
//!   and more, small faces around the nearest one turn into dents. Filling them takes twice as many
//!   calls as an empty cache.
//! - *Compile whole queries for AVX2*, as the index look-ups are. The difference is within the
//!   noise at 8 and 128 points. What counts is that directions and points stay in registers, or are
//!   read back in the pieces in which they were written: that is worth a quarter of the time.
//! - *Find the horizon from one bit per face and all edges of the visible faces*, almost without
//!   branches, instead of by a walk. Contacts of penetrating pairs are 11 to 18 % slower. The walk
//!   visits about five faces.
//! - *Start GJK from the first support point* instead of the centre. It is 4 % slower at 8 points
//!   and 6 % faster at 2,048.
//! - *A look-up for trees alone*, without the other index kinds. No difference. The special cases
//!   for one to four blocks are worth 8 to 18 %.

#![forbid(unsafe_code)]

mod answer;
mod barycentric;
mod bound;
mod cache;
pub(crate) mod cast;
mod contact;
mod distance;
mod epa;
mod gjk;
mod intersection;
mod line;
pub(crate) mod minkowski;
pub(crate) mod motion;
mod mpr;
pub(crate) mod queries;
pub(crate) mod ray;
mod rounded;
mod sat;
mod scratch;
mod settings;
pub(crate) mod signed_distance;
mod status;
mod steps;

pub use answer::Contact;
pub use cache::Cache;
pub use cast::Impact;
pub(crate) use contact::ContactQuery;
#[doc(hidden)]
pub use contact::contact_by_facets;
pub use distance::Distance;
pub(crate) use distance::DistanceQuery;
pub use intersection::Intersection;
pub(crate) use intersection::IntersectionQuery;
pub use minkowski::{Minkowski, Vertex};
pub use motion::{CastSettings, Motion, Ray, VectorError};
pub use ray::RayHit;
pub use scratch::Scratch;
pub use settings::Settings;
pub use signed_distance::SignedDistance;
pub use status::{Overlap, Status};
pub(crate) use steps::{SteppedQuery, Suspended};
