//! The faces of a source mesh, to look at.

use super::shape::Shape;
use crate::source::Source;
use hullmap_import::Polygons;

/// The source of each hull: its faces where the file has any, else its points.
///
/// # Complexity
/// O(corners), but for concave polygons.
pub fn source_shapes(source: &Source) -> Vec<Shape> {
    let pairs = source.point_sets.iter().zip(&source.faces);
    pairs.map(|(set, faces)| shape(&set.positions, faces)).collect()
}

fn shape(points: &[[f32; 3]], faces: &Polygons) -> Shape {
    let mut shape = Shape { points: points.to_vec(), triangles: faces.triangles(points), ..Shape::default() };
    for number in 0..faces.len() {
        let corners = &faces.corners[faces.start(number)..faces.start(number + 1)];
        for (i, &from) in corners.iter().enumerate() {
            let to = corners[(i + 1) % corners.len()];
            if from != to {
                shape.edges.push([from.min(to), from.max(to)]);
            }
        }
    }
    shape.edges.sort_unstable();
    shape.edges.dedup();
    shape
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_those_of_faces() {
        let points = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [1.0, 1.0, 5.0], [0.0, 1.0, 5.0], [2.0, 2.0, 2.0]];
        let mut faces = Polygons::default();
        faces.push(&[0, 1, 2, 3]);
        faces.push(&[2, 1, 4]);
        let shape = shape(&points, &faces);
        assert_eq!(shape.triangles, [[0, 1, 2], [0, 2, 3], [2, 1, 4]]);
        assert_eq!(shape.edges, [[0, 1], [0, 3], [1, 2], [1, 4], [2, 3], [2, 4]]);
        assert!(super::shape(&points, &Polygons::default()).triangles.is_empty());
    }
}
