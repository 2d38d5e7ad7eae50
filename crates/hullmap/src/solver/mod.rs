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
//! | `kept_face` | contacts on the face of the last one, by one support query |
//! | `triangle_face` | contacts in a triangle's face, by one support query |
//! | `barycentric` | closest points of simplices, and the weights that give witness points |
//! | `intersection`, `distance`, `contact` | the queries, composed of these algorithms |
//! | `line` | where a line enters the difference: rays and shape casts |
//! | `rounded` | the same for rounded shapes, by Newton's method on the distance of the cores |
//! | `ray`, `cast`, `signed_distance`, `motion` | rays, shape casts and points, composed of these algorithms |
//! | `ray_triangle`, `ray_polytope` | rays that graze, decided by `exact_ray` and `long_accumulator` |
//! | `queries` | contact, distance and intersection; rounded shapes are solved by their cores |
//! | `cache` | what one pair keeps from query to query (warm start) |
//! | `scratch` | memory for polytopes, also for threads with a small stack |
//! | `steps` | what all steps of a query share, and how it is driven: to its end, or in turns |
//!
//! All arithmetic is in f64. There is no allocation, no random number and no angle. So the same
//! input always gives the same bits.
//! Lengths are compared only with other lengths of the query, so nothing changes with the scale of
//! the scene.
//!
//! docs/contributors/decisions/0010-solver.md has what was tried and rejected.

#![forbid(unsafe_code)]

mod answer;
mod barycentric;
pub(crate) mod bound;
mod cache;
pub(crate) mod cast;
mod contact;
mod distance;
mod epa;
mod exact_ray;
mod gjk;
mod intersection;
mod kept_face;
mod line;
mod long_accumulator;
pub(crate) mod minkowski;
pub(crate) mod motion;
mod mpr;
pub(crate) mod queries;
pub(crate) mod ray;
mod ray_hit;
mod ray_polytope;
pub(crate) mod ray_triangle;
mod rounded;
mod sat;
mod scratch;
mod settings;
pub(crate) mod signed_distance;
mod status;
mod steps;
pub(crate) mod triangle_face;

pub use answer::Contact;
pub use cache::Cache;
pub use cast::Impact;
#[doc(hidden)]
pub use contact::contact_by_facets;
pub(crate) use contact::{ContactQuery, known_separation};
pub use distance::Distance;
pub(crate) use distance::DistanceQuery;
pub use intersection::Intersection;
pub(crate) use intersection::IntersectionQuery;
pub use minkowski::{Minkowski, Vertex};
pub use motion::{CastSettings, Motion, Ray, VectorError};
pub use ray_hit::RayHit;
pub use scratch::Scratch;
pub use settings::Settings;
pub use signed_distance::SignedDistance;
pub use status::{Overlap, Status};
pub(crate) use steps::{SteppedQuery, Suspended};
