//! Sphere: a point at the origin and a radius.

use super::error::ShapeError;
use super::feature::{Corner, Feature};
use super::shape::Shape;
use super::{direction, error::length};
use crate::support::{SupportMap, SupportPoint};
use glam::DVec3;

/// A sphere about the origin of its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    radius: f64,
}

impl Sphere {
    /// The sphere of radius `radius`, or a point if it is 0.
    ///
    /// # Errors
    /// [`ShapeError::Length`] if `radius` is NaN, negative or above [`f32::MAX`].
    pub fn new(radius: f64) -> Result<Self, ShapeError> {
        Ok(Self { radius: length("radius", radius)? })
    }

    /// The radius.
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl SupportMap for Sphere {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        SupportPoint { point: direction(dir) * self.radius, feature: 0 }
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
    fn convex_radius(&self) -> f64 {
        self.radius
    }
    fn core_support_point(&self, _: DVec3) -> SupportPoint {
        SupportPoint { point: DVec3::ZERO, feature: 0 }
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
        out.push(Corner { point: self.support_point(dir).point, vertex: 0 });
        out.set_flat();
    }
}
