//! Convex hull of points in a plane: Andrew's monotone chain with exact predicates.
//!
//! The points are projected along the coordinate axis closest to the plane's normal: an affine map
//! without rounding error, which preserves convex hulls.

use glam::{DVec2, DVec3};

use super::area::{accurate_cross, area_vector};

/// Indices of the extreme points, counter-clockwise seen against `normal`, from the lowest. O(n log
/// n).
pub fn hull(points: &[DVec3], normal: DVec3) -> Vec<u32> {
    let axis = dropped_axis(normal);
    let flat = |p: DVec3| DVec2::new(p[(axis + 1) % 3], p[(axis + 2) % 3]);
    let dominant = normal[axis];
    let flat: Vec<DVec2> = points.iter().map(|p| flat(*p)).collect();
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_unstable_by(|&a, &b| {
        let (p, q) = (flat[a as usize], flat[b as usize]);
        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(a.cmp(&b))
    });
    let lower = chain(&flat, order.iter().copied());
    let upper = chain(&flat, order.iter().rev().copied());
    let mut outline: Vec<u32> = lower;
    outline.pop();
    outline.extend(upper);
    outline.pop();
    if dominant < 0.0 {
        outline.reverse();
    }
    let least = outline.iter().enumerate().min_by_key(|(_, v)| **v).map_or(0, |(at, _)| at);
    outline.rotate_left(least);
    outline
}

/// As [`hull`], but projected along the axis that [`side_normal`] uses for the polygon's own
/// normal. The normal of three points of a needle may have another closest axis.
pub fn hull_along_own_axis(points: &[DVec3], normal: DVec3) -> Vec<u32> {
    let mut normal = normal;
    let mut found = hull(points, normal);
    for _ in 0..MAX_AXES {
        let own = area_vector(&found, points);
        if dropped_axis(own) == dropped_axis(normal) {
            break;
        }
        normal = own;
        found = hull(points, normal);
    }
    found
}

/// Maximum number of projections tried: the axes to which a polygon's normal may be closest.
const MAX_AXES: usize = 3;

/// Unit vector in the plane of the polygon with unit `normal`, pointing out of the side along
/// `edge`.
///
/// Points may be farther from the plane than from each other. The edge is therefore projected into
/// the plane along the axis that [`hull`] dropped, so that the turns between sides are as exact as
/// the predicates that chose the hull.
pub fn side_normal(edge: DVec3, normal: DVec3) -> DVec3 {
    let axis = dropped_axis(normal);
    let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
    let mut along = edge;
    along[axis] = -(normal[i] * edge[i] + normal[j] * edge[j]) / normal[axis];
    accurate_cross(along, normal).normalize_or_zero()
}

/// The first axis to which the normal is closest, to within rounding error: the same for any
/// corners of the plane.
fn dropped_axis(normal: DVec3) -> usize {
    /// Components of at least this fraction of the largest count as equally large.
    const AS_GREAT: f64 = 1.0 - 1e-9;
    let size = normal.abs();
    let greatest = size.max_element();
    (0..3).find(|axis| size[*axis] >= AS_GREAT * greatest).unwrap_or(0)
}

/// The chain through the points in this order that turns strictly left at every point.
fn chain(flat: &[DVec2], order: impl Iterator<Item = u32>) -> Vec<u32> {
    let coord = |i: u32| robust::Coord { x: flat[i as usize].x, y: flat[i as usize].y };
    let mut chain: Vec<u32> = Vec::new();
    for p in order {
        while let [.., a, b] = chain[..] {
            if robust::orient2d(coord(a), coord(b), coord(p)) > 0.0 {
                break;
            }
            chain.pop();
        }
        // Points that differ only in the dropped coordinate coincide here.
        if chain.last().is_none_or(|&last| flat[last as usize] != flat[p as usize]) {
            chain.push(p);
        }
    }
    chain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_with_points_on_its_edges() {
        let mut points = Vec::new();
        for x in 0..4 {
            for y in 0..4 {
                points.push(DVec3::new(f64::from(x), 7.0, f64::from(y)));
            }
        }
        let outline = hull(&points, DVec3::Y);
        assert_eq!(outline, [0, 3, 15, 12], "counter-clockwise seen from +y");
        let back = hull(&points, DVec3::NEG_Y);
        assert_eq!(back, [0, 12, 15, 3]);
    }
}
