//! Scaled shape: another shape scaled along the axes of its frame, or mirrored.
//!
//! The support point of the scaled shape in direction d is S p, where p is the support point of the
//! inner shape in direction S d, because d · S p = S d · p. A scaled hull therefore uses the index
//! of the original.

use super::direction;
use super::error::MAX_LENGTH;
use super::error::ShapeError;
use super::feature::{Feature, ring};
use super::shape::Shape;
use crate::support::{FeaturePoint, SupportMap, SupportPoint};
use glam::{DMat3, DVec3};

/// Another shape, scaled along the axes of its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaled<S> {
    shape: S,
    scale: DVec3,
}

/// Minimum magnitude of a scale: about the smallest normal f32.
const MIN_SCALE: f64 = 1e-38;

impl<S> Scaled<S> {
    /// `shape` scaled by `scale` along x, y and z about the origin of its frame. A negative scale
    /// mirrors the shape along that axis.
    ///
    /// # Errors
    /// [`ShapeError::Scale`] if a scale is NaN, or its magnitude is below 1e-38 or above
    /// [`f32::MAX`].
    pub fn new(shape: S, scale: DVec3) -> Result<Self, ShapeError> {
        // NaN takes the failing branch.
        match scale.to_array().into_iter().find(|s| !(MIN_SCALE..=MAX_LENGTH).contains(&s.abs())) {
            Some(found) => Err(ShapeError::Scale { found }),
            None => Ok(Self { shape, scale }),
        }
    }

    /// The inner shape.
    pub fn shape(&self) -> &S {
        &self.shape
    }

    /// The scale along each axis.
    pub fn scale(&self) -> DVec3 {
        self.scale
    }

    /// Magnitude of the scales if it is the same for all axes: only then is a scaled ball a ball.
    fn uniform(&self) -> Option<f64> {
        let size = self.scale.abs();
        (size.x == size.y && size.y == size.z).then_some(size.x)
    }

    fn scaled(&self, support: SupportPoint) -> SupportPoint {
        SupportPoint { point: support.point * self.scale, ..support }
    }

    fn scale_corners(&self, out: &mut Feature) {
        for corner in out.corners_mut() {
            corner.point *= self.scale;
        }
        // A scale that is not uniform changes angles.
        out.set_fall(0.0);
    }

    fn scaled_radii(&self, [inner, outer]: [f64; 2]) -> [f64; 2] {
        let size = self.scale.abs();
        [inner * size.min_element(), outer * size.max_element()]
    }
}

impl<S: SupportMap> SupportMap for Scaled<S> {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        self.scaled(self.shape.support_point(dir * self.scale))
    }
    fn interior_point(&self) -> DVec3 {
        self.shape.interior_point() * self.scale
    }
    fn inner_radius(&self) -> f64 {
        self.scaled_radii([self.shape.inner_radius(), 0.0])[0]
    }
    fn outer_radius(&self) -> f64 {
        self.scaled_radii([0.0, self.shape.outer_radius()])[1]
    }
    fn convex_radius(&self) -> f64 {
        self.uniform().map_or(0.0, |scale| self.shape.convex_radius() * scale)
    }
    fn core_support_point(&self, dir: DVec3) -> SupportPoint {
        match self.uniform() {
            Some(_) => self.scaled(self.shape.core_support_point(dir * self.scale)),
            None => self.support_point(dir),
        }
    }
    fn core_radii(&self) -> [f64; 2] {
        match self.uniform() {
            Some(_) => self.scaled_radii(self.shape.core_radii()),
            None => [self.inner_radius(), self.outer_radius()],
        }
    }
    fn core_point(&self, feature: u32) -> Option<DVec3> {
        let point = if self.uniform().is_some() { self.shape.core_point(feature) } else { self.shape.point(feature) };
        point.map(|p| p * self.scale)
    }
    fn has_polytope_core(&self) -> bool {
        self.shape.has_polytope_core() && (self.uniform().is_some() || self.shape.convex_radius() == 0.0)
    }
    fn core_feature_point(&self, feature: u32, dir: DVec3) -> Option<FeaturePoint> {
        let inner_dir = dir * self.scale;
        let core = self.shape.core_feature_point(feature, inner_dir)?;
        let radius = self.shape.convex_radius();
        // A scale that is not uniform makes an ellipsoid of the ball, which is part of the core.
        let inner = if self.uniform().is_none() && radius > 0.0 { core.rounded(inner_dir, radius) } else { core };
        let scale = DMat3::from_diagonal(self.scale);
        Some(FeaturePoint { point: inner.point * self.scale, derivative: scale * inner.derivative * scale })
    }
    fn point(&self, feature: u32) -> Option<DVec3> {
        self.shape.point(feature).map(|p| p * self.scale)
    }
    fn polytope_vertex(&self, index: u32) -> Option<DVec3> {
        self.shape.polytope_vertex(index).map(|p| p * self.scale)
    }
    fn support_error(&self) -> f64 {
        self.scaled_radii([0.0, self.shape.support_error()])[1]
    }
}

impl<S: Shape> Shape for Scaled<S> {
    /// The inner shape's feature if the scale is uniform. Otherwise scaling changes angles, and
    /// [`ring`] finds the edges and faces within [`TILT`](crate::shapes::TILT) of `dir`.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        if self.uniform().is_none() {
            return ring(self, dir, out);
        }
        self.shape.feature(dir * self.scale, out);
        self.scale_corners(out);
    }

    /// The inner shape's feature, for any scale. A height h above a plane perpendicular to the unit
    /// vector n becomes |S n| h along S⁻¹ n, so heights map to heights, whereas angles do not map
    /// to angles.
    fn feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        let inner_dir = direction(dir) * self.scale;
        let inner_reach = reach / inner_dir.length();
        self.shape.feature_within(dir * self.scale, inner_reach, out);
        self.scale_corners(out);
    }

    /// The inner shape's. Ratios of areas in one plane stay the same under any scale.
    fn reduced_feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        let inner_dir = direction(dir) * self.scale;
        let inner_reach = reach / inner_dir.length();
        self.shape.reduced_feature_within(dir * self.scale, inner_reach, out);
        self.scale_corners(out);
    }
}
