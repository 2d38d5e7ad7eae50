//! A capsule along z: a segment and a radius.

use super::{direction, error::length};
use crate::shape::TILT;
use crate::{Corner, Feature, Shape, ShapeError, Support, SupportMap};
use glam::DVec3;

/// A capsule about the origin of its frame, along z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    half_length: f64,
    radius: f64,
}

impl Capsule {
    /// All points within `radius` of the segment from −`half_length` to `half_length` on z. Either may be 0.
    ///
    /// # Errors
    /// A length that is NaN, negative or above the greatest f32.
    pub fn new(half_length: f64, radius: f64) -> Result<Self, ShapeError> {
        Ok(Self { half_length: length("half length", half_length)?, radius: length("radius", radius)? })
    }

    /// Half the length of the segment, without the caps.
    pub fn half_length(&self) -> f64 {
        self.half_length
    }

    /// The radius.
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl SupportMap for Capsule {
    fn support(&self, dir: DVec3) -> Support {
        let Support { point, feature } = self.core_support(dir);
        Support { point: point + direction(dir) * self.radius, feature }
    }
    fn interior_point(&self) -> DVec3 {
        DVec3::ZERO
    }
    fn inner_radius(&self) -> f64 {
        self.radius
    }
    fn outer_radius(&self) -> f64 {
        self.half_length + self.radius
    }
    fn rounding_radius(&self) -> f64 {
        self.radius
    }
    fn core_support(&self, dir: DVec3) -> Support {
        let lower = dir.z < 0.0;
        let z = if lower { -self.half_length } else { self.half_length };
        Support { point: DVec3::Z * z, feature: u32::from(lower) }
    }
    fn core_radii(&self) -> [f64; 2] {
        [0.0, self.half_length]
    }
}

impl Shape for Capsule {
    /// The line along the side where `dir` is across z, a point elsewhere.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        out.clear();
        let n = direction(dir);
        let end = |vertex: u32| {
            let z = if vertex == 0 { self.half_length } else { -self.half_length };
            Corner { point: DVec3::Z * z + n * self.radius, vertex }
        };
        if n.z.abs() <= TILT && self.half_length > 0.0 {
            out.push(end(0));
            out.push(end(1));
        } else {
            out.push(end(self.core_support(n).feature));
        }
    }
}
