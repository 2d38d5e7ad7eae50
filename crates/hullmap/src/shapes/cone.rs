//! A cone along z, its tip up.

use super::{RIM, direction, error::length, length_of, push_rim, radial};
use crate::shape::TILT;
use crate::{Corner, Feature, Shape, ShapeError, Support, SupportMap};
use glam::DVec3;

/// A cone about z: the base at −`half_height`, the tip at `half_height`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    half_height: f64,
    radius: f64,
}

/// Feature numbers of tip and rim.
const TIP: u32 = 0;
const RIM_POINT: u32 = 1;

impl Cone {
    /// The cone with its tip at `half_height` on z and its base, of this radius, at −`half_height`. Either length may be 0.
    ///
    /// # Errors
    /// A length that is NaN, negative or above the greatest f32.
    pub fn new(half_height: f64, radius: f64) -> Result<Self, ShapeError> {
        Ok(Self { half_height: length("half height", half_height)?, radius: length("radius", radius)? })
    }

    /// Half the height.
    pub fn half_height(&self) -> f64 {
        self.half_height
    }

    /// The base's radius.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Length of the line from the tip to the rim.
    fn slant(&self) -> f64 {
        length_of(2.0 * self.half_height, self.radius)
    }

    fn rim_point(&self, dir: DVec3) -> DVec3 {
        radial(dir) * self.radius - DVec3::Z * self.half_height
    }
}

impl SupportMap for Cone {
    fn support(&self, dir: DVec3) -> Support {
        let dir = direction(dir);
        // Tip or rim: which is farther, by twice the half height or by the radius.
        if 2.0 * self.half_height * dir.z >= self.radius * length_of(dir.x, dir.y) {
            Support { point: DVec3::Z * self.half_height, feature: TIP }
        } else {
            Support { point: self.rim_point(dir), feature: RIM_POINT }
        }
    }
    /// The centre of the inscribed ball.
    fn interior_point(&self) -> DVec3 {
        DVec3::Z * (self.inner_radius() - self.half_height)
    }
    fn inner_radius(&self) -> f64 {
        // Radius of the circle inscribed in the triangle of tip and diameter: twice the area over the perimeter.
        let perimeter = self.slant() + self.radius;
        if perimeter > 0.0 { 2.0 * self.half_height * self.radius / perimeter } else { 0.0 }
    }
    fn outer_radius(&self) -> f64 {
        let inner = self.inner_radius();
        (2.0 * self.half_height - inner).max(length_of(inner, self.radius))
    }
}

impl Shape for Cone {
    /// The base as [`MAX_CORNERS`](crate::shape::MAX_CORNERS) points of its rim, the line from the tip down the side, the tip, or a
    /// point of the rim.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        out.clear();
        let n = direction(dir);
        let across = length_of(n.x, n.y);
        // The side's normal leans up by radius over twice the half height; the sine of the angle to it.
        let off_side = (2.0 * self.half_height * n.z - self.radius * across) / self.slant();
        if across <= TILT && n.z < 0.0 && self.radius > 0.0 {
            push_rim(out, -self.half_height, self.radius, RIM);
        } else if off_side.abs() <= TILT && n.z >= -TILT {
            out.push(Corner { point: DVec3::Z * self.half_height, vertex: TIP });
            out.push(Corner { point: self.rim_point(n), vertex: RIM_POINT });
        } else {
            let Support { point, feature } = self.support(n);
            out.push(Corner { point, vertex: feature });
        }
    }
}
