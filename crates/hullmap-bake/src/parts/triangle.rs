//! Triangles: the nearest point, and cells of a surface that can be halved.
//!
//! # Reference
//! Ericson, "Real-Time Collision Detection", 2005, section 5.1.5.
//!
//! # Deviations
//! - The nearest points of the three edges are compared as well, so that the result is a point of
//!   the triangle for any triangle, however thin, and nearest except for rounding error.

use glam::DVec3;

/// Corners of a triangle.
pub type Triangle = [DVec3; 3];

/// Area of a triangle, relative to the product of two edges, below which the projection onto its
/// plane may be imprecise.
const THIN: f64 = 1e-3;

/// Barycentric coordinate up to which a point may be beside the opposite edge, relative to the
/// greatest one. It is far above the rounding error of a triangle that is not thin.
const BESIDE: f64 = 1e-6;

/// The point of a triangle nearest to `p`. It is a convex combination of the corners.
pub fn nearest(triangle: &Triangle, p: DVec3) -> DVec3 {
    let [a, b, c] = *triangle;
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    let (aa, ab_ac, cc) = (ab.length_squared(), ab.dot(ac), ac.length_squared());
    // Barycentric coordinates of the projection onto the plane, times `area`.
    let area = aa * cc - ab_ac * ab_ac;
    let (v, w) = (cc * d1 - ab_ac * d2, aa * d2 - ab_ac * d1);
    let u = area - v - w;
    // NaN of a degenerate triangle fails the test, and so do rounding errors of a thin one.
    if !(area > THIN * THIN * aa * cc) {
        return nearest_of_all(triangle, p);
    }
    if u >= 0.0 && v >= 0.0 && w >= 0.0 {
        return a + (v / area) * ab + (w / area) * ac;
    }
    // Only an edge that has the point on its outer side can be nearest.
    let beside = BESIDE * u.abs().max(v.abs()).max(w.abs());
    let mut best = (f64::INFINITY, a);
    for (weight, edge) in [(w, [a, b]), (u, [b, c]), (v, [c, a])] {
        if weight <= beside {
            let candidate = nearest_on_segment(edge, p);
            let square = candidate.distance_squared(p);
            if square < best.0 {
                best = (square, candidate);
            }
        }
    }
    best.1
}

/// The same for any triangle, however thin: the nearest of the projection and of the points of all
/// edges.
fn nearest_of_all(triangle: &Triangle, p: DVec3) -> DVec3 {
    let [a, b, c] = *triangle;
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    let (aa, ab_ac, cc) = (ab.length_squared(), ab.dot(ac), ac.length_squared());
    let area = aa * cc - ab_ac * ab_ac;
    let (v, w) = ((cc * d1 - ab_ac * d2) / area, (aa * d2 - ab_ac * d1) / area);
    let edges = [[a, b], [b, c], [c, a]].map(|edge| nearest_on_segment(edge, p));
    let mut best = edges[0];
    // NaN and infinite coordinates of a degenerate triangle fail the test.
    for candidate in
        [edges[1], edges[2]].into_iter().chain((v >= 0.0 && w >= 0.0 && v + w <= 1.0).then(|| a + v * ab + w * ac))
    {
        if candidate.distance_squared(p) < best.distance_squared(p) {
            best = candidate;
        }
    }
    best
}

/// The point of a segment nearest to `p`.
fn nearest_on_segment([a, b]: [DVec3; 2], p: DVec3) -> DVec3 {
    let ab = b - a;
    let along = (p - a).dot(ab) / ab.length_squared();
    // NaN of a segment without length takes the first end.
    if along >= 1.0 {
        b
    } else if along > 0.0 {
        a + along * ab
    } else {
        a
    }
}

/// The mean of the corners.
pub fn centroid([a, b, c]: &Triangle) -> DVec3 {
    (*a + *b + *c) / 3.0
}

/// The halves of a triangle, cut through its longest edge.
pub fn halves(&[a, b, c]: &Triangle) -> [Triangle; 2] {
    let lengths = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
    let [p, q, r] = if lengths[0] >= lengths[1] && lengths[0] >= lengths[2] {
        [a, b, c]
    } else if lengths[1] >= lengths[2] {
        [b, c, a]
    } else {
        [c, a, b]
    };
    let middle = (p + q) * 0.5;
    [[p, middle, r], [middle, q, r]]
}

#[cfg(test)]
mod tests {
    use shapes::rng::SplitMix64;

    use super::*;

    /// Triangles of all proportions, and points above, beside and far from them.
    #[test]
    fn the_nearest_point_is_that_of_all_edges_and_the_plane() {
        let mut rng = SplitMix64::new(5);
        let mut of_edges = 0;
        const ROUNDS: usize = 200_000;
        for round in 0..ROUNDS {
            let mut point = || DVec3::from_array(std::array::from_fn(|_| 2.0 * rng.unit() - 1.0));
            let (a, along, aside, p) = (point(), point(), point(), point());
            let width = 10_f64.powi(-((round % 12) as i32));
            let share = 3.0 * point().x;
            let triangle = [a, a + along, a + share * along + width * aside];
            let p = a + p * 10_f64.powi((round / 12 % 8) as i32 - 3);
            let (fast, slow) = (nearest(&triangle, p), nearest_of_all(&triangle, p));
            let (distance, least) = (fast.distance(p), slow.distance(p));
            let size = 1.0 + least;
            assert!((distance - least).abs() <= 1e-12 * size, "round {round}: {distance} instead of {least}");
            of_edges += usize::from(slow.distance(fast) == 0.0);
        }
        assert!(of_edges > ROUNDS / 2, "{of_edges} points are the same");
    }
}
