//! A thread's memory between configurations: caches, and space for intermediate results.

use glam::DVec3;
use hullmap_robot::Frame;

use crate::kinematics::Placement;
use crate::queries::Caches;

/// Caller-owned memory of a robot's queries, from [`Robot::memory`](crate::Robot::memory). It makes
/// queries cheaper if configurations are near each other, and changes intervals by no more than
/// rounding error. Use one for each thread.
pub struct Memory {
    pub(crate) at: Placement,
    pub(crate) links: Vec<Frame>,
    pub(crate) centres: Vec<DVec3>,
    /// Upper bounds of the rounding error of the points of each link.
    pub(crate) noise: Vec<f64>,
    pub(crate) caches: Caches,
    pub(crate) last: usize,
    pub(crate) edge: EdgeMemory,
}

#[derive(Default)]
pub(crate) struct EdgeMemory {
    pub(crate) q: Vec<f64>,
    pub(crate) spans: Vec<f64>,
    /// Upper bounds of the motion of each body due to a joint of its path and all later ones.
    pub(crate) motions: Vec<Vec<f64>>,
    /// The interval for which each body's bounds hold.
    pub(crate) stamps: Vec<u64>,
    pub(crate) stamp: u64,
    /// Pairs that are not proven to be apart, of the intervals that are open.
    pub(crate) open: Vec<u32>,
}
