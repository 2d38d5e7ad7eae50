//! Support mapping and convex collision (GJK, EPA, MPR) on hulls with many vertices, read from
//! `.hullmap` packs.
//!
//! The command `bake` turns meshes into packs offline. This crate opens packs and answers queries:
//! support points, overlap, distance, contact, rays, shape casts and contact manifolds. Answers are
//! certified intervals in double precision. After a pack is open, no query locks or performs I/O,
//! and none allocates, except the first query of parts with a [`Cache`] that is not
//! [prepared](Cache::with_pairs) for it.
//!
//! # Open a pack and query a support point
//!
//! A [`Pack`] holds one or more [`Hull`]s. Its direction index finds a [support
//! vertex](Hull::support) at a cost that barely grows with the number of vertices.
//!
//! ```
//! # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let _folder = folder_of_packs()?;
//! use hullmap::Pack;
//! use hullmap::glam::Vec3;
//!
//! let pack = Pack::open("baked/rock.hullmap")?;
//! let rock = pack.hull(0)?; // or pack.hull_named("rock")
//! let top = rock.support(Vec3::Z);
//! assert!(rock.vertices().all(|vertex| vertex.z <= top.point.z));
//! assert_eq!(rock.vertex(top.index), Some(top.point));
//! # Ok(())
//! # }
//! ```
//!
//! [`SharedHull`] is a hull without a lifetime, for components and threads.
//!
//! # Overlap, distance and contact
//!
//! [`intersects`], [`distance`] and [`contact`] take any two [geometries](geometry): hulls,
//! primitives, support mappings of your own, packs of several hulls, triangle meshes, height
//! fields, half-spaces. A [`Pose`] `b_in_a` maps B's frame into A's, and all results are in A's
//! frame. The [`Cache`] of a pair makes the next query cheaper.
//!
//! ```
//! # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let _folder = folder_of_packs()?;
//! use hullmap::glam::{DQuat, DVec3};
//! use hullmap::shapes::Sphere;
//! use hullmap::{Cache, Pack, Pose, Settings};
//!
//! let pack = Pack::open("baked/cube.hullmap")?;
//! let (cube, ball) = (pack.hull(0)?, Sphere::new(0.5)?);
//! let settings = Settings::default();
//! let mut cache = Cache::new();
//!
//! // The cube extends by 1 from its centre.
//! let b_in_a = Pose::new(DVec3::new(1.25, 0.2, 0.0), DQuat::from_rotation_z(0.5))?;
//! assert!(hullmap::intersects(&cube, &ball, b_in_a, &mut cache).is_hit());
//! let contact = hullmap::contact(&cube, &ball, b_in_a, &settings, &mut cache);
//! assert!((contact.depth - 0.25).abs() < 1e-9);
//! assert!(contact.depth_lower <= contact.depth && contact.depth <= contact.depth_upper);
//! assert!(contact.normal.distance(DVec3::X) < 1e-9); // from A to B
//!
//! let b_in_a = Pose::from_translation(DVec3::new(3.0, 0.0, 0.0))?;
//! let gap = hullmap::distance(&cube, &ball, b_in_a, &settings, &mut cache);
//! assert!((gap.distance - 1.5).abs() < 1e-9);
//! # Ok(())
//! # }
//! ```
//!
//! Numerical trouble is never silent: each answer has a [`Status`] or an [`Overlap`].
//!
//! # Rays, shape casts and points
//!
//! [`ray`] returns where a ray enters a shape, [`cast`] when a moving shape first meets another
//! (the time of impact), and [`signed_distance`] how far a point is from the surface.
//!
//! ```
//! # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let pack = pack();
//! use hullmap::glam::DVec3;
//! use hullmap::shapes::Sphere;
//! use hullmap::{Cache, CastSettings, Motion, Pose, Ray, Settings};
//!
//! let cube = pack.hull_named("cube")?; // extends by 1 from its centre
//! let down = Ray::new(DVec3::new(0.3, 0.2, 5.0), DVec3::NEG_Z)?;
//! let hit = hullmap::ray(&cube, &down, &CastSettings::default());
//! assert!(hit.hit && (hit.t - 4.0).abs() < 1e-9);
//! assert!(hit.t_lower <= hit.t && hit.t <= hit.t_upper);
//!
//! let (ball, start) = (Sphere::new(0.5)?, Pose::from_translation(DVec3::new(0.0, 0.0, 5.0))?);
//! let fall = Motion::new(DVec3::new(0.0, 0.0, -10.0))?;
//! let mut cache = Cache::new();
//! let impact = hullmap::cast(&cube, &ball, start, fall, &CastSettings::default(), &mut cache);
//! assert!((impact.t - 0.35).abs() < 1e-6);
//!
//! let point = DVec3::new(0.0, 0.75, 0.0);
//! let inside = hullmap::signed_distance(&cube, point, &Settings::default(), &mut cache)?;
//! assert!((inside.distance + 0.25).abs() < 1e-9);
//! # Ok(())
//! # }
//! ```
//!
//! # A falling body that comes to rest
//!
//! A [`Manifold`] keeps up to four contact points of a pair from step to step, with the impulses
//! that the caller stores in them. [`Hull::mass_properties`] returns the mass and the inertia
//! tensor. This is a small physics step: semi-implicit Euler with sequential impulses, without
//! friction.
//!
//! ```
//! # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let pack = pack();
//! use hullmap::glam::{DMat3, DQuat, DVec3};
//! use hullmap::shapes::Cuboid;
//! use hullmap::{Cache, Manifold, ManifoldSettings, Pose};
//!
//! let floor = Cuboid::new(DVec3::new(20.0, 20.0, 1.0))?; // its top is at z = 1
//! let cube = pack.hull_named("cube")?; // its centre of mass is the origin
//! let body = cube.mass_properties(1.0);
//!
//! // The frame of the floor is the frame of the world. The cube starts tilted, above the floor.
//! let (mut position, mut rotation) = (DVec3::new(0.0, 0.0, 4.0), DQuat::from_rotation_x(0.4));
//! let (mut velocity, mut spin) = (DVec3::ZERO, DVec3::ZERO);
//! let (mut manifold, mut cache) = (Manifold::new(), Cache::new());
//! let (step, slop) = (1.0 / 60.0, 0.005);
//!
//! for _ in 0..600 {
//!     velocity.z -= 9.81 * step;
//!     let cube_in_floor = Pose::new(position, rotation)?;
//!     let settings = ManifoldSettings::default();
//!     manifold.update(&floor, &cube, cube_in_floor, &settings, &mut cache);
//!
//!     let turn = DMat3::from_quat(rotation);
//!     let inverse_inertia = turn * body.inertia.inverse() * turn.transpose();
//!     let normal = manifold.normal();
//!     let mut push = |arm: DVec3, impulse: f64| {
//!         velocity += normal * impulse / body.mass;
//!         spin += inverse_inertia * arm.cross(normal) * impulse;
//!         (velocity, spin)
//!     };
//!     // Warm start with the impulses of the previous step, then iterate.
//!     for point in manifold.points() {
//!         push(point.point_b - position, point.impulse[0]);
//!     }
//!     for _ in 0..20 {
//!         for point in manifold.points_mut() {
//!             let arm = point.point_b - position;
//!             let lever = arm.cross(normal);
//!             let effective_mass = 1.0 / (1.0 / body.mass + lever.dot(inverse_inertia * lever));
//!             // Close a gap within one step, but push overlapping surfaces apart slowly.
//!             let excess = 0.2 * (point.depth - slop).max(0.0);
//!             let depth = if point.depth < 0.0 { point.depth } else { excess };
//!             let (velocity, spin) = push(arm, 0.0);
//!             let speed = (velocity + spin.cross(arm)).dot(normal);
//!             let total = (point.impulse[0] + effective_mass * (depth / step - speed)).max(0.0);
//!             push(arm, total - point.impulse[0]);
//!             point.impulse[0] = total;
//!         }
//!     }
//!     position += velocity * step;
//!     rotation = (DQuat::from_scaled_axis(spin * step) * rotation).normalize();
//! }
//!
//! // It lies on a face: four points carry its weight, and nothing moves.
//! assert_eq!(manifold.points().len(), 4);
//! assert!(velocity.length() < 1e-3 && spin.length() < 1e-3);
//! assert!((position.z - 2.0).abs() < 2.0 * slop);
//! let weight: f64 = manifold.points().iter().map(|point| point.impulse[0] / step).sum();
//! assert!((weight - body.mass * 9.81).abs() < 1e-3 * weight);
//! # Ok(())
//! # }
//! ```
//!
//! # Many pairs at once
//!
//! [`batch`] solves a slice of pairs, with the feature `parallel` on all threads. The answers are
//! bit-identical to the answers of single queries.
//!
//! ```
//! use hullmap::batch::{self, Pair};
//! use hullmap::glam::DVec3;
//! use hullmap::shapes::{Cuboid, Sphere};
//! use hullmap::{Cache, Contact, Pose, Settings};
//!
//! let (floor, ball) = (Cuboid::new(DVec3::new(50.0, 50.0, 1.0))?, Sphere::new(0.5)?);
//! let mut pairs = Vec::new();
//! for i in 0..100 {
//!     let b_in_a = Pose::from_translation(DVec3::new(0.4 * f64::from(i), 0.0, 1.25))?;
//!     pairs.push(Pair { a: &floor, b: &ball, b_in_a });
//! }
//! let mut caches = vec![Cache::new(); pairs.len()];
//! let mut contacts = vec![Contact::default(); pairs.len()];
//! batch::contact(&pairs, &Settings::default(), &mut caches, &mut contacts)?;
//! assert!(contacts.iter().all(|contact| (contact.depth - 0.25).abs() < 1e-9));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Concave meshes and levels
//!
//! `bake build --decompose` bakes a concave mesh as several convex parts. The [`Pack`] is their
//! union. A level keeps its triangles: see [`TriangleMesh`] and [`HeightField`]. All queries take
//! them, and the answer names the hull or the triangle that decided it. [`CompoundManifolds`] keeps
//! a manifold for each pair of parts that touch.
//!
//! ```
//! # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let _folder = folder_of_packs()?;
//! use hullmap::glam::DVec3;
//! use hullmap::shapes::Sphere;
//! use hullmap::{Cache, Pack, Pose, Settings};
//!
//! // A cube at x from -3 to -1, and an octahedron from 1 to 3, with room for a ball between them.
//! let (both, ball) = (Pack::open("parts/two_objects.hullmap")?, Sphere::new(0.5)?);
//! let between = Pose::from_translation(DVec3::new(0.25, 0.0, 0.0))?;
//! let gap = hullmap::distance(&both, &ball, between, &Settings::default(), &mut Cache::new());
//! assert!((gap.distance - 0.25).abs() < 1e-9);
//! assert_eq!(gap.parts, [1, 0]); // the octahedron
//! # Ok(())
//! # }
//! ```
//!
//! # Features of the crate
//!
//! - `mmap` (default): `Pack::map` and `TriangleMesh::map`, which map a file instead of copying it,
//!   by memmap2.
//! - `parallel`: batches on all threads, by rayon. Without it, they run on the calling thread.
//!
//! # Where to find more
//!
//! - [`Asset`]: a baked file of any kind
//! - [`Pack`]: the constructors, and when to map a file instead of copying it
//! - [`Hull`]: vertices, faces, neighbours and everything else that a pack records about a hull
//! - [`Geometry`]: what can be queried; [`SharedGeometry`]: any of it as one type, without lifetime
//! - [`shapes`]: primitives, scaled and rounded shapes; [`SupportMap`]: a shape of your own
//! - [`SupportMap::bounds_under`]: the box of a shape for a broad phase
//! - [`Settings`]: tolerance and iteration limit; [`Instructions`]: SIMD selection
//! - [`solver`]: how queries work
//!
//! The algorithms follow B. Kenwright, "Generic Convex Collision Detection using Support Mapping",
//! and complete it.
#![deny(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing))]

