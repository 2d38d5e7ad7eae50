//! Segment: the straight line between two points.

use super::direction;
use super::error::{ShapeError, point};
use super::feature::{Corner, Feature, NO_REACH, TILT};
use super::shape::Shape;
use crate::support::{SupportMap, SupportPoint};
use glam::DVec3;

/// The segment between two points. A [`Capsule`](crate::shapes::Capsule) is a segment with a
/// radius.
///
/// The ends have the vertex ids 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    ends: [DVec3; 2],
    /// Distance of the farther end from the centre.
    half_length: f64,
}

impl Segment {
    /// The segment from `start` to `end`, which may be equal.
    ///
    /// # Errors
    /// [`ShapeError::Point`] if a coordinate is NaN or beyond [`f32::MAX`].
    pub fn new(start: DVec3, end: DVec3) -> Result<Self, ShapeError> {
        let ends = [point("end of the segment", start)?, point("end of the segment", end)?];
        let center = (start + end) * 0.5;
        Ok(Self { ends, half_length: length(start - center).max(length(end - center)) })
    }

    /// The two ends.
    pub fn ends(&self) -> [DVec3; 2] {
        self.ends
    }

    /// Half the length.
    pub fn half_length(&self) -> f64 {
        self.half_length
    }
}

/// Length of `v`, even if its square underflows.
fn length(v: DVec3) -> f64 {
    let largest = v.abs().max_element();
    if largest > 0.0 { (v / largest).length() * largest } else { 0.0 }
}

impl SupportMap for Segment {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        let [start, end] = self.ends;
        // NaN takes the failing branch.
        if (end - start).dot(dir) > 0.0 {
            SupportPoint { point: end, feature: 1 }
        } else {
            SupportPoint { point: start, feature: 0 }
        }
    }
    fn interior_point(&self) -> DVec3 {
        (self.ends[0] + self.ends[1]) * 0.5
    }
    fn inner_radius(&self) -> f64 {
        0.0
    }
    fn outer_radius(&self) -> f64 {
        self.half_length
    }
    fn point(&self, feature: u32) -> Option<DVec3> {
        self.ends.get(feature as usize).copied()
    }
    fn polytope_vertex(&self, index: u32) -> Option<DVec3> {
        self.point(index)
    }
}

impl Shape for Segment {
    /// Both ends if `dir` is within [`TILT`] of perpendicular to the segment, otherwise one.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        self.feature_within(dir, NO_REACH, out);
    }

    fn feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        out.clear();
        out.set_flat();
        let n = direction(dir);
        let rise = (self.ends[1] - self.ends[0]).dot(n);
        if self.half_length > 0.0 && rise.abs() <= (TILT * (2.0 * self.half_length)).max(reach) {
            for (point, vertex) in self.ends.into_iter().zip(0..) {
                out.push(Corner { point, vertex });
            }
        } else {
            let SupportPoint { point, feature } = self.support_point(n);
            out.push(Corner { point, vertex: feature });
        }
    }
}
