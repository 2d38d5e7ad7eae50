//! Signed depth of two hulls by the separating axis theorem (SAT): the minimum distance from the
//! origin to a facet of their Minkowski difference.
//!
//! # Reference
//! Separating axis theorem for polytopes; the arcs on the Gauss map from D. Gregorius, "The
//! Separating Axis Test between Convex Polyhedra", GDC 2013.
//!
//! # Steps
//! 1. The normals of A − B's facets are A's face normals, B's reversed, and the cross products of
//!    such edges of A and of −B whose arcs on the Gauss map cross.
//! 2. In each of these directions the support value of A − B is the way out: the length by which B
//!    has to move to be out of A. The minimum is the depth; if it is negative, its direction
//!    separates.
//!
//! # Deviations
//! - Arcs that nearly cross count as crossing, and the support value is taken over all vertices,
//!   not over the two edges. A superfluous direction then does no harm, because the support value
//!   of any direction is an upper bound of the depth.

use std::cmp::Ordering;
use std::ops::ControlFlow;

use glam::DVec3;

use crate::{
    polytope::{Polytope, perpendicular_part},
    reach::way_out,
};

/// Sine of the angle by which two arcs may miss each other and still count as crossing.
const ARC_SLACK: f64 = 1e-9;

/// Minimum sine of the angle between two edges. Below it, f64 gives no common normal. Their facet
/// is as narrow as that angle, so skipping it changes the depth by at most this fraction of the
/// size.
const MIN_SINE: f64 = 1e-14;

