//! Vertices and faces of a hull as lists, for `bake inspect` and `bake export`.

use hullmap::Hull;
use hullmap_bake::{PointSet, hull};

/// Positions of all vertices, in the order of their indices.
pub fn positions(hull: &Hull) -> Vec<[f32; 3]> {
    hull.vertices().map(|vertex| vertex.to_array()).collect()
}

/// Vertex indices of each face, counter-clockwise seen from outside. A polygon has two faces, a
/// segment and a point have none.
///
/// A lean pack lacks the faces of large hulls, which are built again from the vertices, in the time
/// of a bake; none if these are not the vertices of a convex hull.
pub fn polygons(hull: &Hull) -> Vec<Vec<u32>> {
    if hull.face_count() > 0 || hull.rank() < 2 {
        return hull.faces().map(Iterator::collect).collect();
    }
    let built = rebuilt(hull).filter(|built| built.vertices == positions(hull));
    built.map_or_else(Vec::new, |built| built.faces)
}

/// The convex hull of a hull's vertices, as the baker builds it, if there is one.
pub fn rebuilt(hull: &Hull) -> Option<hull::Hull> {
    let positions = positions(hull);
    let points = PointSet::of_positions(positions);
    hull::build(&points).ok()
}

/// The word for a rank.
pub fn rank_name(rank: u32) -> &'static str {
    match rank {
        0 => "point",
        1 => "segment",
        2 => "flat polygon",
        _ => "solid",
    }
}

#[cfg(test)]
mod tests {
    use hullmap::Pack;
    use hullmap_bake::{IndexKind, bake_hull, write_lean_pack, write_pack};

    use super::*;

    #[test]
    fn faces_of_lean_packs_are_built_again() {
        // On a sphere, along a spiral; and a prism of 40 sides.
        let on_sphere = |i: u16| {
            let (z, turn) = (1.0 - (2.0 * f32::from(i) + 1.0) / 300.0, 2.4 * f32::from(i));
            [turn.cos() * (1.0 - z * z).sqrt(), turn.sin() * (1.0 - z * z).sqrt(), z]
        };
        let on_prism = |i: u16| {
            let turn = std::f32::consts::TAU * f32::from(i / 2) / 40.0;
            [turn.cos(), turn.sin(), f32::from(i % 2)]
        };
        for positions in [(0..300).map(on_sphere).collect::<Vec<_>>(), (0..80).map(on_prism).collect()] {
            let points = PointSet::of_positions(positions);
            let baked = bake_hull(&points, IndexKind::Tree).unwrap();
            let full = Pack::from_bytes(&write_pack(std::slice::from_ref(&baked), &Default::default()).unwrap());
            let lean = Pack::from_bytes(&write_lean_pack(vec![baked], &Default::default()).unwrap()).unwrap();
            let lean = lean.hull(0).unwrap();
            assert!(lean.is_lean() && lean.face_count() == 0);
            assert_eq!(polygons(&lean), polygons(&full.unwrap().hull(0).unwrap()));
        }
    }
}
