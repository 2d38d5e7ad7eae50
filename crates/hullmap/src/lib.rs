//! Exact support queries and convex collision on detailed hulls, straight from a memory-mapped `.hullmap` file.
//!
//! `bake` turns meshes into packs once, offline; this crate maps a pack and answers. It allocates nothing, takes no lock
//! and does no I/O after a pack is open.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # std::env::set_current_dir(&folder)?;
//! # let positions = shapes::families::rock(200, 1);
//! # let source_vertices = (0..200).collect();
//! # let points = hullmap_bake::PointSet { name: "rock".into(), positions, source_vertices, ..Default::default() };
//! # let baked = hullmap_bake::bake_hull(&points, hullmap_bake::IndexKind::TREE)?;
//! # std::fs::create_dir("baked")?;
//! # std::fs::write("baked/rock.hullmap", hullmap_bake::write_pack(&[baked], &Default::default())?)?;
//! use hullmap::glam::{DQuat, DVec3, Vec3};
//! use hullmap::{Cache, Pack, Pose, Settings};
//!
//! let pack = Pack::open("baked/rock.hullmap")?;
//! let rock = pack.hull(0)?; // or pack.hull_named("rock")
//! let top = rock.support(Vec3::Z);
//! println!("vertex {} lies farthest up, at {}", top.index, top.point);
//!
//! let b_in_a = Pose::new(DVec3::new(1.0, 0.2, 0.0), DQuat::from_rotation_z(0.5))?;
//! let mut cache = Cache::default();
//! if hullmap::intersects(&rock, &rock, b_in_a, &mut cache).is_hit() {
//!     let c = hullmap::contact(&rock, &rock, b_in_a, &Settings::default(), &mut cache);
//!     println!("{:.3} deep along {:.3}, between {} and {}", c.depth, c.normal, c.depth_lower, c.depth_upper);
//! #   assert!(c.hit && c.depth > 0.0);
//! }
//! # else { panic!("the example overlaps"); }
//! # assert!(rock.vertices().all(|v| v.z <= top.point.z));
//! # Ok(())
//! # }
//! ```
//!
//! Whole packs, of the convex parts of concave meshes, are asked by [`compound`]:
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # std::env::set_current_dir(&folder)?;
//! # std::fs::create_dir("baked")?;
//! # for name in ["chair", "table"] {
//! #     let positions = shapes::families::rock(50, 1);
//! #     let source_vertices = (0..50).collect();
//! #     let points = hullmap_bake::PointSet { name: name.into(), positions, source_vertices, ..Default::default() };
//! #     let baked = hullmap_bake::bake_hull(&points, hullmap_bake::IndexKind::TREE)?;
//! #     std::fs::write(format!("baked/{name}.hullmap"), hullmap_bake::write_pack(&[baked], &Default::default())?)?;
//! # }
//! use hullmap::glam::DVec3;
//! use hullmap::{Compound, CompoundCache, Pack, Pose, Settings, compound};
//!
//! let (chair, table) = (Pack::open("baked/chair.hullmap")?, Pack::open("baked/table.hullmap")?);
//! let (chair, table) = (Compound::new(&chair), Compound::new(&table));
//! let b_in_a = Pose::from_translation(DVec3::new(0.5, 0.25, 0.0))?;
//! let mut cache = CompoundCache::default();
//! let gap = compound::distance(&chair, &table, b_in_a, &Settings::default(), &mut cache);
//! println!("hulls {:?} are the nearest, {:.3} apart", gap.hulls, gap.answer.distance);
//! if let Some(c) = compound::contact(&chair, &table, b_in_a, &Settings::default(), &mut cache) {
//!     println!("hulls {:?} are the deepest, {:.3}", c.hulls, c.answer.depth);
//! }
//! # Ok(())
//! # }
//! ```
#![deny(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing))]

pub mod batch;
mod candidates;
pub mod compound;
mod direction;
mod hint;
mod hull;
pub mod levels;
mod lookup;
#[allow(clippy::indexing_slicing, reason = "it computes on numbers, in arrays of its own")]
pub mod manifold;
pub mod minkowski;
mod pack;
pub mod pose;
mod rounding;
pub mod shape;
pub mod shapes;
mod simd;
#[allow(clippy::indexing_slicing, reason = "it computes on numbers, in arrays of its own")]
pub mod solver;
mod storage;
pub mod support_map;

pub use compound::{Compound, CompoundCache};
pub use glam;
pub use hull::{Hull, IndexKind, SupportPoint};
pub use hullmap_format::{header::Header, walk::Cost};
pub use manifold::{Manifold, ManifoldSettings};
pub use minkowski::{Minkowski, Vertex};
pub use pack::{InvalidPack, NoSuchHull, OpenError, Pack};
pub use pose::{Pose, PoseError};
pub use rounding::{contact, distance, intersects};
pub use shape::{Corner, Feature, Shape};
pub use shapes::ShapeError;
pub use simd::Instructions;
pub use solver::{Cache, Contact, Distance, Intersection, Overlap, Settings, Status, contact_in_steps};
pub use support_map::{Support, SupportMap};