/// The minimum way out of B, placed in A's frame, and its direction. Negative if the hulls are
/// separated; then it need not be the minimum, because the search ends at the first way out below
/// `enough`.
pub fn signed_depth(a: &Polytope, b: &Polytope, enough: f64) -> (f64, DVec3) {
    let mut best = (f64::INFINITY, DVec3::X);
    facets(a, b, |n, least| {
        if least < best.0 {
            let way = way_out(a, b, n);
            if way < best.0 {
                best = (way, n);
            }
        }
        if best.0 < enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    best
}

/// Calls `take` with the unit normal of every facet of A − B, and of other planes that nearly are
/// facets, until it breaks. The second argument is a lower bound of the support value.
pub fn facets(a: &Polytope, b: &Polytope, mut take: impl FnMut(DVec3, f64) -> ControlFlow<()>) {
    for n in a.normals.iter().copied().chain(b.normals.iter().map(|n| -n)) {
        if take(n, f64::NEG_INFINITY).is_break() {
            return;
        }
    }
    // The great circle of one edge cuts the arc of another where its two normals lie on both sides.
    let cuts = |left: f64, right: f64| left * right <= 0.0 || left.abs().min(right.abs()) <= ARC_SLACK;
    for edge_a in &a.edges {
        let [left_a, right_a] = edge_a.faces.map(|face| a.normals[face]);
        let middle_a = left_a + right_a;
        // Each cosine is used by at least three edges.
        let cosines: Vec<f64> = b.normals.iter().map(|n| edge_a.dir.dot(*n)).collect();
        for edge_b in &b.edges {
            let [left_b, right_b] = edge_b.faces.map(|face| cosines[face]);
            if !(cuts(left_b, right_b) && cuts(edge_b.dir.dot(left_a), edge_b.dir.dot(right_a))) {
                continue;
            }
            // The great circles meet in two points. The test below selects the point on both arcs.
            let cross = edge_a.dir.cross(edge_b.dir);
            if cross.length() < MIN_SINE {
                continue;
            }
            let n = perpendicular_part(cross.normalize(), edge_a.dir);
            let middle_b = -b.normals[edge_b.faces[0]] - b.normals[edge_b.faces[1]];
            for n in [n, -n] {
                let on_both = n.dot(middle_a) >= -ARC_SLACK && n.dot(middle_b) >= -ARC_SLACK;
                if on_both && take(n, (edge_a.point - edge_b.point).dot(n)).is_break() {
                    return;
                }
            }
        }
    }
}

/// The slow twin of [`signed_depth`], from the points alone: the minimum way out along all
/// [`axes`], both ways. Infinite if the hulls together are flat. O(n⁵).
pub fn signed_depth_by_points(a: &[DVec3], b: &[DVec3]) -> f64 {
    let mut minimum = f64::INFINITY;
    axes(a, b, MIN_SINE, |n| minimum = minimum.min(way_out(a, b, n)).min(way_out(a, b, -n)));
    minimum
}

/// Calls `take` with the unit normals of all triangles of vertices, and of all pairs of segments
/// between vertices of both: the normals of all facets of the Minkowski difference are among them.
/// Skips cross products of sides whose angle has a sine of at most `min_sine`.
pub fn axes(a: &[DVec3], b: &[DVec3], min_sine: f64, mut take: impl FnMut(DVec3)) {
    let mut consider = |cross: DVec3, scale: f64, dir: DVec3| {
        if cross.length() > min_sine * scale {
            take(perpendicular_part(cross.normalize(), dir));
        }
    };
    for points in [a, b] {
        for i in 0..points.len() {
            for j in 0..i {
                for k in 0..j {
                    let sides = [points[j] - points[i], points[k] - points[j], points[i] - points[k]];
                    let longest =
                        sides.into_iter().fold(DVec3::ZERO, |l, s| if s.length() > l.length() { s } else { l });
                    consider(sides[0].cross(sides[1]), sides[0].length() * sides[1].length(), longest.normalize());
                }
            }
        }
    }
    for i in 0..a.len() {
        for j in 0..i {
            let e = (a[j] - a[i]).normalize();
            for k in 0..b.len() {
                for l in 0..k {
                    consider(e.cross((b[l] - b[k]).normalize()), 1.0, e);
                }
            }
        }
    }
}

/// Whether the hulls of points with whole coordinates below 2¹⁶ are apart (`Greater`), only touch
/// (`Equal`), or share points of their insides (`Less`): f64 computes all products of such numbers
/// without rounding.
pub fn gap_of_whole(a: &[DVec3], b: &[DVec3]) -> Ordering {
    let mut widest = Ordering::Less;
    let mut consider = |n: DVec3| {
        if n != DVec3::ZERO {
            let gap = -way_out(a, b, n).min(way_out(a, b, -n));
            widest = widest.max(gap.partial_cmp(&0.0).unwrap_or(Ordering::Less));
        }
    };
    let sides = |points: &[DVec3]| -> Vec<DVec3> {
        (0..points.len()).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| points[i] - points[j]).collect()
    };
    let [of_a, of_b] = [a, b].map(sides);
    for (left, right) in [(&of_a, &of_a), (&of_b, &of_b), (&of_a, &of_b)] {
        left.iter().for_each(|e| right.iter().for_each(|f| consider(e.cross(*f))));
    }
    widest
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use hullmap::Pose;
    use shapes::rng::SplitMix64;

    use super::*;
    use crate::gap::{distance_by_features, gap};
    use crate::packs::tree_pack;
    use crate::random::RandomPoses;

    /// A random hull of few points, and its polytope.
    fn small(rng: &mut SplitMix64) -> Polytope {
        let points: Vec<[f32; 3]> = (0..4 + rng.below(9)).map(|_| rng.direction().map(|c| c as f32)).collect();
        Polytope::new(&tree_pack(&points).hull(0).unwrap())
    }

    #[test]
    fn depths_and_distances_agree_with_their_slow_twins() {
        let mut rng = SplitMix64::new(20_261_121);
        let (mut deep, mut apart) = (0, 0);
        for round in 0..1_500 {
            let (a, b) = (small(&mut rng), small(&mut rng).placed(rng.pose(2.5)));
            let (depth, _) = signed_depth(&a, &b, f64::NEG_INFINITY);
            let twin = signed_depth_by_points(&a.points, &b.points);
            // Directions that are not normals of facets may separate hulls farther.
            assert!((twin - depth).abs() <= 1e-12 || twin < depth && depth < 0.0, "{round}: {depth:e}, {twin:e}");
            let (far, twin) = (gap(&a, &b), distance_by_features(&a.points, &b.points));
            if depth < 0.0 {
                apart += 1;
                assert!(far.lower <= twin + 1e-12 && twin <= far.upper + 1e-12, "{round}: {far:?}, {twin:e}");
                assert!(far.upper - far.lower <= 1e-6 * far.upper + 1e-12 || far.upper < 1e-6, "{round}: {far:?}");
            } else {
                deep += 1;
                assert!(far.upper <= 1e-12, "{round}: {far:?}");
            }
        }
        assert!(deep > 400 && apart > 400, "{deep} {apart}");
    }

    /// A face, an edge and a vertex of B towards A; and a polygon, which has a depth perpendicular
    /// to its plane.
    #[test]
    fn cubes_and_a_square_have_known_depths() {
        let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| [1, 2, 4].map(|bit| if i & bit == 0 { -1.0 } else { 1.0 }));
        let square: Vec<[f32; 3]> = corners[..4].iter().map(|p| [p[0] * 3.0, p[1] * 3.0, 0.0]).collect();
        let [cube, square] = [&corners[..], &square].map(|points| Polytope::new(&tree_pack(points).hull(0).unwrap()));
        assert_eq!((cube.points.len(), cube.normals.len(), cube.edges.len()), (8, 6, 12));
        assert_eq!((square.points.len(), square.normals.len(), square.edges.len()), (4, 6, 8));
        let edge = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_4);
        let vertex = DQuat::from_rotation_arc(DVec3::ONE.normalize(), DVec3::NEG_X);
        for (turn, reach) in [(DQuat::IDENTITY, 1.0), (edge, 2.0_f64.sqrt()), (vertex, 3.0_f64.sqrt())] {
            for expected in [0.25, 1e-3, 1e-9, -1e-9, -1e-3, -0.5] {
                let b = cube.placed(Pose::new(DVec3::X * (1.0 + reach - expected), turn).unwrap());
                let (depth, normal) = signed_depth(&cube, &b, f64::NEG_INFINITY);
                assert!((depth - expected).abs() < 1e-14 && normal.distance(DVec3::X) < 1e-14, "{depth} {expected}");
                assert!((signed_depth_by_points(&cube.points, &b.points) - expected).abs() < 1e-14);
                let (far, apart) = (gap(&cube, &b), (-expected).max(0.0));
                assert!(far.lower <= apart + 1e-14 && (far.upper - apart).abs() < 1e-14, "{far:?} {expected}");
                assert!(expected > 0.0 || (distance_by_features(&cube.points, &b.points) - apart).abs() < 1e-14);
            }
        }
        for (x, z, expected) in [(0.0, 0.25, 0.75), (3.5, 0.0, 0.5), (3.5, 0.75, 0.25), (4.125, 0.0, -0.125)] {
            let b = square.placed(Pose::from_translation(DVec3::new(x, 0.1, z)).unwrap());
            let (depth, _) = signed_depth(&cube, &b, f64::NEG_INFINITY);
            assert!((depth - expected).abs() < 1e-14, "{x} {z}: {depth}");
        }
        for (x, expected) in [(1.0, Ordering::Less), (2.0, Ordering::Equal), (3.0, Ordering::Greater)] {
            let moved: Vec<DVec3> = cube.points.iter().map(|p| *p + DVec3::new(x, 1.0, 1.0)).collect();
            assert_eq!(gap_of_whole(&cube.points, &moved), expected, "{x}");
        }
    }
}
