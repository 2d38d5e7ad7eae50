//! Truths about points with whole coordinates, in integers without rounding.

use std::cmp::Ordering;

/// A point or a vector with whole coordinates.
pub type Whole = [i128; 3];

fn minus(a: Whole, b: Whole) -> Whole {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Whole, b: Whole) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Whole, b: Whole) -> Whole {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Whether a triangle and a solid with these vertices are apart (`Greater`), share points of the
/// solid's surface alone (`Equal`), or of its inside (`Less`).
///
/// The axes are the normals of all triangles of vertices, and the cross products of all edges of
/// the triangle and segments of the solid. They include the normals of all faces of the Minkowski
/// difference.
pub fn gap(triangle: &[Whole; 3], solid: &[Whole]) -> Ordering {
    let [a, b, c] = *triangle;
    let sides = [minus(b, a), minus(c, b), minus(a, c)];
    let mut axes = vec![cross(sides[0], sides[1])];
    for (i, p) in solid.iter().enumerate() {
        for (j, q) in solid.iter().enumerate().take(i) {
            let segment = minus(*p, *q);
            axes.extend(sides.iter().map(|side| cross(*side, segment)));
            axes.extend(solid.iter().take(j).map(|r| cross(segment, minus(*p, *r))));
        }
    }
    let mut greatest = Ordering::Less;
    for axis in axes.into_iter().filter(|axis| *axis != [0; 3]) {
        let range = |points: &[Whole]| {
            let heights = || points.iter().map(|point| dot(axis, *point));
            (heights().min().unwrap_or_default(), heights().max().unwrap_or_default())
        };
        let ((low, high), (least, most)) = (range(triangle), range(solid));
        greatest = greatest.max((least - high).max(low - most).cmp(&0));
    }
    greatest
}

/// Where the ray from `origin` along `dir` meets a closed triangle: `None` if it does not; the t is
/// off by the rounding of one quotient. A ray in the plane of the triangle meets nothing here, and
/// the flag is true.
pub fn entry(triangle: &[Whole; 3], origin: Whole, dir: Whole) -> (Option<f64>, bool) {
    let [a, b, c] = triangle.map(|corner| minus(corner, origin));
    let volume = |p: Whole, q: Whole, r: Whole| dot(p, cross(q, r));
    let speed = dot(dir, cross(minus(b, a), minus(c, a)));
    if speed == 0 {
        return (None, true);
    }
    let volumes = [volume(dir, c, b), volume(dir, a, c), volume(dir, b, a)];
    let is_inside = volumes.iter().all(|v| *v >= 0) || volumes.iter().all(|v| *v <= 0);
    let height = volume(a, minus(b, a), minus(c, a));
    let t = height as f64 / speed as f64;
    ((is_inside && (height == 0 || (height > 0) == (speed > 0))).then_some(t), false)
}
