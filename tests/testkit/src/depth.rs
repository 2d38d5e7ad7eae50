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

/// The slow twin of [`signed_depth`], from the points alone: the minimum way out along the normals
/// of all triangles of vertices and along the cross products of all pairs of segments between
/// vertices, both ways. Infinite if the hulls together are flat. O(n⁵).
pub fn signed_depth_by_points(a: &[DVec3], b: &[DVec3]) -> f64 {
    let mut minimum = f64::INFINITY;
    let mut consider = |cross: DVec3, scale: f64, dir: DVec3| {
        if cross.length() > MIN_SINE * scale {
            let n = perpendicular_part(cross.normalize(), dir);
            minimum = minimum.min(way_out(a, b, n)).min(way_out(a, b, -n));
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
    minimum
}
