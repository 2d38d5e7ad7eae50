//! Patches: pieces of the mesh's surface.

use glam::DVec3;

use super::partition::body::bounds;
use crate::fit::planes::{self, HalfSpace};

/// Convex polygons of the surface.
#[derive(Clone, Debug)]
pub struct Patch {
    /// The polygons.
    pub polygons: Vec<Vec<DVec3>>,
    /// Points whose hull contains the polygons.
    pub points: Vec<DVec3>,
}

impl Patch {
    /// Polygons that are not empty; `None` if there are none.
    pub fn new(polygons: Vec<Vec<DVec3>>) -> Option<Self> {
        let points = polygons.concat();
        (!points.is_empty()).then_some(Self { polygons, points })
    }

    /// The pieces in all of the half-spaces, and those outside.
    pub fn divided(self, planes: &[HalfSpace], tolerance: f64) -> [Option<Self>; 2] {
        let (low, high) = bounds(&self.points);
        let (centre, radius) = ((low + high) * 0.5, 0.5 * low.distance(high));
        let near: Vec<HalfSpace> =
            planes.iter().filter(|plane| plane.height(centre) + radius > tolerance).copied().collect();
        let is_behind = |plane: &HalfSpace| self.points.iter().all(|p| plane.height(*p) <= tolerance);
        if near.iter().all(is_behind) {
            return [Some(self), None];
        }
        let is_in_front = |plane: &HalfSpace| self.points.iter().all(|p| plane.height(*p) >= -tolerance);
        if near.iter().any(|plane| is_in_front(plane) && !is_behind(plane)) {
            return [None, Some(self)];
        }
        let (mut inside, mut outside) = (Vec::new(), Vec::new());
        for polygon in &self.polygons {
            let (within, rest) = planes::divide(polygon, &near, tolerance);
            inside.extend((!within.is_empty()).then_some(within));
            outside.extend(rest);
        }
        [Self::new(inside), Self::new(outside)]
    }
}