mod asset;
pub mod batch;
mod cascade;
pub mod compound;
mod continuous;
mod derivatives;
mod facets;
mod fields;
mod file;
pub mod geometry;
pub mod height_field;
mod hull;
#[allow(clippy::indexing_slicing, reason = "the indexed arrays are its own, of fixed length")]
pub mod manifold;
mod pack;
mod polygon;
pub mod pose;
mod query;
mod ray_box;
pub mod shapes;
#[allow(clippy::indexing_slicing, reason = "the indexed arrays are its own, of fixed length")]
pub mod solver;
mod support;
pub mod triangle_mesh;
mod vector;

pub use asset::Asset;
pub use compound::{Compound, CompoundManifolds};
pub use continuous::{ClearSettings, Clearance, MotionSettings, RigidMotion, TimeOfImpact, Verdict};
pub use derivatives::{Derivatives, Differentiability, PoseDerivative, WitnessDerivatives, WitnessJacobian};
#[doc(hidden)]
pub use facets::Facets;
pub use fields::{Fields, Value};
pub use geometry::{Geometry, SharedGeometry};
pub use glam;
pub use height_field::HeightField;
pub use hull::{Hull, HullArrays, MassProperties, MassSource, Replacement, SharedHull, SupportVertex, Voids};
pub use hullmap_format::triangle_mesh::class::{EdgeClass, VertexClass};
pub use hullmap_format::{
    FORMAT_VERSION, IndexKind, LEAN_FORMAT_VERSION, PrimitiveKind, SolidKind, header::Header, walk::Cost,
};
pub use manifold::{Manifold, ManifoldSettings, Prediction};
pub use pack::{InvalidPack, NoHullNamed, NoSuchHull, OpenError, Pack};
pub use pose::{Pose, PoseError};
pub use query::{cast, cast_motion, clear, contact, contacts, distance, intersects, ray, signed_distance};
pub use shapes::{Corner, Feature, Shape, ShapeError};
pub use solver::{
    Cache, CastSettings, Contact, Distance, Impact, Intersection, Minkowski, Motion, Overlap, Ray, RayHit, Scratch,
    Settings, SignedDistance, Status, VectorError, Vertex,
};
pub use support::{Bounds, Instructions, SupportMap, SupportPoint};
pub use triangle_mesh::TriangleMesh;

/// The examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
