//! Capsule: a segment along z and a radius.

use super::error::ShapeError;
use super::feature::{Corner, Feature, TILT};
use super::shape::Shape;
use super::{direction, error::length};
use crate::support::{SupportMap, SupportPoint};
use glam::DVec3;

/// A capsule about the origin of its frame, along z.
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Capsule;
/// use hullmap::{ShapeError, SupportMap};
///
/// let capsule = Capsule::new(1.0, 0.25)?;
/// assert_eq!((capsule.half_length(), capsule.radius()), (1.0, 0.25));
/// assert_eq!(capsule.support_point(DVec3::Z).point, DVec3::new(0.0, 0.0, 1.25));
/// assert!(matches!(Capsule::new(1.0, -0.25), Err(ShapeError::Length { .. })));
/// # Ok::<(), ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    half_length: f64,
    radius: f64,
}

impl Capsule {
    /// All points within `radius` of the segment on the z axis from −`half_length` to
    /// `half_length`. Either may be 0.
    ///
    /// # Errors
    /// [`ShapeError::Length`] if a length is NaN, negative or above [`f32::MAX`].
    pub fn new(half_length: f64, radius: f64) -> Result<Self, ShapeError> {
        Ok(Self { half_length: length("half length", half_length)?, radius: length("radius", radius)? })
    }

    /// Half the length of the segment, without the caps.
    pub fn half_length(&self) -> f64 {
        self.half_length
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
        DVec3::ZERO
    }
    fn inner_radius(&self) -> f64 {
        self.radius
    }
    fn outer_radius(&self) -> f64 {
        self.half_length + self.radius
    }
    fn convex_radius(&self) -> f64 {
        self.radius
    }
    fn core_support_point(&self, dir: DVec3) -> SupportPoint {
        let lower = dir.z < 0.0;
        let z = if lower { -self.half_length } else { self.half_length };
        SupportPoint { point: DVec3::Z * z, feature: u32::from(lower) }
    }
    fn core_radii(&self) -> [f64; 2] {
        [0.0, self.half_length]
    }
}

impl Shape for Capsule {
    /// The line along the side if `dir` is within [`TILT`] of perpendicular to z, otherwise a point
    /// of a cap.
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
            out.push(end(self.core_support_point(n).feature));
        }
    }
}
