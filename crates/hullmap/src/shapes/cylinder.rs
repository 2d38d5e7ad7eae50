//! Cylinder along z.

use super::error::ShapeError;
use super::feature::{Corner, Feature, MAX_CORNERS, NO_REACH, TILT};
use super::shape::Shape;
use super::{RIM, direction, error::length, length_of, push_rim, radial, reduce_rim, rim_point};
use crate::support::{FeaturePoint, SupportMap, SupportPoint};
use glam::DVec3;

/// A cylinder about the origin of its frame, along z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    half_height: f64,
    radius: f64,
}

impl Cylinder {
    /// The cylinder of radius `radius` from −`half_height` to `half_height` on the z axis. Either
    /// length may be 0, which makes a disc or a segment.
    ///
    /// # Errors
    /// [`ShapeError::Length`] if a length is NaN, negative or above [`f32::MAX`].
    pub fn new(half_height: f64, radius: f64) -> Result<Self, ShapeError> {
        Ok(Self { half_height: length("half height", half_height)?, radius: length("radius", radius)? })
    }

    /// Half the height.
    pub fn half_height(&self) -> f64 {
        self.half_height
    }

    /// Radius of the caps.
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl SupportMap for Cylinder {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        let lower = dir.z < 0.0;
        let z = if lower { -self.half_height } else { self.half_height };
        SupportPoint { point: radial(dir) * self.radius + DVec3::Z * z, feature: u32::from(lower) }
    }
    fn core_feature_point(&self, feature: u32, dir: DVec3) -> Option<FeaturePoint> {
        let z = if feature == 0 { self.half_height } else { -self.half_height };
        Some(rim_point(dir, self.radius, z))
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
    /// A cap as [`MAX_CORNERS`] points of its rim, a line along the side, or a point of a rim.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        self.feature_within(dir, NO_REACH, out);
    }

    fn feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        out.clear();
        out.set_flat();
        let n = direction(dir);
        let across = length_of(n.x, n.y);
        // How much lower the far end of the cap and of the side's line is.
        let (cap_drop, side_drop) = (2.0 * across * self.radius, 2.0 * n.z.abs() * self.half_height);
        // If both are within reach, the steeper one is the farther.
        let is_cap = across <= TILT || (cap_drop <= reach && n.z.abs() >= across);
        let is_side = n.z.abs() <= TILT || side_drop <= reach;
        if is_cap && self.radius > 0.0 {
            let lower = n.z < 0.0;
            let z = if lower { -self.half_height } else { self.half_height };
            push_rim(out, z, self.radius, RIM + u32::from(lower) * MAX_CORNERS as u32);
        } else if is_side && self.half_height > 0.0 {
            let side = radial(n) * self.radius;
            out.push(Corner { point: side + DVec3::Z * self.half_height, vertex: 0 });
            out.push(Corner { point: side - DVec3::Z * self.half_height, vertex: 1 });
        } else {
            let SupportPoint { point, feature } = self.support_point(n);
            out.push(Corner { point, vertex: feature });
        }
    }

    /// A cap as four points of its rim, or the feature of
    /// [`feature_within`](Shape::feature_within).
    fn reduced_feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        self.feature_within(dir, reach, out);
        reduce_rim(out);
    }
}
