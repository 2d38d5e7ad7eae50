//! A mesh is convex if its triangles lie on its hull's surface and have the same total area.

use glam::DVec3;

use crate::{hull::Hull, simplify::nearest::Nearest};
use hullmap_geometry::PointSet;

/// Maximum distance of a convex mesh's triangle behind its hull's surface, relative to the
/// diameter. It covers rounding to f32 far from the origin.
const ON_SURFACE: f64 = 1e-6;

/// Maximum difference between the areas of a convex mesh and its hull, relative to the hull's area.
const SAME_AREA: f64 = 1e-4;

/// Whether the mesh is the surface of its own hull.
pub fn is_convex(mesh: &PointSet, hull: &Hull) -> bool {
    let nearest = Nearest::new(hull);
    let at = |v: u32| DVec3::from_array(mesh.positions[v as usize].map(f64::from));
    let (mut area, mut start) = (0.0, 0);
    for [a, b, c] in mesh.triangles.iter().map(|triangle| triangle.map(at)) {
        let normal = (b - a).cross(c - a);
        area += 0.5 * normal.length();
        let normal = normal.normalize_or_zero();
        // Triangles of either orientation are accepted.
        let is_on_surface = [normal, -normal].into_iter().any(|normal| {
            start = nearest.climb(normal, start);
            normal.dot(nearest.vertex(start) - a) <= ON_SURFACE * hull.diameter
        });
        if !is_on_surface {
            return false;
        }
    }
    let whole = crate::mass::mass(hull).surface_area;
    (area - whole).abs() <= SAME_AREA * whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull;

    #[test]
    fn closed_boxes_are_convex_and_open_ones_are_not() {
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6_u32]];
        let cube = PointSet {
            triangles: quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect(),
            ..PointSet::of_positions((0..8).map(|i| [0, 1, 2].map(|axis| (i >> axis & 1) as f32)).collect())
        };
        let hull = hull::build(&cube).unwrap();
        assert!(is_convex(&cube, &hull));
        let turned =
            PointSet { triangles: cube.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect(), ..cube.clone() };
        assert!(is_convex(&turned, &hull), "inside out");
        let lidless = PointSet { triangles: cube.triangles[..10].to_vec(), ..cube.clone() };
        assert!(!is_convex(&lidless, &hull));
        let dented = PointSet { positions: [cube.positions.clone(), vec![[0.5; 3]]].concat(), ..cube };
        let mut triangles = dented.triangles.clone();
        let [a, b, c] = triangles.pop().unwrap();
        triangles.extend([[a, b, 8], [b, c, 8], [c, a, 8]]);
        assert!(!is_convex(&PointSet { triangles, ..dented }, &hull));
    }
}
