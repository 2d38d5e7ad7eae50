//! Cone along z, with its apex up.

use super::error::ShapeError;
use super::feature::{Corner, Feature, NO_REACH, TILT};
use super::shape::Shape;
use super::{RIM, direction, error::length, length_of, push_rim, radial, reduce_rim, rim_point};
use crate::support::{FeaturePoint, SupportMap, SupportPoint};
use glam::DVec3;

/// A cone about z: the base at −`half_height`, the apex at `half_height`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    half_height: f64,
    radius: f64,
}

/// Vertex ids of the apex and of the point on the rim.
const APEX: u32 = 0;
const RIM_POINT: u32 = 1;

impl Cone {
    /// The cone with its apex at `half_height` on the z axis and its base, of radius `radius`, at
    /// −`half_height`. Either length may be 0.
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

    /// Radius of the base.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Length of the straight line from the apex to the rim.
    fn slant(&self) -> f64 {
        length_of(2.0 * self.half_height, self.radius)
    }

    fn rim_point(&self, dir: DVec3) -> DVec3 {
        radial(dir) * self.radius - DVec3::Z * self.half_height
    }
}

impl SupportMap for Cone {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        let dir = direction(dir);
        // Compares the dot products of the apex and of the rim point, both relative to the centre
        // of the base.
        if 2.0 * self.half_height * dir.z >= self.radius * length_of(dir.x, dir.y) {
            SupportPoint { point: DVec3::Z * self.half_height, feature: APEX }
        } else {
            SupportPoint { point: self.rim_point(dir), feature: RIM_POINT }
        }
    }
    fn core_feature_point(&self, feature: u32, dir: DVec3) -> Option<FeaturePoint> {
        Some(if feature == APEX {
            FeaturePoint::vertex(DVec3::Z * self.half_height)
        } else {
            rim_point(dir, self.radius, -self.half_height)
        })
    }
    /// The centre of the inscribed ball.
    fn interior_point(&self) -> DVec3 {
        DVec3::Z * (self.inner_radius() - self.half_height)
    }
    fn inner_radius(&self) -> f64 {
        // Radius of the circle inscribed in the cross-section, a triangle: twice its area over its
        // perimeter.
        let perimeter = self.slant() + self.radius;
        if perimeter > 0.0 { 2.0 * self.half_height * self.radius / perimeter } else { 0.0 }
    }
    fn outer_radius(&self) -> f64 {
        let inner = self.inner_radius();
        (2.0 * self.half_height - inner).max(length_of(inner, self.radius))
    }
}

impl Shape for Cone {
    /// The base as [`MAX_CORNERS`](crate::shapes::MAX_CORNERS) points of its rim, a line on the
    /// side from the apex to the rim, the apex, or a point of the rim.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        self.feature_within(dir, NO_REACH, out);
    }

    fn feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        out.clear();
        out.set_flat();
        let n = direction(dir);
        let across = length_of(n.x, n.y);
        // Sine of the angle between `n` and the normal of the side: that normal rises by the radius
        // over the height.
        let off_side = (2.0 * self.half_height * n.z - self.radius * across) / self.slant();
        // How much lower the far end of the base and of the side's line is.
        let (base_drop, side_drop) = (2.0 * across * self.radius, off_side.abs() * self.slant());
        // If both are within reach, the base has to be the closer one.
        let is_base = across <= TILT || (base_drop <= reach && across <= off_side.abs());
        if is_base && n.z < 0.0 && self.radius > 0.0 {
            push_rim(out, -self.half_height, self.radius, RIM);
        } else if (off_side.abs() <= TILT && n.z >= -TILT) || side_drop <= reach {
            out.push(Corner { point: DVec3::Z * self.half_height, vertex: APEX });
            out.push(Corner { point: self.rim_point(n), vertex: RIM_POINT });
        } else {
            let SupportPoint { point, feature } = self.support_point(n);
            out.push(Corner { point, vertex: feature });
        }
    }

    /// The base as four points of its rim, or the feature of
    /// [`feature_within`](Shape::feature_within).
    fn reduced_feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        self.feature_within(dir, reach, out);
        reduce_rim(out);
    }
}
