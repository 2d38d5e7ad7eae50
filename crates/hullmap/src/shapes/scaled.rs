//! Another shape scaled along the axes of its frame, perhaps mirrored.
//!
//! The support point of a scaled shape in direction d is that of the shape in direction S d, scaled: d · S p = S d · p.
//! So a scaled hull is answered from the same pack.

use super::error::MAX_LENGTH;
use crate::shape::ring;
use crate::{Feature, Shape, ShapeError, Support, SupportMap};
use glam::DVec3;

/// Another shape, scaled along the axes of its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaled<S> {
    shape: S,
    scale: DVec3,
}

/// Least scale: below it points of f32 size have no room.
const MIN_SCALE: f64 = 1e-38;

impl<S> Scaled<S> {
    /// `shape` scaled by `scale` along x, y and z, about the origin of its frame; mirrored along axes where that is negative.
    ///
    /// # Errors
    /// A scale that is NaN, zero, or by magnitude below 1e-38 or above the greatest f32.
    pub fn new(shape: S, scale: DVec3) -> Result<Self, ShapeError> {
        // NaN takes the failing branch.
        match scale.to_array().into_iter().find(|s| !(MIN_SCALE..=MAX_LENGTH).contains(&s.abs())) {
            Some(found) => Err(ShapeError::Scale { found }),
            None => Ok(Self { shape, scale }),
        }
    }

    /// The shape as it was.
    pub fn shape(&self) -> &S {
        &self.shape
    }

    /// The scale along each axis.
    pub fn scale(&self) -> DVec3 {
        self.scale
    }

    /// The one scale, where all three are the same but for their signs: a core is then round after scaling too.
    fn uniform(&self) -> Option<f64> {
        let size = self.scale.abs();
        (size.x == size.y && size.y == size.z).then_some(size.x)
    }

    fn scaled(&self, support: Support) -> Support {
        Support { point: support.point * self.scale, ..support }
    }

    fn scaled_radii(&self, [inner, outer]: [f64; 2]) -> [f64; 2] {
        let size = self.scale.abs();
        [inner * size.min_element(), outer * size.max_element()]
    }
}

impl<S: SupportMap> SupportMap for Scaled<S> {
    fn support(&self, dir: DVec3) -> Support {
        self.scaled(self.shape.support(dir * self.scale))
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
    fn rounding_radius(&self) -> f64 {
        self.uniform().map_or(0.0, |scale| self.shape.rounding_radius() * scale)
    }
    fn core_support(&self, dir: DVec3) -> Support {
        match self.uniform() {
            Some(_) => self.scaled(self.shape.core_support(dir * self.scale)),
            None => self.support(dir),
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
    fn point(&self, feature: u32) -> Option<DVec3> {
        self.shape.point(feature).map(|p| p * self.scale)
    }
    fn support_error(&self) -> f64 {
        self.scaled_radii([0.0, self.shape.support_error()])[1]
    }
}

impl<S: Shape> Shape for Scaled<S> {
    /// Where all scales are the same, the inner shape's feature. Else angles are not kept, and the shape's edges and faces within
    /// [`TILT`](crate::shape::TILT) of `dir` are found by asking around it.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        if self.uniform().is_none() {
            return ring(self, dir, out);
        }
        self.shape.feature(dir * self.scale, out);
        for corner in out.corners_mut() {
            corner.point *= self.scale;
        }
    }
}
