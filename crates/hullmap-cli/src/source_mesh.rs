//! The faces of a source mesh as triangles and edges for a page to draw.

use hullmap_import::Polygons;
use hullmap_report::DisplayMesh;

/// Mesh of a point set: its faces if there are any, otherwise its points. Complexity: O(corners),
/// except for concave polygons.
pub fn display_mesh(points: &[[f32; 3]], faces: &Polygons) -> DisplayMesh {
    let triangles = faces.triangles(points);
    let mut mesh = DisplayMesh { points: points.to_vec(), triangles, ..DisplayMesh::default() };
    for face in 0..faces.len() {
        let corners = &faces.corners[faces.start(face)..faces.start(face + 1)];
        for (i, &from) in corners.iter().enumerate() {
            let to = corners[(i + 1) % corners.len()];
            if from != to {
                mesh.edges.push([from.min(to), from.max(to)]);
            }
        }
    }
    mesh.edges.sort_unstable();
    mesh.edges.dedup();
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_match_the_faces() {
        let points = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [1.0, 1.0, 5.0], [0.0, 1.0, 5.0], [2.0, 2.0, 2.0]];
        let mut faces = Polygons::default();
        faces.push(&[0, 1, 2, 3]);
        faces.push(&[2, 1, 4]);
        let mesh = display_mesh(&points, &faces);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [2, 1, 4]]);
        assert_eq!(mesh.edges, [[0, 1], [0, 3], [1, 2], [1, 4], [2, 3], [2, 4]]);
        assert!(display_mesh(&points, &Polygons::default()).triangles.is_empty());
    }
}
