//! The four corners that stand for each face with more than four: those that span the largest area.
//!
//! # Steps
//! 1. Project the face along the axis closest to its normal. Ratios of areas stay the same.
//! 2. Among at most 1,024 corners, evenly chosen, find the four that span the largest area: for
//!    each diagonal, the farthest corner on either side.
//! 3. Exchange one of the four for any corner of the face while the area grows, which repairs
//!    rounding errors of nearly collinear corners.
//!
//! Up to 1,024 corners, the result is the largest quadrilateral. It always has at least half of the
//! face's area: each corner is the farthest from the diagonal between its neighbours, so the face
//! lies in the parallelogram with sides parallel to the diagonals, which has twice the area.
//!
//! # Complexity
//! O(n²) for n corners up to 1,024, and O(n) beyond.

use glam::DVec2;
use hullmap_format::{
    archive::Quad,
    quad::{STEEPEST, double_area, falls},
};

use super::{Hull, adjacency::Adjacency};

/// Maximum number of corners among which the four are searched exhaustively.
const MAX_CANDIDATES: usize = 1024;

/// Maximum number of rounds of exchanges. One or two are usual.
const MAX_ROUNDS: usize = 64;

/// The entry of each face with more than four corners, in order of the faces of `hull`.
pub fn quads(hull: &Hull, adjacency: &Adjacency) -> Vec<Quad> {
    if hull.faces.iter().all(|face| face.len() <= 4) {
        return Vec::new();
    }
    let positions: Vec<[f64; 3]> = hull.vertices.iter().map(|v| v.map(f64::from)).collect();
    let left_of = |v: u32, w: u32| adjacency.left_of(v, w);
    let faces: Vec<&[u32]> = hull.faces.iter().map(Vec::as_slice).collect();
    let falls = if hull.rank == 3 { falls(&positions, &faces, left_of) } else { vec![STEEPEST; faces.len()] };
    let large = (0..faces.len()).filter(|face| faces[*face].len() > 4);
    large
        .map(|face| {
            let corners: Vec<[f64; 3]> = faces[face].iter().map(|v| positions[*v as usize]).collect();
            Quad { face: face as u32, corners: largest(&project(&corners)), fall: falls[face] }
        })
        .collect()
}

/// The corners without the coordinate in which their normal is longest, in counter-clockwise order.
fn project(corners: &[[f64; 3]]) -> Vec<DVec2> {
    let normal = double_area(corners);
    let axis = (0..3).fold(0, |axis, next| if normal[next].abs() > normal[axis].abs() { next } else { axis });
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let side = normal[axis].signum();
    // Relative to a corner: the differences of nearby f32 are exact.
    let origin = corners[0];
    corners.iter().map(|p| DVec2::new((p[u] - origin[u]) * side, p[v] - origin[v])).collect()
}

/// Positions, ascending, of the four corners of a convex polygon that span the largest area. The
/// polygon is counter-clockwise and has more than four corners.
fn largest(corners: &[DVec2]) -> [u32; 4] {
    let n = corners.len();
    let step = n.div_ceil(MAX_CANDIDATES);
    let candidates: Vec<usize> = (0..n).step_by(step).collect();
    let points: Vec<DVec2> = candidates.iter().map(|at| corners[*at]).collect();
    let mut best = of_diagonals(&points).map(|at| candidates[at]);
    improve(corners, &mut best);
    best.sort_unstable();
    best.map(|at| at as u32)
}

/// The four points that span the largest area, by trying all diagonals. While a diagonal turns
/// about its first end, the farthest points on either side advance.
fn of_diagonals(points: &[DVec2]) -> [usize; 4] {
    let n = points.len();
    let mut best = (f64::NEG_INFINITY, [0, 1, 2, 3]);
    for i in 0..n {
        let (mut right, mut left) = (i + 1, i + 3);
        for k in i + 2..(i + n - 1).min(n) {
            let along = points[k] - points[i];
            let height = |at: usize| along.perp_dot(points[at % n] - points[i]);
            while right + 1 < k && -height(right + 1) > -height(right) {
                right += 1;
            }
            left = left.max(k + 1);
            while left + 1 < i + n && height(left + 1) > height(left) {
                left += 1;
            }
            let area = height(left) - height(right);
            if area > best.0 {
                best = (area, [i, right, k, left % n]);
            }
        }
    }
    best.1
}

