//! Exact support queries and convex collision on detailed hulls, straight from a memory-mapped `.hullmap` file.
//!
//! `bake` turns meshes into packs once, offline; this crate maps a pack and answers. It allocates nothing, takes no lock
//! and does no I/O after a pack is open.
#![deny(unsafe_code)]

mod hull;
mod lookup;
pub mod minkowski;
mod pack;
pub mod pose;
pub mod solver;
mod storage;
pub mod support_map;

pub use hull::{Hull, IndexKind, SupportPoint};
pub use hullmap_format::{header::Header, walk::Cost};
pub use minkowski::{Minkowski, Vertex};
pub use pack::{InvalidPack, NoSuchHull, OpenError, Pack};
pub use pose::{Pose, PoseError};
pub use solver::{Cache, Contact, Distance, Intersection, Overlap, Settings, Status, contact, distance, intersects};
pub use support_map::{Support, SupportMap};
