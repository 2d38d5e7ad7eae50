//! Truth by brute force: signed depth and distance of the hulls of a few points, all in double precision.

use crate::shapes::PointCloud;
use glam::DVec3;
use hullmap::Pose;

/// The greatest a · n less the least b · n.
pub fn support_value(a: &[DVec3], b: &[DVec3], n: DVec3) -> f64 {
    let top = a.iter().map(|p| p.dot(n)).fold(f64::NEG_INFINITY, f64::max);
    let bottom = b.iter().map(|p| p.dot(n)).fold(f64::INFINITY, f64::min);
    top - bottom
}

/// The least support value of A − B over the normals of all triangles of vertices and over all cross products of edges, both
/// ways: the depth if positive; negative exactly when the hulls are apart (separating axis theorem; more
/// normals than the hulls' own do no harm). Both hulls must be solid.
pub fn signed_depth(a: &PointCloud, b: &PointCloud, b_in_a: Pose) -> f64 {
    let (a, b) = (&a.points, &b.placed(b_in_a));
    let mut least = f64::INFINITY;
    let mut try_normal = |n: DVec3, scale: f64| {
        let length = n.length();
        if length > 1e-9 * scale {
            least = least.min(support_value(a, b, n / length)).min(support_value(a, b, -n / length));
        }
    };
    for points in [a, b] {
        for i in 0..points.len() {
            for j in 0..i {
                for k in 0..j {
                    let (e, f) = (points[j] - points[i], points[k] - points[i]);
                    try_normal(e.cross(f), e.length() * f.length());
                }
            }
        }
    }
    for i in 0..a.len() {
        for j in 0..i {
            for k in 0..b.len() {
                for l in 0..k {
                    let (e, f) = (a[j] - a[i], b[l] - b[k]);
                    try_normal(e.cross(f), e.length() * f.length());
                }
            }
        }
    }
    least
}

/// Distance of two hulls known to be apart: the least of all vertices to all triangles and all edges to all edges.
pub fn distance_apart(a: &PointCloud, b: &PointCloud, b_in_a: Pose) -> f64 {
    let (a, b) = (&a.points, &b.placed(b_in_a));
    let mut least = f64::INFINITY;
    for (points, others) in [(a, b), (b, a)] {
        for p in points {
            for q in others {
                least = least.min(p.distance(*q));
            }
            for i in 0..others.len() {
                for j in 0..i {
                    least = least.min(point_to_segment(*p, others[i], others[j]));
                    for k in 0..j {
                        least = least.min(point_to_triangle(*p, others[i], others[j], others[k]));
                    }
                }
            }
        }
    }
    for i in 0..a.len() {
        for j in 0..i {
            for k in 0..b.len() {
                for l in 0..k {
                    least = least.min(segment_to_segment(a[i], a[j], b[k], b[l]));
                }
            }
        }
    }
    least
}

/// Distance to the triangle's inside; infinite where the foot falls outside (edges take over).
fn point_to_triangle(p: DVec3, q: DVec3, r: DVec3, s: DVec3) -> f64 {
    let n = (r - q).cross(s - q);
    let inside = |e: DVec3, from: DVec3| n.cross(e).dot(p - from) >= 0.0;
    // A triangle that is a segment but for rounding has no inside.
    let solid = n.length() > 1e-12 * (r - q).length() * (s - q).length();
    if solid && inside(r - q, q) && inside(s - r, r) && inside(q - s, s) {
        (p - q).dot(n).abs() / n.length()
    } else {
        f64::INFINITY
    }
}

fn point_to_segment(p: DVec3, q: DVec3, r: DVec3) -> f64 {
    let e = r - q;
    let t = ((p - q).dot(e) / e.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    p.distance(q + e * t)
}

fn segment_to_segment(p: DVec3, q: DVec3, r: DVec3, s: DVec3) -> f64 {
    let ends = point_to_segment(p, r, s)
        .min(point_to_segment(q, r, s))
        .min(point_to_segment(r, p, q))
        .min(point_to_segment(s, p, q));
    let (d, e, w) = (q - p, s - r, r - p);
    let n = d.cross(e);
    let n_sq = n.length_squared();
    if n_sq > 1e-18 * d.length_squared() * e.length_squared() {
        let (t, u) = (w.cross(e).dot(n) / n_sq, w.cross(d).dot(n) / n_sq);
        if (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u) {
            return ends.min((p + d * t).distance(r + e * u));
        }
    }
    ends
}
