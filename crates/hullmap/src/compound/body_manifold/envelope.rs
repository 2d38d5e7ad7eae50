//! How far a contact point that is left out may sink in below the chosen ones.
//!
//! A small motion of a body changes the depths of its points by an affine function of their places
//! in the plane of contact. If it pushes all chosen points out, it pushes a point between them out
//! by at least the height of the concave envelope of their depths there: the greatest mean of
//! chosen depths whose places have their mean there. A point that is deeper stays in, by at most
//! the difference.

#![forbid(unsafe_code)]

use glam::DVec2;

use crate::manifold::select::{Rest, Spot};

/// Share by which a place is moved towards the middle of the chosen points: a point between two
/// corners is often beside their edge, but for rounding or a slight ear.
const TOWARDS_MIDDLE: f64 = 0.01;

/// How far `point` is below the envelope of the chosen points: `polygon` has the corners of their
/// convex hull, in order, and `others` are between them. 0 if that is at most `slight`, and if the
/// point is not between them. `spot` returns the point of an index.
///
/// # Complexity
/// O(n²) for n chosen points, and O(n) if a triangle of corners is deep enough.
pub(super) fn below(point: Spot, [polygon, others]: [&[usize]; 2], spot: impl Fn(usize) -> Spot, slight: f64) -> f64 {
    let (chosen, spot) = (polygon.iter().chain(others).copied(), &spot);
    let depth = match polygon {
        [] | [_] => return 0.0,
        [first, last] => between([spot(*first), spot(*last)], chosen.map(spot), point.at),
        corners => {
            let middle = corners.iter().map(|corner| spot(*corner).at).sum::<DVec2>() / corners.len() as f64;
            let at = point.at.lerp(middle, TOWARDS_MIDDLE);
            let Some(triangle) = Rest::over(corners, spot, at) else { return 0.0 };
            if point.depth - triangle.depth(at) <= slight {
                return 0.0;
            }
            Some(triangle.lowered(chosen, spot, at).depth(at))
        }
    };
    // NaN takes the failing branch.
    depth.map_or(0.0, |depth| point.depth - depth).max(0.0)
}

/// Height of the envelope of points on a line from one end to the other; `None` beside the line.
fn between([first, last]: [Spot; 2], chosen: impl Iterator<Item = Spot> + Clone, at: DVec2) -> Option<f64> {
    let along = last.at - first.at;
    let share = |at: DVec2| (at - first.at).dot(along) / along.length_squared();
    let own = share(at);
    let aside = (at - first.at).perp_dot(along).abs() / along.length_squared();
    // NaN takes the failing branch.
    if !(aside <= TOWARDS_MIDDLE && (0.0..=1.0).contains(&own)) {
        return None;
    }
    let mut depth = f64::NEG_INFINITY;
    for p in chosen.clone().filter(|p| share(p.at) <= own) {
        for q in chosen.clone().filter(|q| share(q.at) >= own) {
            let [start, end] = [share(p.at), share(q.at)];
            let part = if end > start { (own - start) / (end - start) } else { 0.0 };
            depth = depth.max(p.depth + part * (q.depth - p.depth));
        }
    }
    Some(depth)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spots(spots: &[[f64; 3]]) -> Vec<Spot> {
        spots.iter().map(|[x, y, depth]| Spot { at: DVec2::new(*x, *y), depth: *depth }).collect()
    }

    #[test]
    fn a_point_between_corners_is_below_the_deepest_triangle_over_it() {
        // One diagonal is deeper by 1 than the other.
        let chosen = spots(&[[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 0.0], [0.5, 0.5, 1.5]]);
        let at = |i: usize| chosen[i];
        let point = Spot { at: DVec2::new(0.25, 0.25), depth: 1.75 };
        assert!((below(point, [&[0, 1, 2, 3], &[]], at, 0.0) - 0.75).abs() < 0.02);
        assert!((below(point, [&[0, 1, 2, 3], &[4]], at, 0.0) - 0.5).abs() < 0.02);
        assert_eq!(below(point, [&[0, 1, 2, 3], &[]], at, 1.0), 0.0);
        let outside = Spot { at: DVec2::new(-0.25, 0.25), depth: 9.0 };
        assert_eq!(below(outside, [&[0, 1, 2, 3], &[]], at, 0.0), 0.0);
    }

    #[test]
    fn an_edge_on_a_ridge() {
        let chosen = spots(&[[0.0, 0.0, 0.0], [4.0, 0.0, 1.0], [3.0, 0.0, 2.0]]);
        let at = |i: usize| chosen[i];
        let point = Spot { at: DVec2::new(1.0, 1e-9), depth: 2.0 };
        assert_eq!(below(point, [&[0, 1], &[]], at, 0.0), 1.75);
        assert!((below(point, [&[0, 1], &[2]], at, 0.0) - 4.0 / 3.0).abs() < 1e-12);
        let beside = Spot { at: DVec2::new(1.0, 0.1), depth: 2.0 };
        assert_eq!(below(beside, [&[0, 1], &[]], at, 0.0), 0.0);
    }
}
