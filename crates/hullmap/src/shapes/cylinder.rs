//! A cylinder along z.

use super::{RIM, direction, error::length, length_of, push_rim, radial};
use crate::shape::{MAX_CORNERS, TILT};
use crate::{Corner, Feature, Shape, ShapeError, Support, SupportMap};
use glam::DVec3;

/// A cylinder about the origin of its frame, along z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    half_height: f64,
    radius: f64,
}

impl Cylinder {
    /// The cylinder from −`half_height` to `half_height` on z. Either length may be 0: a disc or a segment.
    ///
    /// # Errors
    /// A length that is NaN, negative or above the greatest f32.
    pub fn new(half_height: f64, radius: f64) -> Result<Self, ShapeError> {
        Ok(Self { half_height: length("half height", half_height)?, radius: length("radius", radius)? })
    }

    /// Half the height.
    pub fn half_height(&self) -> f64 {
        self.half_height
    }

    /// The radius.
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl SupportMap for Cylinder {
    fn support(&self, dir: DVec3) -> Support {
        let lower = dir.z < 0.0;
        let z = if lower { -self.half_height } else { self.half_height };
        Support { point: radial(dir) * self.radius + DVec3::Z * z, feature: u32::from(lower) }
    }
    fn interior_point(&self) -> DVec3 {
        DVec3::ZERO
    }
    fn inner_radius(&self) -> f64 {
        self.half_height.min(self.radius)
    }
    fn outer_radius(&self) -> f64 {
        length_of(self.half_height, self.radius)
    }
}

impl Shape for Cylinder {
    /// A cap as [`MAX_CORNERS`] points of its rim, the line along the side, or a point of the rim.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        out.clear();
        let n = direction(dir);
        let across = length_of(n.x, n.y);
        if across <= TILT && self.radius > 0.0 {
            let lower = n.z < 0.0;
            let z = if lower { -self.half_height } else { self.half_height };
            push_rim(out, z, self.radius, RIM + u32::from(lower) * MAX_CORNERS as u32);
        } else if n.z.abs() <= TILT && self.half_height > 0.0 {
            let side = radial(n) * self.radius;
            out.push(Corner { point: side + DVec3::Z * self.half_height, vertex: 0 });
            out.push(Corner { point: side - DVec3::Z * self.half_height, vertex: 1 });
        } else {
            let Support { point, feature } = self.support(n);
            out.push(Corner { point, vertex: feature });
        }
    }
}
