//! Runtime for `.hullmap` packs.

pub mod minkowski;
pub mod pose;
pub mod solver;
pub mod support_map;
pub use minkowski::{Minkowski, Vertex};
pub use pose::{Pose, PoseError};
pub use solver::{
    Cache, Contact, Distance, Intersection, Overlap, Settings, Status, contact, distance,
    intersects,
};
pub use support_map::{Support, SupportMap};
