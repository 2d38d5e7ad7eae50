//! Points on the faces of a body, large faces first, and points spread over a surface.

use glam::DVec3;
use hullmap_geometry::triangle::halves;

use super::body::Body;
use crate::spread::spread;

/// Up to `count` points on the faces of a body: middles of triangles, which are halved along their
/// longest edges, the largest first, down to edges of length `spacing`.
pub fn face_points(body: &Body, count: usize, spacing: f64) -> Vec<DVec3> {
    let size =
        |t: &[DVec3; 3]| t[0].distance_squared(t[1]).max(t[1].distance_squared(t[2])).max(t[2].distance_squared(t[0]));
    let mut level: Vec<[DVec3; 3]> = body.triangles.clone();
    let area = |t: &[DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).length_squared();
    let mut found = Vec::with_capacity(count);
    let enough = spacing * spacing;
    while !level.is_empty() && found.len() < count {
        level.sort_by(|a, b| area(b).total_cmp(&area(a)));
        let mut next = Vec::new();
        for t in &level {
            if found.len() >= count {
                break;
            }
            found.push((t[0] + t[1] + t[2]) / 3.0);
            if size(t) > enough {
                next.extend(halves(t).into_iter().flat_map(|half| halves(&half)));
            }
        }
        level = next;
    }
    found
}

/// About one point for each `area` of the triangles, each with the index of its triangle.
pub fn spread_points(triangles: impl Iterator<Item = [DVec3; 3]>, area: f64) -> Vec<(usize, DVec3)> {
    let mut found = Vec::new();
    let mut owed = 0.5;
    for (index, [a, b, c]) in triangles.enumerate() {
        let (u, v) = (b - a, c - a);
        owed += 0.5 * u.cross(v).length() / area;
        // Written so that NaN and infinity give no points.
        let count = if owed < MOST { owed as usize } else { 0 };
        owed -= count as f64;
        for k in 0..count {
            let [s, t, _] = spread(k);
            let [s, t] = if s + t > 1.0 { [1.0 - s, 1.0 - t] } else { [s, t] };
            found.push((index, a + u * s + v * t));
        }
    }
    found
}

const MOST: f64 = 1e5;
