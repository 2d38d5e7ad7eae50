//! Box (cuboid) about the origin, with its edges along the axes.

use super::error::ShapeError;
use super::feature::{Corner, Feature, NO_REACH, TILT};
use super::shape::Shape;
use super::{direction, error::length};
use crate::facets::view::Facets;
use crate::support::{FeaturePoint, SupportMap, SupportPoint};
use glam::DVec3;

/// A box about the origin of its frame, with its edges along the axes.
///
/// Bits 0, 1 and 2 of a corner's vertex id are set where its x, y and z are negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    half: DVec3,
}

impl Cuboid {
    /// The box that extends by `half_edges` from the origin along x, y and z, both ways. It is flat
    /// along an axis if the half edge is 0.
    ///
    /// # Errors
    /// [`ShapeError::Length`] if a half edge is NaN, negative or above [`f32::MAX`].
    pub fn new(half_edges: DVec3) -> Result<Self, ShapeError> {
        let half = |c| length("half edge", c);
        Ok(Self { half: DVec3::new(half(half_edges.x)?, half(half_edges.y)?, half(half_edges.z)?) })
    }

    /// Half the length of the edges along x, y and z.
    pub fn half_edges(&self) -> DVec3 {
        self.half
    }

    fn corner(&self, negative: u32) -> Corner {
        let side = |bit: u32, half: f64| if negative & bit == 0 { half } else { -half };
        let point = DVec3::new(side(1, self.half.x), side(2, self.half.y), side(4, self.half.z));
        Corner { point, vertex: negative }
    }
}

/// Bit mask of the axes along which `dir` is negative.
fn negative(dir: DVec3) -> u32 {
    u32::from(dir.x < 0.0) | u32::from(dir.y < 0.0) << 1 | u32::from(dir.z < 0.0) << 2
}

impl SupportMap for Cuboid {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        let Corner { point, vertex } = self.corner(negative(dir));
        SupportPoint { point, feature: vertex }
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
    fn polytope_vertex(&self, index: u32) -> Option<DVec3> {
        (index < 8).then(|| self.corner(index).point)
    }
    fn has_polytope_core(&self) -> bool {
        true
    }
    fn core_feature_point(&self, feature: u32, _: DVec3) -> Option<FeaturePoint> {
        Some(FeaturePoint::vertex(self.corner(feature).point))
    }
    #[inline(always)]
    fn facets(&self) -> Option<Facets<'_>> {
        Facets::of_box(self.half)
    }
}

/// Index of the axis closest to `dir`, which is the normal of the face closest to `dir`.
fn steepest(dir: DVec3) -> u32 {
    let size = dir.abs();
    if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    }
}

impl Shape for Cuboid {
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        self.feature_within(dir, NO_REACH, out);
    }

    fn feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        out.clear();
        out.set_flat();
        let dir = direction(dir);
        let sign = negative(dir);
        // Axes whose ends differ in height by at most `reach`, or that are perpendicular to `dir`
        // within `TILT`. The feature extends over both of their ends.
        let drop = (dir * self.half).abs() * 2.0;
        let is_free = |(d, drop): (f64, f64)| d.abs() <= TILT || drop <= reach;
        let free = dir.to_array().into_iter().zip(drop.to_array()).enumerate().filter(|(_, axis)| is_free(*axis));
        // A face has two free axes. With more than two, it is the one closest to `dir`.
        let mut free = free.map(|(i, _)| 1 << i).filter(|axis| *axis != 1 << steepest(dir));
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
