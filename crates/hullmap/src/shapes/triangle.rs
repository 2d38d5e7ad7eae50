//! Triangle: a flat shape with three corners.

use super::direction;
use super::error::{ShapeError, point};
use super::feature::{Corner, Feature, NO_REACH, TILT};
use super::shape::Shape;
use crate::solver::ray_triangle::ray_triangle;
use crate::solver::{CastSettings, Ray};
use crate::support::{SupportMap, SupportPoint};
use glam::DVec3;

/// A triangle, for instance one of a triangle mesh. It is flat, and collides on both sides.
///
/// The corners have the vertex ids 0, 1 and 2. They may be collinear or equal, as meshes have
/// such triangles; the shape is then a segment or a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    corners: [DVec3; 3],
    centroid: DVec3,
    /// Distance of the farthest corner from the centroid.
    outer_radius: f64,
}

impl Triangle {
    /// The triangle with these corners.
    ///
    /// # Errors
    /// [`ShapeError::Point`] if a coordinate is NaN or beyond [`f32::MAX`].
    pub fn new(corners: [DVec3; 3]) -> Result<Self, ShapeError> {
        for corner in corners {
            point("corner of the triangle", corner)?;
        }
        Ok(Self::of_finite(corners))
    }

    /// The triangle with corners whose coordinates are finite in f32.
    #[inline]
    pub(crate) fn of_finite(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        let centroid = a + ((b - a) + (c - a)) / 3.0;
        let farthest = corners.map(|corner| corner.distance_squared(centroid)).into_iter().fold(0.0, f64::max);
        Self { corners, centroid, outer_radius: farthest.sqrt() }
    }

    /// The corners.
    pub fn corners(&self) -> [DVec3; 3] {
        self.corners
    }
}

/// Takes the index of a triangle of a sheet and its corners, and returns whether a search ends.
pub(crate) type VisitTriangle<'v> = dyn FnMut(usize, [DVec3; 3]) -> bool + 'v;

/// Whether the box around the `corners` of a triangle and another box, given by two corners, are
/// apart.
#[inline]
pub(crate) fn is_beside_box([a, b, c]: [DVec3; 3], [low, high]: [DVec3; 2]) -> bool {
    a.min(b).min(c).cmpgt(high).any() || a.max(b).max(c).cmplt(low).any()
}

/// The point of a triangle that is closest to `point`, up to rounding.
///
/// # Reference
/// Ericson, "Real-Time Collision Detection", 2005, section 5.1.5: by the region of Voronoi.
pub(crate) fn closest_of_triangle([a, b, c]: [DVec3; 3], point: DVec3) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let (v, w) = (vb / (va + vb + vc), vc / (va + vb + vc));
    a + ab * v + ac * w
}

impl SupportMap for Triangle {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        let [a, b, c] = self.corners;
        // Differences keep the digits of a small triangle far from the origin. NaN takes the
        // failing branches.
        let (to_b, to_c) = ((b - a).dot(dir), (c - a).dot(dir));
        if to_c > 0.0 && to_c > to_b {
            SupportPoint { point: c, feature: 2 }
        } else if to_b > 0.0 {
            SupportPoint { point: b, feature: 1 }
        } else {
            SupportPoint { point: a, feature: 0 }
        }
    }
    fn interior_point(&self) -> DVec3 {
        self.centroid
    }
    fn inner_radius(&self) -> f64 {
        0.0
    }
    fn outer_radius(&self) -> f64 {
        self.outer_radius
    }
    fn point(&self, feature: u32) -> Option<DVec3> {
        self.corners.get(feature as usize).copied()
    }
    fn polytope_vertex(&self, index: u32) -> Option<DVec3> {
        self.point(index)
    }
}

impl Shape for Triangle {
    fn triangle(&self) -> Option<[DVec3; 3]> {
        Some(self.corners)
    }

    /// By the signs of volumes.
    fn entry(&self, ray: &Ray, _near: u32, _until: f64) -> Option<f64> {
        let found = ray_triangle(self.corners, ray, &CastSettings::default());
        found.hit.then_some(found.t)
    }

    /// The support corner, and the corners whose edge to it is within [`TILT`] of perpendicular to
    /// `dir`: all three corners, an edge, or the support corner alone.
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        self.feature_within(dir, NO_REACH, out);
    }

    fn feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        out.clear();
        out.set_flat();
        let n = direction(dir);
        let SupportPoint { point: top, feature } = self.support_point(n);
        for (corner, vertex) in self.corners.into_iter().zip(0..) {
            let edge = corner - top;
            // Equal corners count once.
            if vertex == feature || corner != top && edge.dot(n).abs() <= (TILT * edge.length()).max(reach) {
                out.push(Corner { point: corner, vertex });
            }
        }
    }
}
