//! A sphere about the origin: a point and a radius.

use super::{direction, error::length};
use crate::{Corner, Feature, Shape, ShapeError, Support, SupportMap};
use glam::DVec3;

/// A sphere about the origin of its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    radius: f64,
}

impl Sphere {
    /// The sphere of this radius; a point if that is 0.
    ///
    /// # Errors
    /// A radius that is NaN, negative or above the greatest f32.
    pub fn new(radius: f64) -> Result<Self, ShapeError> {
        Ok(Self { radius: length("radius", radius)? })
    }

    /// The radius.
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl SupportMap for Sphere {
    fn support(&self, dir: DVec3) -> Support {
        Support { point: direction(dir) * self.radius, feature: 0 }
    }
    fn interior_point(&self) -> DVec3 {
        DVec3::ZERO
    }
    fn inner_radius(&self) -> f64 {
        self.radius
    }
    fn outer_radius(&self) -> f64 {
        self.radius
    }
    fn rounding_radius(&self) -> f64 {
        self.radius
    }
    fn core_support(&self, _: DVec3) -> Support {
        Support { point: DVec3::ZERO, feature: 0 }
    }
    fn core_radii(&self) -> [f64; 2] {
        [0.0, 0.0]
    }
    fn core_point(&self, _: u32) -> Option<DVec3> {
        Some(DVec3::ZERO)
    }
}

impl Shape for Sphere {
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        out.clear();
        out.push(Corner { point: self.support(dir).point, vertex: 0 });
    }
}
