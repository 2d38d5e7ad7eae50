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

/// The point of a triangle nearest to `p`. It is a convex combination of the corners.
pub fn nearest(triangle: &Triangle, p: DVec3) -> DVec3 {
    let [a, b, c] = *triangle;
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    let (aa, ab_ac, cc) = (ab.length_squared(), ab.dot(ac), ac.length_squared());
    // Barycentric coordinates of the projection onto the plane.
    let area = aa * cc - ab_ac * ab_ac;
    let (v, w) = ((cc * d1 - ab_ac * d2) / area, (aa * d2 - ab_ac * d1) / area);
    // NaN and infinite coordinates of a degenerate triangle fail the test.
    if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
        let inside = a + v * ab + w * ac;
        // The projection onto the plane of a thin triangle may be imprecise.
        if area > 1e-6 * aa * cc {
            return inside;
        }
    }
    let edges = [[a, b], [b, c], [c, a]].map(|edge| nearest_on_segment(edge, p));
    let mut best = edges[0];
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
