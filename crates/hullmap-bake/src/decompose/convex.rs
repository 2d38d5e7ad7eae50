//! A mesh is convex if its triangles lie on its hull's surface and have the same total area.

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
    let (mut area, mut start) = (0.0, 0);
    for [a, b, c] in mesh.triangles.iter().map(|triangle| mesh.corners(triangle)) {
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
    use crate::{
        hull,
        test_meshes::{block, inside_out, open_block},
    };

    #[test]
    fn closed_boxes_are_convex_and_open_ones_are_not() {
        let cube = block([0.0; 3], [1.0; 3]);
        let hull = hull::build(&cube).unwrap();
        assert!(is_convex(&cube, &hull));
        assert!(is_convex(&inside_out(cube.clone()), &hull));
        assert!(!is_convex(&open_block([0.0; 3], [1.0; 3]), &hull));
        let mut dented = cube;
        dented.positions.push([0.5; 3]);
        let [a, b, c] = dented.triangles.pop().unwrap();
        dented.triangles.extend([[a, b, 8], [b, c, 8], [c, a, 8]]);
        assert!(!is_convex(&dented, &hull));
    }
}
