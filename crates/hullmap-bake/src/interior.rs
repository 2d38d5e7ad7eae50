//! Interior of a hull: its centroid, and balls around it inside and around the hull.

use glam::DVec3;

use crate::{
    hull::{Hull, area::area_vector},
    mass::Mass,
};

/// Safety margin of both radii, relative to the outer radius: a thousand times the rounding error.
const SAFETY: f64 = 1e-12;

/// Starting point of a collision query, and its cheapest bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interior {
    /// The centroid.
    pub point: DVec3,
    /// Radius of a ball around the centroid that lies inside the hull; 0 below rank 3, or if the
    /// safety margin leaves no room.
    pub inner_radius: f64,
    /// Radius of a ball around the centroid that contains the hull.
    pub outer_radius: f64,
}

/// Computes the two balls around the centroid.
///
/// # Complexity
/// O(number of face corners).
pub fn interior(hull: &Hull, mass: &Mass) -> Interior {
    let point = DVec3::from_array(mass.centroid);
    let vertices: Vec<DVec3> = hull.positions().iter().map(|p| *p - point).collect();
    let outer = vertices.iter().map(|v| v.length()).fold(0.0, f64::max);
    let margin = SAFETY * outer;
    let inner = if hull.rank == 3 {
        hull.faces.iter().map(|face| distance_to_plane(face, &vertices)).fold(f64::INFINITY, f64::min) - margin
    } else {
        0.0
    };
    Interior { point, inner_radius: inner.max(0.0), outer_radius: outer + margin }
}

fn distance_to_plane(face: &[u32], vertices: &[DVec3]) -> f64 {
    area_vector(face, vertices).normalize().dot(vertices[face[0] as usize])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{mass, test_meshes::box_hull};

    #[test]
    fn balls_of_a_box() {
        let hull = box_hull([0.0; 3], [2.0, 4.0, 6.0]);
        let balls = interior(&hull, &mass::mass(&hull));
        assert!(balls.inner_radius <= 1.0 && balls.inner_radius > 1.0 - 1e-11);
        let corner = 14_f64.sqrt();
        assert!(balls.outer_radius >= corner && balls.outer_radius < corner + 1e-11);
    }
}
