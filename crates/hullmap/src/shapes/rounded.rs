//! Rounded shape: the Minkowski sum of a shape and a ball.

use super::error::ShapeError;
use super::feature::Feature;
use super::shape::Shape;
use super::{direction, error::length, round};
use crate::support::{FeaturePoint, SupportMap, SupportPoint};
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
    /// [`ShapeError::Length`] if `radius` is NaN, negative or above [`f32::MAX`].
    pub fn new(shape: S, radius: f64) -> Result<Self, ShapeError> {
        Ok(Self { shape, radius: length("radius", radius)? })
    }

    /// The inner shape.
    pub fn shape(&self) -> &S {
        &self.shape
    }

    /// Radius of the ball. The convex radius also includes the convex radius of the inner shape.
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl<S: SupportMap> SupportMap for Rounded<S> {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        let SupportPoint { point, feature } = self.shape.support_point(dir);
        SupportPoint { point: point + direction(dir) * self.radius, feature }
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
    fn convex_radius(&self) -> f64 {
        self.shape.convex_radius() + self.radius
    }
    fn core_support_point(&self, dir: DVec3) -> SupportPoint {
        self.shape.core_support_point(dir)
    }
    fn has_polytope_core(&self) -> bool {
        self.shape.has_polytope_core()
    }
    fn core_feature_point(&self, feature: u32, dir: DVec3) -> Option<FeaturePoint> {
        self.shape.core_feature_point(feature, dir)
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
    /// The inner shape's feature, moved outward along `dir` by the radius.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        self.shape.feature(dir, out);
        round(out, dir, self.radius, self.shape.interior_point());
    }

    fn feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        self.shape.feature_within(dir, reach, out);
        round(out, dir, self.radius, self.shape.interior_point());
    }

    fn reduced_feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        self.shape.reduced_feature_within(dir, reach, out);
        round(out, dir, self.radius, self.shape.interior_point());
    }
}
