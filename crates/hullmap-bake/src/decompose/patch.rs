//! Patches: pieces of the mesh's surface.

use glam::DVec3;

use hullmap_geometry::planes::{self, HalfSpace};

#[derive(Clone, Debug)]
pub struct Patch {
    pub polygons: Vec<Vec<DVec3>>,
    pub points: Vec<DVec3>,
}

impl Patch {
    pub fn new(polygons: Vec<Vec<DVec3>>) -> Option<Self> {
        let points = polygons.concat();
        (!points.is_empty()).then_some(Self { polygons, points })
    }

    pub fn divided(&self, plane: &HalfSpace, tolerance: f64) -> [Option<Self>; 2] {
        let (mut behind, mut in_front) = (Vec::new(), Vec::new());
        for polygon in &self.polygons {
            let (within, rest) = planes::divide(polygon, &[*plane], tolerance);
            behind.extend((!within.is_empty()).then_some(within));
            in_front.extend(rest);
        }
        [Self::new(behind), Self::new(in_front)]
    }
}
