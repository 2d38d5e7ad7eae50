//! Outer hull (14-DOP): a coarse polytope that contains a hull, for yes/no queries to test first.
//!
//! The intersection of fourteen half-spaces: the bounding box's six, and eight that cut off its
//! corners. Only its vertices, at most 24, are stored.
//!
//! # Reference
//! Klosowski et al., "Efficient Collision Detection Using Bounding Volume Hierarchies of k-DOPs",
//! 1998. Kenwright, section 5 ("a cube-cube, then a low-poly and finally the higher poly-mesh").
//!
//! # Steps
//! 1. Use coordinates in which the bounding box is the cube [-1, 1]³, so that the planes cut long
//!    hulls as well as round ones.
//! 2. Compute the supporting planes in the fourteen directions, and push them outward by more than
//!    rounding to f32 can move a vertex inward.
//! 3. Intersect every three planes. The vertices are the points behind all planes, within rounding
//!    error: more points only enlarge the polytope.
//! 4. Certify with exact predicates that the rounded vertices' hull contains the hull. If not, push
//!    the planes further.

use std::collections::BTreeSet;

use glam::{DMat3, DVec3};

use crate::hull::{
    self, Hull,
    quickhull::{FILTER, exact_above, magnitude},
};
use hullmap_geometry::{PointSet, bounds};

/// Hulls with at most this many vertices have no outer hull, because it would be no simpler.
const COARSE_ENOUGH: usize = 32;

/// Maximum number of vertices, which is the reader's limit.
const MAX_VERTICES: usize = hullmap_format::check::MAX_OUTER_VERTICES;

/// Initial relative push of the planes. Rounding to f32 moves a coordinate by up to 6e-8 of itself.
const MARGIN: f64 = 4e-7;

/// Number of margins tried, each four times the previous one, before the hull gets no outer hull.
const MAX_TRIES: u32 = 8;

/// Maximum distance in front of a plane, in scaled coordinates, that counts as behind it.
const BEHIND: f64 = 1e-9;

/// Minimum determinant of three planes that meet in a point; here, it is 0 or at least 1.
const MEET: f64 = 0.5;

/// Axes of the normals, in coordinates in which the box is a cube; each axis gives two normals.
const AXES: [DVec3; 7] = [
    DVec3::X,
    DVec3::Y,
    DVec3::Z,
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(1.0, 1.0, -1.0),
    DVec3::new(1.0, -1.0, 1.0),
    DVec3::new(-1.0, 1.0, 1.0),
];

/// The vertices of a coarse polytope that contains `hull`, in a fixed order. Empty if the hull is
/// coarse, or if none can be certified.
///
/// # Complexity
/// O(n): fourteen dot products and about thirty exact predicates per vertex.
pub fn outer(hull: &Hull) -> Vec<[f32; 3]> {
    if hull.vertices.len() <= COARSE_ENOUGH {
        return Vec::new();
    }
    let positions = hull.positions();
    let tries = (0..MAX_TRIES).map(|tried| MARGIN * 4_f64.powi(tried as i32));
    let polytopes = tries.map(|margin| polytope(&positions, margin));
    polytopes.into_iter().find(|outer| outer.len() <= MAX_VERTICES && holds(outer, &positions)).unwrap_or_default()
}

fn polytope(positions: &[DVec3], margin: f64) -> Vec<[f32; 3]> {
    let [low, high] = bounds(positions.iter().copied());
    let push = margin * low.abs().max(high.abs()).max_element();
    let center = (low + high) * 0.5;
    let half = (high - low) * 0.5 + DVec3::splat(push);
    let pushed = DVec3::splat(push) / half;
    let planes: Vec<(DVec3, f64)> = AXES
        .iter()
        .flat_map(|axis| [*axis, -*axis])
        .map(|n| {
            let height = positions.iter().map(|p| n.dot((*p - center) / half)).fold(f64::NEG_INFINITY, f64::max);
            (n, height + n.abs().dot(pushed))
        })
        .collect();
    let mut vertices = BTreeSet::new();
    for (i, a) in planes.iter().enumerate() {
        for (j, b) in planes[..i].iter().enumerate() {
            for c in &planes[..j] {
                let m = DMat3::from_cols(a.0, b.0, c.0).transpose();
                if m.determinant().abs() < MEET {
                    continue;
                }
                let p = m.inverse() * DVec3::new(a.1, b.1, c.1);
                if planes.iter().all(|(n, height)| n.dot(p) <= height + BEHIND) {
                    // Sorted by their bits: any fixed order will do.
                    vertices.insert((center + p * half).to_array().map(|c| (c as f32 + 0.0).to_bits()));
                }
            }
        }
    }
    vertices.into_iter().map(|bits| bits.map(f32::from_bits)).collect()
}

pub(crate) fn holds(outer: &[[f32; 3]], positions: &[DVec3]) -> bool {
    let points = PointSet::of_positions(outer.to_vec());
    let Ok(solid) = hull::build(&points) else { return false };
    let corners = solid.positions();
    let [low, high] = bounds(positions.iter().chain(&corners).copied());
    let is_behind = |face: &Vec<u32>| {
        let [a, b, c] = [0, 1, 2].map(|i| corners[face[i] as usize]);
        let normal = (b - a).cross(c - a);
        // No point is farther from a corner along any axis than the box is wide.
        let error = FILTER * magnitude(a, b, c).dot(high - low);
        positions.iter().all(|p| {
            let height = normal.dot(*p - a);
            // Written so that NaN is decided exactly.
            if height.abs() > error { height < 0.0 } else { exact_above(a, b, c, *p) <= 0.0 }
        })
    };
    solid.rank == 3 && solid.faces.iter().all(is_behind)
}

#[cfg(test)]
mod tests {
    use shapes::families::Family;

    use super::*;
    use crate::test_meshes::hull_of;

    /// Support values check containment independently, and that the polytope is tight.
    #[test]
    fn contains_the_hull_and_fits_its_box() {
        let mut rng = shapes::rng::SplitMix64::new(5);
        for family in Family::ALL {
            for far in [0.0_f32, 1000.0] {
                let points: Vec<[f32; 3]> = family.points(300, 1).iter().map(|p| [p[0] + far, p[1], p[2]]).collect();
                let hull = hull_of(points);
                let outer = outer(&hull);
                if hull.vertices.len() <= COARSE_ENOUGH {
                    assert!(outer.is_empty());
                    continue;
                }
                assert!((4..=24).contains(&outer.len()), "{family:?}: {}", outer.len());
                let reach = |points: &[[f32; 3]], d: [f64; 3]| {
                    let dots = points.iter().map(|p| DVec3::from_array(p.map(f64::from)).dot(DVec3::from_array(d)));
                    dots.fold(f64::NEG_INFINITY, f64::max)
                };
                for _ in 0..500 {
                    let d = rng.direction();
                    assert!(reach(&outer, d) >= reach(&hull.vertices, d), "{family:?}");
                }
                for axis in [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]] {
                    let room = reach(&outer, axis) - reach(&hull.vertices, axis);
                    assert!(room <= 3e-6 * (1.0 + f64::from(far)), "{family:?}: {room:e}");
                }
            }
        }
    }

    #[test]
    fn a_ball_has_an_outer_hull_of_24_vertices() {
        let outer = outer(&hull_of(Family::Sphere.points(2_000, 1)));
        assert_eq!(outer.len(), 24);
    }
}
