//! Four corners that stand for a face with more than four corners, and how steeply the surface
//! falls away from a face.
//!
//! A contact manifold has at most four points. If the four corners of the largest area lie inside
//! the other shape's face, no others support the body better. So the bake chooses them once.
//!
//! A face is a contact surface of its own by the edges that leave it. If all fall away steeply, the
//! support point close to the face's normal is a corner of the face, without a query.
//!
//! Every operation is rounded once by IEEE 754, so that results are the same everywhere.

/// The fall of a polygon, which has no edges that leave it.
pub const STEEPEST: f32 = 1.0;

/// Twice the vector area of a polygon: its direction is the normal, its length twice the area.
#[expect(clippy::indexing_slicing, reason = "`windows` returns slices of two")]
pub fn double_area(corners: &[[f64; 3]]) -> [f64; 3] {
    let Some((origin, rest)) = corners.split_first() else { return [0.0; 3] };
    rest.windows(2).fold([0.0; 3], |sum, pair| add(sum, cross(subtract(pair[0], *origin), subtract(pair[1], *origin))))
}

/// Twice the vector area of the quadrilateral a b c d: the cross product of its diagonals.
pub fn double_quad_area([a, b, c, d]: [[f64; 3]; 4]) -> [f64; 3] {
    cross(subtract(c, a), subtract(d, b))
}

/// The fall of each face with more than four corners, rounded down, from 0 to 1; [`STEEPEST`] for
/// the others: the least fall of the edges that leave it next to one of its own, around their
/// common vertex. The fall of an edge from v to w is the sine of its descent from the plane of the
/// face: (v − w) · n / |v − w|, with the unit normal n.
///
/// `faces` are a solid's faces, as indices of `positions`, counter-clockwise seen from outside.
/// `left_of` returns the face in which the second vertex follows the first. Indices out of range
/// are skipped.
///
/// # Source
/// Let s be the fall of a face. In each direction at an angle below asin s from its normal, the
/// support point is a corner of the face. At one of its corners, the directions of the edges are
/// the corners of a convex spherical polygon with one side, the face, on the equator. The part of
/// it below any latitude is convex, so along its boundary, from one end of that side to the other,
/// the latitudes first descend and then ascend. So no edge that leaves the face is closer to its
/// plane than the edges next to its own. Hence all of them descend in the given direction too, and
/// the corners of the face are a local maximum, which is the global one, since the hull is convex.
///
/// # Complexity
/// O(number of corners of all faces), with two calls of `left_of` for each. One number a face.
pub fn falls(positions: &[[f64; 3]], faces: &[&[u32]], left_of: impl Fn(u32, u32) -> Option<u32>) -> Vec<f32> {
    let mut least = vec![1.0_f64; faces.len()];
    if faces.iter().any(|face| face.len() > 4) {
        let position = |vertex: u32| positions.get(vertex as usize).copied();
        let normal = |face: &&[u32]| -> Option<[f64; 3]> {
            let corners: Vec<[f64; 3]> = face.iter().filter_map(|corner| position(*corner)).collect();
            let double = double_area(&corners);
            let length = dot(double, double).sqrt();
            (face.len() > 4).then(|| double.map(|c| c / length))
        };
        let normals: Vec<Option<[f64; 3]>> = faces.iter().map(normal).collect();
        let mut take = |face: Option<u32>, v: u32, w: u32| {
            let face = face.map_or(usize::MAX, |face| face as usize);
            if let (Some(Some(normal)), Some(least)) = (normals.get(face), least.get_mut(face))
                && let (Some(v), Some(w)) = (position(v), position(w))
            {
                let edge = subtract(v, w);
                // `min` ignores NaN, which two vertices in one place would cause.
                *least = least.min(dot(edge, *normal) / dot(edge, edge).sqrt());
            }
        };
        for face in faces.iter().filter(|face| !face.is_empty()) {
            let around = face.iter().copied().cycle();
            let triples = around.clone().skip(face.len() - 1).zip(face.iter().copied().zip(around.skip(1)));
            for (before, (corner, after)) in triples {
                take(left_of(after, corner), corner, before);
                take(left_of(corner, before), corner, after);
            }
        }
    }
    least.into_iter().map(|least| round_down(least.clamp(0.0, 1.0))).collect()
}

/// The greatest f32 that is at most `x`, for `x` from 0 to 1.
fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

/// Dot product, summed from the left.
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn subtract(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frustum(n: u32) -> (Vec<[f64; 3]>, Vec<Vec<u32>>) {
        let ring = |radius: f64, z: f64| {
            (0..n).map(move |i| {
                let turned = std::f64::consts::TAU * f64::from(i) / f64::from(n);
                [radius * turned.cos(), radius * turned.sin(), z]
            })
        };
        let side = |i: u32| {
            let next = (i + 1) % n;
            vec![i, n + i, n + next, next]
        };
        let caps = [(0..n).collect(), (n..2 * n).rev().collect()];
        (ring(1.0, 1.0).chain(ring(2.0, 0.0)).collect(), caps.into_iter().chain((0..n).map(side)).collect())
    }

    #[test]
    fn areas_and_falls_of_a_frustum() {
        let n = 12;
        let (positions, faces) = frustum(n);
        let corners: Vec<[f64; 3]> = positions[..n as usize].to_vec();
        let double = double_area(&corners);
        assert!((double[2] - 6.0).abs() < 1e-12 && double[0] == 0.0, "a regular polygon of 12 sides: {double:?}");
        let square = double_quad_area([corners[0], corners[3], corners[6], corners[9]]);
        assert!((square[2] - 4.0).abs() < 1e-12);
        let left_of = |v: u32, w: u32| {
            let has = |face: &Vec<u32>| (0..face.len()).any(|i| [face[i], face[(i + 1) % face.len()]] == [v, w]);
            faces.iter().position(has).map(|face| face as u32)
        };
        let slices: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
        let found = falls(&positions, &slices, left_of);
        // The edges that leave either end are at 45 degrees to it.
        let exact = 0.5_f64.sqrt();
        for fall in &found[..2] {
            assert!((f64::from(*fall) - exact).abs() < 1e-7, "{fall}");
        }
        assert!(found[2..].iter().all(|fall| *fall == STEEPEST), "the sides have four corners");
    }

    #[test]
    fn falls_are_rounded_down() {
        for x in [0.0, 1e-50, 0.1, 1.0 / 3.0, 0.5_f64.sqrt(), 1.0 - 1e-12, 1.0] {
            let found = round_down(x);
            assert!(f64::from(found) <= x && (found == 1.0 || f64::from(found.next_up()) > x), "{x}: {found}");
        }
    }
}
