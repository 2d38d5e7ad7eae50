//! A convex part as half-spaces in a box: whether it contains points and boxes.

use glam::DVec3;

use crate::hull::Hull;
use hullmap_geometry::{bounds, planes::HalfSpace};

/// The points of a solid hull.
pub struct Region {
    planes: Vec<HalfSpace>,
    low: DVec3,
    high: DVec3,
}

impl Region {
    /// The points of a hull of rank 3.
    pub fn new(hull: &Hull) -> Self {
        let [low, high] = bounds(hull.positions());
        Self { planes: hull.half_spaces(), low, high }
    }

    /// The half-spaces that do not contain all of a box.
    pub fn crossing_box(&self, low: DVec3, high: DVec3) -> impl Iterator<Item = &HalfSpace> {
        self.planes.iter().filter(move |plane| plane.height(farthest(plane, low, high)) > 0.0)
    }

    /// Whether a point is in the part, and at least `depth` below each face.
    pub fn holds(&self, p: DVec3, depth: f64) -> bool {
        p.cmpge(self.low).all() && p.cmple(self.high).all() && self.planes.iter().all(|plane| plane.height(p) <= -depth)
    }

    /// Whether all of a box is in the part.
    pub fn holds_box(&self, low: DVec3, high: DVec3) -> bool {
        low.cmpge(self.low).all() && high.cmple(self.high).all() && self.crossing_box(low, high).next().is_none()
    }

    /// Whether a box is certainly outside the part. Some boxes beside an edge or a corner are not
    /// recognised.
    pub fn misses_box(&self, low: DVec3, high: DVec3) -> bool {
        low.cmpgt(self.high).any()
            || high.cmplt(self.low).any()
            || self.planes.iter().any(|plane| plane.height(farthest(plane, high, low)) > 0.0)
    }
}

fn farthest(plane: &HalfSpace, low: DVec3, high: DVec3) -> DVec3 {
    DVec3::select(plane.normal.cmpge(DVec3::ZERO), high, low)
}
