//! Another shape and a ball, summed: every point within a radius of it.

use super::{direction, error::length};
use crate::{Feature, Shape, ShapeError, Support, SupportMap};
use glam::DVec3;

/// All points within a radius of another shape: its Minkowski sum with a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounded<S> {
    shape: S,
    radius: f64,
}

impl<S> Rounded<S> {
    /// All points within `radius` of `shape`.
    ///
    /// # Errors
    /// A radius that is NaN, negative or above the greatest f32.
    pub fn new(shape: S, radius: f64) -> Result<Self, ShapeError> {
        Ok(Self { shape, radius: length("radius", radius)? })
    }

    /// The shape without its rounding.
    pub fn shape(&self) -> &S {
        &self.shape
    }

    /// The radius.
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl<S: SupportMap> SupportMap for Rounded<S> {
    fn support(&self, dir: DVec3) -> Support {
        let Support { point, feature } = self.shape.support(dir);
        Support { point: point + direction(dir) * self.radius, feature }
    }
    fn interior_point(&self) -> DVec3 {
        self.shape.interior_point()
    }
    fn inner_radius(&self) -> f64 {
        self.shape.inner_radius() + self.radius
    }
    fn outer_radius(&self) -> f64 {
        self.shape.outer_radius() + self.radius
    }
    fn rounding_radius(&self) -> f64 {
        self.shape.rounding_radius() + self.radius
    }
    fn core_support(&self, dir: DVec3) -> Support {
        self.shape.core_support(dir)
    }
    fn core_radii(&self) -> [f64; 2] {
        self.shape.core_radii()
    }
    fn core_point(&self, feature: u32) -> Option<DVec3> {
        self.shape.core_point(feature)
    }
    fn support_error(&self) -> f64 {
        self.shape.support_error()
    }
}

impl<S: Shape> Shape for Rounded<S> {
    /// The inner shape's feature, moved out along `dir`.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        self.shape.feature(dir, out);
        let out_by = direction(dir) * self.radius;
        for corner in out.corners_mut() {
            corner.point += out_by;
        }
    }
}
