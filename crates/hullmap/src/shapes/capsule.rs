//! Capsule: a segment and a radius.

use super::error::ShapeError;
use super::feature::{Feature, NO_REACH};
use super::segment::Segment;
use super::shape::Shape;
use super::{direction, error::length};
use crate::support::{FeaturePoint, SupportMap, SupportPoint};
use crate::vector::unit;
use glam::DVec3;

/// Minimum sine of the angle between a direction and the segment at which the side faces it: 45
/// degrees.
const LEAST_SIDE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// A capsule: all points within a radius of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    segment: Segment,
    radius: f64,
}

impl Capsule {
    /// All points within `radius` of the segment on the z axis from −`half_length` to
    /// `half_length`. Either length may be 0.
    ///
    /// # Errors
    /// [`ShapeError::Length`] if a length is NaN, negative or above [`f32::MAX`].
    pub fn new(half_length: f64, radius: f64) -> Result<Self, ShapeError> {
        let top = DVec3::Z * length("half length", half_length)?;
        Ok(Self { segment: Segment::new(top, -top)?, radius: length("radius", radius)? })
    }

    /// All points within `radius` of the segment from `start` to `end`, which may be equal.
    ///
    /// # Errors
    /// [`ShapeError::Point`] if a coordinate is NaN or beyond [`f32::MAX`]; [`ShapeError::Length`]
    /// if `radius` is NaN, negative or above [`f32::MAX`].
    pub fn between(start: DVec3, end: DVec3, radius: f64) -> Result<Self, ShapeError> {
        Ok(Self { segment: Segment::new(start, end)?, radius: length("radius", radius)? })
    }

    /// The segment: the capsule without its radius.
    pub fn segment(&self) -> &Segment {
        &self.segment
    }

    /// Half the length of the segment, without the caps.
    pub fn half_length(&self) -> f64 {
        self.segment.half_length()
    }

    /// Radius of the caps and of the side.
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl SupportMap for Capsule {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        let SupportPoint { point, feature } = self.core_support_point(dir);
        SupportPoint { point: point + direction(dir) * self.radius, feature }
    }
    fn interior_point(&self) -> DVec3 {
        self.segment.interior_point()
    }
    fn inner_radius(&self) -> f64 {
        self.radius
    }
    fn outer_radius(&self) -> f64 {
        self.half_length() + self.radius
    }
    fn convex_radius(&self) -> f64 {
        self.radius
    }
    fn core_support_point(&self, dir: DVec3) -> SupportPoint {
        self.segment.support_point(dir)
    }
    fn has_polytope_core(&self) -> bool {
        true
    }
    fn core_feature_point(&self, feature: u32, dir: DVec3) -> Option<FeaturePoint> {
        self.segment.core_feature_point(feature, dir)
    }
    fn core_radii(&self) -> [f64; 2] {
        [0.0, self.half_length()]
    }
}

impl Shape for Capsule {
    /// The line along the side if `dir` is within [`TILT`](crate::shapes::TILT) of perpendicular to
    /// the segment, otherwise a point of a cap.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        self.feature_within(dir, NO_REACH, out);
    }

    fn feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        self.segment.feature_within(dir, reach, out);
        let n = direction(dir);
        let mut outward = n;
        if let [start, end] = out.corners() {
            // Every direction that is perpendicular to a segment is one of its normals.
            let along = direction(end.point - start.point);
            let across = n - along * n.dot(along);
            if across.length() < LEAST_SIDE {
                let SupportPoint { feature, .. } = self.segment.support_point(n);
                out.retain(|corner| corner.vertex == feature);
            } else {
                outward = unit(across).unwrap_or(n);
            }
        }
        out.corners_mut().iter_mut().for_each(|corner| corner.point += outward * self.radius);
    }
}
