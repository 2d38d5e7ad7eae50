//! Reduction of a contact patch to four points: the deepest one and three that span the largest
//! area with it. `Manifold::keep` prefers last frame's points if they span nearly as much.
//!
//! # Steps
//! 1. Keep the deepest point; of several equally deep points, the outermost.
//! 2. Take each other point as the opposite corner of the diagonal, with the farthest point on
//!    either side. Keep the pair of triangles with the largest area.
//!
//! For the corners of a convex polygon the result is exactly the largest quadrilateral with the
//! deepest point as a corner.
//!
//! # Complexity
//! O(n²) for n points, at most 65.

#![forbid(unsafe_code)]

use super::clip::{MAX_POINTS, PatchPoint};
use glam::DVec2;

/// Indices of up to four points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Choice {
    indices: [usize; 4],
    count: usize,
}

impl Choice {
    pub(super) fn indices(&self) -> &[usize] {
        &self.indices[..self.count]
    }

    pub(super) fn push(&mut self, index: usize) {
        if self.count < 4 && !self.indices().contains(&index) {
            self.indices[self.count] = index;
            self.count += 1;
        }
    }
}

/// Index of the deepest of `points`. Of those within `slight` of the deepest (a length), the one
/// farthest from their centre, since large quadrilaterals have it as a corner.
pub(super) fn deepest(points: &[PatchPoint], slight: f64) -> usize {
    let depth = points.iter().map(PatchPoint::depth).fold(f64::NEG_INFINITY, f64::max) - slight;
    let deep = || points.iter().enumerate().filter(move |(_, p)| p.depth() >= depth);
    let middle = deep().map(|(_, p)| p.at).sum::<DVec2>() / deep().count() as f64;
    let far = |p: &PatchPoint| p.at.distance_squared(middle);
    deep().fold(0, |best, (i, p)| if points[best].depth() < depth || far(p) > far(&points[best]) { i } else { best })
}

/// The four of `points` that span the largest area, or all of them if there are at most four.
/// Depths that differ by at most `slight` count as equal.
pub(super) fn choose(points: &[PatchPoint], slight: f64) -> Choice {
    let mut choice = Choice::default();
    if points.len() <= 4 {
        (0..points.len()).for_each(|i| choice.push(i));
        return choice;
    }
    let first = deepest(points, slight);
    // Close together in memory: this loop is the most expensive one of a manifold of two large
    // faces.
    let mut offsets = [DVec2::ZERO; MAX_POINTS + 1];
    for (offset, p) in offsets.iter_mut().zip(points) {
        *offset = p.at - points[first].at;
    }
    let offsets = &offsets[..points.len().min(MAX_POINTS + 1)];
    let mut greatest = (-1.0, [first; 3]);
    for (across, along) in offsets.iter().enumerate() {
        // Twice the area of the largest triangle on either side of the diagonal, and its third
        // corner; 0 if no point is on that side.
        let (mut left, mut right) = ((0.0, first), (0.0, first));
        for (i, offset) in offsets.iter().enumerate() {
            let area = along.perp_dot(*offset);
            if area > left.0 {
                left = (area, i);
            }
            if -area > right.0 {
                right = (-area, i);
            }
        }
        let area = left.0 + right.0;
        if area > greatest.0 {
            greatest = (area, [left.1, across, right.1]);
        }
    }
    choice.push(first);
    greatest.1.into_iter().for_each(|i| choice.push(i));
    choice
}

/// Area of the quadrilateral of four points in any order: the largest of the three possible orders.
pub(super) fn area([a, b, c, d]: [DVec2; 4]) -> f64 {
    let order = |p: DVec2, q: DVec2, r: DVec2, s: DVec2| 0.5 * (r - p).perp_dot(s - q).abs();
    order(a, b, c, d).max(order(a, c, b, d)).max(order(a, b, d, c))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(corners: &[DVec2], deep: usize) -> Vec<PatchPoint> {
        let point = |(i, at): (usize, &DVec2)| PatchPoint {
            at: *at,
            heights: [f64::from(u8::from(i == deep)), 0.0],
            ..Default::default()
        };
        corners.iter().enumerate().map(point).collect()
    }

    /// Compared with every quadruple that has the deepest point.
    #[test]
    fn no_other_four_points_span_a_larger_area() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 40) as f64 / 2_f64.powi(24)
        };
        for n in 5..24 {
            // Corners of a convex polygon: an ellipse at random angles in order.
            let mut angles: Vec<f64> = (0..n).map(|_| random() * std::f64::consts::TAU).collect();
            angles.sort_by(f64::total_cmp);
            let flat = random();
            let corners: Vec<DVec2> = angles.iter().map(|a| DVec2::new(a.cos(), flat * a.sin())).collect();
            let deep = (random() * n as f64) as usize % n;
            let points = points(&corners, deep);
            let chosen = choose(&points, 0.0);
            assert!(chosen.indices().len() >= 3 && chosen.indices()[0] == deep);
            let spanned = match *chosen.indices() {
                [a, b, c, d] => area([a, b, c, d].map(|i| corners[i])),
                [a, b, c] => area([a, b, c, c].map(|i| corners[i])),
                _ => 0.0,
            };
            let mut best: f64 = 0.0;
            for i in 0..n {
                for j in 0..i {
                    for k in 0..j {
                        best = best.max(area([deep, i, j, k].map(|i| corners[i])));
                    }
                }
            }
            assert!(spanned >= best * (1.0 - 1e-12), "{n} corners: {spanned} of {best}");
        }
    }

    #[test]
    fn the_order_of_four_points_does_not_matter() {
        let [a, b, c, d] = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]].map(DVec2::from_array);
        assert_eq!([area([a, b, c, d]), area([a, c, b, d]), area([b, a, c, d])], [2.0; 3]);
    }
}
