//! A box about the origin, its edges along the axes.

use super::{direction, error::length};
use crate::shape::TILT;
use crate::{Corner, Feature, Shape, ShapeError, Support, SupportMap};
use glam::DVec3;

/// A box about the origin of its frame, its edges along the axes.
///
/// A corner's number has bit 0, 1, 2 set where its x, y, z is negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    half: DVec3,
}

impl Cuboid {
    /// The box with these half edges; flat along each axis where that is 0.
    ///
    /// # Errors
    /// A half edge that is NaN, negative or above the greatest f32.
    pub fn new(half_edges: DVec3) -> Result<Self, ShapeError> {
        let half = |c| length("half edge", c);
        Ok(Self { half: DVec3::new(half(half_edges.x)?, half(half_edges.y)?, half(half_edges.z)?) })
    }

    /// The half edges.
    pub fn half_edges(&self) -> DVec3 {
        self.half
    }

    fn corner(&self, negative: u32) -> Corner {
        let side = |bit: u32, half: f64| if negative & bit == 0 { half } else { -half };
        let point = DVec3::new(side(1, self.half.x), side(2, self.half.y), side(4, self.half.z));
        Corner { point, vertex: negative }
    }
}

/// Bits of the axes along which `dir` is negative.
fn negative(dir: DVec3) -> u32 {
    u32::from(dir.x < 0.0) | u32::from(dir.y < 0.0) << 1 | u32::from(dir.z < 0.0) << 2
}

impl SupportMap for Cuboid {
    fn support(&self, dir: DVec3) -> Support {
        let Corner { point, vertex } = self.corner(negative(dir));
        Support { point, feature: vertex }
    }
    fn interior_point(&self) -> DVec3 {
        DVec3::ZERO
    }
    fn inner_radius(&self) -> f64 {
        self.half.min_element()
    }
    fn outer_radius(&self) -> f64 {
        self.half.length()
    }
}

impl Shape for Cuboid {
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        out.clear();
        let dir = direction(dir);
        let sign = negative(dir);
        // Across these axes the direction is too slight to prefer an end.
        let mut free = dir.to_array().into_iter().enumerate().filter(|(_, d)| d.abs() <= TILT).map(|(i, _)| 1 << i);
        match (free.next(), free.next()) {
            (Some(u), Some(v)) => {
                let base = sign & !(u | v);
                [base, base | u, base | u | v, base | v].into_iter().for_each(|c| out.push(self.corner(c)));
            }
            (Some(u), None) => [sign & !u, sign | u].into_iter().for_each(|c| out.push(self.corner(c))),
            _ => out.push(self.corner(sign)),
        }
    }
}
