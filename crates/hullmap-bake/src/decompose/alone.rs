//! Meshes that only the maximum number of vertices divides.

use crate::{
    fit::{Accuracy, Solid, protrusion},
    hull::{self, Hull},
    simplify::{Limit, simplify},
};
use hullmap_geometry::PointSet;

use super::Cover;

/// A number of vertices with which one part is within the maximum error; `None` if the allowed
/// number suffices, or if no number does.
///
/// # Complexity
/// One proof, and where it succeeds, a simplified hull and a proof for each doubling of the number.
pub fn vertices_of_one_part(mesh: &PointSet, solid: &Solid, cover: &Cover) -> Option<usize> {
    let hull = hull::build(mesh).ok()?;
    let limit = cover.max_error.resolve(solid.diagonal());
    let is_within = |hull: &Hull| protrusion(solid, hull, &Accuracy::decide(limit)).bound <= limit;
    let mut count = cover.max_vertices as usize;
    if hull.vertices.len() <= count || !is_within(&hull) {
        return None;
    }
    loop {
        count *= 2;
        if count >= hull.vertices.len() {
            return Some(hull.vertices.len());
        }
        if simplify(&hull, Limit::Vertices(count)).ok().flatten().is_some_and(|simple| is_within(&simple.hull)) {
            return Some(count);
        }
    }
}

#[cfg(test)]
mod tests {
    use shapes::{concave, families::Family};

    use super::*;
    use crate::decompose::{decompose, tests::point_set};

    #[test]
    fn the_number_of_vertices_suffices_for_one_part() {
        let ball = hull::build(&PointSet::of_positions(Family::Sphere.points(500, 1))).unwrap();
        let fan = |face: &Vec<u32>| (1..face.len() - 1).map(|i| [face[0], face[i], face[i + 1]]).collect::<Vec<_>>();
        let triangles = ball.faces.iter().flat_map(fan).collect();
        let mut mesh = PointSet { triangles, ..PointSet::of_positions(ball.vertices) };
        // A dent of 1 % of the diagonal.
        mesh.positions[7] = mesh.positions[7].map(|x| 0.96 * x);
        let cover = Cover::default();
        let count = vertices_of_one_part(&mesh, &Solid::new(&mesh), &cover).unwrap();
        let parts =
            |max_vertices: u32| decompose(&mesh, &Cover { max_vertices, ..cover }).unwrap().map(|parts| parts.len());
        println!("{count} vertices");
        assert!(count > 64 && parts(64).unwrap() > 1 && parts(count as u32) == Some(1));
        let concave = point_set(&concave::mug(24));
        assert_eq!(vertices_of_one_part(&concave, &Solid::new(&concave), &cover), None);
    }
}
