//! Vertices and faces of a hull as lists, as `bake inspect` prints them and `bake export` writes
//! them.

use hullmap::Hull;

/// Positions of all vertices, in the order of their indices.
pub fn positions(hull: &Hull) -> Vec<[f32; 3]> {
    hull.vertices().map(|vertex| vertex.to_array()).collect()
}

/// Vertex indices of each face, counter-clockwise seen from outside. A polygon has two faces, a
/// segment and a point have none.
pub fn polygons(hull: &Hull) -> Vec<Vec<u32>> {
    hull.faces().map(Iterator::collect).collect()
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