fn improve(corners: &[DVec2], quad: &mut [usize; 4]) {
    for _ in 0..MAX_ROUNDS {
        let mut grew = false;
        for at in 0..4 {
            let [from, to] = [quad[(at + 3) % 4], quad[(at + 1) % 4]];
            let along = corners[to] - corners[from];
            let depth = |corner: usize| -along.perp_dot(corners[corner] - corners[from]);
            let farthest = (0..corners.len()).fold(quad[at], |best, i| if depth(i) > depth(best) { i } else { best });
            if depth(farthest) > depth(quad[at]) * (1.0 + 1e-12) {
                quad[at] = farthest;
                grew = true;
            }
        }
        if !grew {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use shapes::rng::SplitMix64;

    use super::*;

    fn area(corners: &[DVec2], quad: [u32; 4]) -> f64 {
        let [a, b, c, d] = quad.map(|at| corners[at as usize]);
        (c - a).perp_dot(d - b)
    }

    fn polygon(n: usize, flat: f64, seed: u64) -> Vec<DVec2> {
        let mut rng = SplitMix64::new(seed);
        let mut angles: Vec<f64> = (0..n).map(|_| rng.unit() * std::f64::consts::TAU).collect();
        angles.sort_by(f64::total_cmp);
        angles.dedup();
        let turned = DVec2::from_angle(rng.unit());
        angles.iter().map(|a| turned.rotate(DVec2::new(a.cos(), flat * a.sin()))).collect()
    }

    #[test]
    fn no_other_four_corners_span_a_larger_area() {
        for seed in 0..200 {
            let corners = polygon(5 + seed % 12, [1.0, 0.3, 1e-3][seed % 3], seed as u64);
            let found = largest(&corners);
            assert!(found.is_sorted_by(|a, b| a < b), "{found:?}");
            let n = corners.len() as u32;
            let mut best: f64 = 0.0;
            for a in 0..n {
                for b in a + 1..n {
                    for c in b + 1..n {
                        for d in c + 1..n {
                            best = best.max(area(&corners, [a, b, c, d]));
                        }
                    }
                }
            }
            assert!(area(&corners, found) >= best * (1.0 - 1e-12), "seed {seed}: {} of {best}", area(&corners, found));
        }
    }

    #[test]
    fn four_corners_of_many_span_two_thirds_of_an_ellipse() {
        for (n, flat) in [(1024, 1.0), (1025, 1.0), (5000, 0.01), (20_000, 1e-4)] {
            let corners = polygon(n, flat, 7);
            let found = largest(&corners);
            // An ellipse is the convex figure whose largest quadrilateral is smallest: 2/π.
            let share = 0.5 * area(&corners, found) / (std::f64::consts::PI * flat);
            assert!(share > 0.63, "{n} corners, {flat}: {share}");
        }
    }

    #[test]
    fn collinear_corners_do_not_stop_the_search() {
        // The sides of a square, with ten corners each that are on a line up to rounding.
        let sides = [DVec2::new(1.0, 1.0), DVec2::new(-1.0, 1.0), DVec2::new(-1.0, -1.0), DVec2::new(1.0, -1.0)];
        let on_side = |side: usize| (0..10).map(move |i| sides[side].lerp(sides[(side + 1) % 4], f64::from(i) / 10.0));
        let corners: Vec<DVec2> = (0..4).flat_map(on_side).collect();
        assert_eq!(largest(&corners), [0, 10, 20, 30]);
    }
}
