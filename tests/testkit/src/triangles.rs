//! Points beside triangles, and inside surfaces of triangles.

use std::f64::consts::PI;

use glam::DVec3;

use crate::gap::{to_segment, to_triangle};

/// Distance of a point from a triangle.
pub fn distance_from_triangle([q, r, s]: [DVec3; 3], p: DVec3) -> f64 {
    [to_segment(p, q, r), to_segment(p, r, s), to_segment(p, s, q)].into_iter().fold(to_triangle(p, q, r, s), f64::min)
}

/// Number of times that a surface winds around a point: its solid angle divided by the solid angle
/// of the sphere.
///
/// # Reference
/// Van Oosterom, Strackee, "The Solid Angle of a Plane Triangle", 1983.
pub fn winding(triangles: &[[DVec3; 3]], p: DVec3) -> f64 {
    let angle = |corners: &[DVec3; 3]| {
        let [a, b, c] = corners.map(|corner| corner - p);
        let (x, y, z) = (a.length(), b.length(), c.length());
        2.0 * a.dot(b.cross(c)).atan2(x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y)
    };
    triangles.iter().map(angle).sum::<f64>() / (4.0 * PI)
}
