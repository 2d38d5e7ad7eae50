//! The faces of a source mesh, to look at.
//!
//! Polygons are cut into triangles by ears, so that concave ones look as they are (Meisters, "Polygons have ears", 1975).
//! Nothing of this touches what is baked or verified.

use super::shape::Shape;
use crate::import::Polygons;
use crate::source::Source;

/// Most corners of a concave polygon that is cut by ears, which takes their number squared for each.
const MAX_EAR_CORNERS: usize = 512;

/// The source of each hull: its faces where the file has any, else its points.
///
/// # Complexity
/// O(corners), but for concave polygons.
pub fn source_shapes(source: &Source) -> Vec<Shape> {
    let pairs = source.point_sets.iter().zip(&source.faces);
    pairs.map(|(set, faces)| shape(&set.positions, faces)).collect()
}

fn shape(points: &[[f32; 3]], faces: &Polygons) -> Shape {
    let mut shape = Shape { points: points.to_vec(), ..Shape::default() };
    for number in 0..faces.len() {
        let corners = &faces.corners[faces.start(number)..faces.start(number + 1)];
        for (i, &from) in corners.iter().enumerate() {
            let to = corners[(i + 1) % corners.len()];
            if from != to {
                shape.edges.push([from.min(to), from.max(to)]);
            }
        }
        triangulate(corners, points, &mut shape.triangles);
    }
    shape.edges.sort_unstable();
    shape.edges.dedup();
    shape
}

/// Cuts a polygon into triangles: ears where it is concave, a fan where it is not, or where no ears are found.
fn triangulate(corners: &[u32], points: &[[f32; 3]], out: &mut Vec<[u32; 3]>) {
    let flat = flattened(corners, points);
    let count = corners.len();
    let is_convex = (0..count).all(|i| turn(flat[(i + count - 1) % count], flat[i], flat[(i + 1) % count]) >= 0.0);
    let first = out.len();
    if !is_convex && count <= MAX_EAR_CORNERS && cut_ears(&flat, corners, out) {
        return;
    }
    out.truncate(first);
    out.extend(corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]));
}

/// Whether ears could be cut until nothing was left.
fn cut_ears(flat: &[[f64; 2]], corners: &[u32], out: &mut Vec<[u32; 3]>) -> bool {
    let mut rest: Vec<usize> = (0..flat.len()).collect();
    while rest.len() > 3 {
        let count = rest.len();
        let around = |i: usize| [rest[(i + count - 1) % count], rest[i], rest[(i + 1) % count]];
        let is_ear = |&i: &usize| {
            let [a, b, c] = around(i);
            let holds = |&p: &usize| {
                let inside = |from: usize, to: usize| turn(flat[from], flat[to], flat[p]) >= 0.0;
                // A corner in the same place, where a polygon touches itself, is no obstacle.
                [a, b, c].iter().all(|&corner| flat[corner] != flat[p]) && inside(a, b) && inside(b, c) && inside(c, a)
            };
            turn(flat[a], flat[b], flat[c]) > 0.0 && !rest.iter().any(holds)
        };
        let Some(ear) = (0..count).find(is_ear) else { return false };
        out.push(around(ear).map(|i| corners[i]));
        rest.remove(ear);
    }
    out.push([rest[0], rest[1], rest[2]].map(|i| corners[i]));
    true
}

/// The corners in the plane of two axes in which the polygon is largest, counter-clockwise.
fn flattened(corners: &[u32], points: &[[f32; 3]]) -> Vec<[f64; 2]> {
    let at = |i: usize| points[corners[i % corners.len()] as usize].map(f64::from);
    // Newell's normal, from the first corner.
    let origin = at(0);
    let mut normal = [0.0; 3];
    for i in 0..corners.len() {
        let [a, b] = [at(i), at(i + 1)].map(|p| [0, 1, 2].map(|axis| p[axis] - origin[axis]));
        for (axis, sum) in normal.iter_mut().enumerate() {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            *sum += a[u] * b[v] - a[v] * b[u];
        }
    }
    let axis = (0..3).fold(0, |best, next| if normal[next].abs() > normal[best].abs() { next } else { best });
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let sign = if normal[axis] < 0.0 { -1.0 } else { 1.0 };
    (0..corners.len()).map(at).map(|p| [p[u] * sign, p[v]]).collect()
}

/// Positive where a path turns left.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> f64 {
        let at = |corner: u32| glam::Vec3::from_array(points[corner as usize]).as_dvec3();
        triangles.iter().map(|&[a, b, c]| (at(b) - at(a)).cross(at(c) - at(a)).length() / 2.0).sum()
    }

    /// A star lies in a plane that is seen from both sides; a fan from its first corner would cover more than its area.
    #[test]
    fn concave_polygons_keep_their_area() {
        for (sides, mirror) in [(5, 1.0), (5, -1.0), (40, 1.0)] {
            let corner = |i: usize| {
                let angle = std::f64::consts::PI * (i as f64 + 0.3) / sides as f64;
                let radius = if i.is_multiple_of(2) { 1.0 } else { 0.4 };
                [0.2, (radius * angle.cos()) as f32, mirror * (radius * angle.sin()) as f32]
            };
            let points: Vec<[f32; 3]> = (0..2 * sides).map(corner).collect();
            let corners: Vec<u32> = (0..points.len() as u32).collect();
            let mut triangles = Vec::new();
            triangulate(&corners, &points, &mut triangles);
            assert_eq!(triangles.len(), 2 * sides - 2);
            let expected = sides as f64 * 0.4 * (std::f64::consts::PI / sides as f64).sin();
            assert!((area(&points, &triangles) - expected).abs() < 1e-6, "{sides}");
        }
    }

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

    #[test]
    fn odd_polygons_do_not_trip_it() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.5, 0.0, 0.0], [1.0, 1.0, 0.0]];
        for corners in [&[0, 0, 0, 0][..], &[0, 1, 2, 1], &[0, 1], &[3], &[0, 3, 1, 2, 2, 0, 3]] {
            let mut triangles = Vec::new();
            triangulate(corners, &points, &mut triangles);
            assert!(triangles.len() <= corners.len());
        }
    }
}
