//! Meshes that one part represents within the error, if it may have enough vertices.

use crate::{
    fit::{Accuracy, Solid, protrusion},
    hull::{self, Hull},
    simplify::{Limit, simplify},
};
use hullmap_geometry::PointSet;

use super::Cover;

/// A number of vertices with which one part is within the maximum error; `None` if the number that
/// one of several parts may have suffices, or if no number does.
///
/// # Complexity
/// One proof, and where it succeeds, a simplified hull and a proof for each doubling of the number.
pub fn vertices_of_one_part(mesh: &PointSet, solid: &Solid, cover: &Cover) -> Option<usize> {
    one_part(hull::build(mesh).ok()?, solid, cover, usize::MAX).map(|(count, _)| count)
}

/// As [`vertices_of_one_part`], with at most `most` vertices, and the hull.
pub fn one_part(hull: Hull, solid: &Solid, cover: &Cover, most: usize) -> Option<(usize, Hull)> {
    let limit = cover.max_error.resolve(solid.diagonal());
    let is_within = |hull: &Hull| protrusion(solid, hull, &Accuracy::decide(limit)).bound <= limit;
    let mut count = cover.part_vertices() as usize;
    if most <= count || hull.vertices.len() <= count || !is_within(&hull) {
        return None;
    }
    while count < most {
        count = (2 * count).min(most);
        if count >= hull.vertices.len() {
            return Some((hull.vertices.len(), hull));
        }
        let simple = simplify(&hull, Limit::Vertices(count)).ok().flatten().map(|simple| simple.hull);
        if let Some(simple) = simple.filter(is_within) {
            return Some((count, simple));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use shapes::{concave, families::Family};

    use super::*;
    use crate::{
        decompose::decompose,
        test_meshes::{hull_of, point_set, surface_of},
    };

    #[test]
    fn the_number_of_vertices_suffices_for_one_part() {
        let mut mesh = surface_of(&hull_of(Family::Sphere.points(500, 1)));
        // A dent of 1 % of the diagonal.
        mesh.positions[7] = mesh.positions[7].map(|x| 0.96 * x);
        let cover = Cover { max_vertices: Some(64), ..Cover::default() };
        let count = vertices_of_one_part(&mesh, &Solid::new(&mesh), &cover).unwrap();
        let parts = |max_vertices| decompose(&mesh, &Cover { max_vertices, ..cover }).unwrap().map(|parts| parts.len());
        println!("{count} vertices");
        assert!((65..256).contains(&count) && parts(Some(64)).unwrap() > 1);
        assert_eq!((parts(Some(count as u32)), parts(None)), (Some(1), Some(1)));
        let concave = point_set(&concave::mug(24));
        assert_eq!(vertices_of_one_part(&concave, &Solid::new(&concave), &cover), None);
    }
}
