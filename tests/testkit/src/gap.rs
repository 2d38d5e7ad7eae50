//! Distance of two hulls by Wolfe's algorithm, with a certificate: two points, and two parallel
//! planes between the hulls. However they were found, the distance is at most the distance of the
//! points, and at least the distance of the planes.
//!
//! # Reference
//! P. Wolfe, "Finding the nearest point in a polytope", Mathematical Programming 11, 1976.
//!
//! # Steps
//! 1. Keep a few affinely independent points of A − B and the nearest point x of their hull to the
//!    origin.
//! 2. The support point of A − B along −x gives the planes. If it is no nearer than x, x is the
//!    answer.
//! 3. Otherwise add it, and find the nearest point of the affine hull. While that point lies
//!    outside the simplex, move towards it as far as the simplex reaches, and remove the vertex
//!    that no longer contributes.

use glam::DVec3;

use crate::polytope::Polytope;

/// Maximum number of points added. About a dozen are common.
const MAX_STEPS: usize = 500;

/// Minimum length of the part of a spoke that is independent of the earlier spokes, relative to the
/// spoke. Below it, the spoke adds no dimension.
const FLAT: f64 = 1e-13;

/// An interval that contains the distance, up to
/// [`rounding_error`](crate::polytope::rounding_error).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Distance of the planes; negative if they do not separate the hulls.
    pub lower: f64,
    /// Distance of the points.
    pub upper: f64,
}

/// Distance of `a` from `b`, which is placed in A's frame.
pub fn gap(a: &Polytope, b: &Polytope) -> Gap {
    let least = |x: DVec3| {
        let on_a = a.points.iter().min_by(|p, q| p.dot(x).total_cmp(&q.dot(x)));
        let on_b = b.points.iter().max_by(|p, q| p.dot(x).total_cmp(&q.dot(x)));
        match (on_a, on_b) {
            (Some(p), Some(q)) => p - q,
            _ => DVec3::NAN,
        }
    };
    let mut corral = vec![(least(a.points[0] - b.points[0]), 1.0)];
    let mut best = Gap { lower: f64::NEG_INFINITY, upper: f64::INFINITY };
    for _ in 0..MAX_STEPS {
        let x: DVec3 = corral.iter().map(|(w, share)| *w * *share).sum();
        best.upper = best.upper.min(x.length());
        if x.length() == 0.0 {
            return best;
        }
        let w = least(x);
        best.lower = best.lower.max(w.dot(x) / x.length());
        if best.lower >= best.upper || corral.iter().any(|(kept, _)| *kept == w) {
            return best;
        }
        corral.push((w, 0.0));
        while let Some(target) = affine_shares(&corral) {
            if target.iter().all(|share| *share > 0.0) {
                corral.iter_mut().zip(&target).for_each(|(c, share)| c.1 = *share);
                break;
            }
            // Move towards the target until the first share is 0.
            let pairs = corral.iter().zip(&target).filter(|(_, to)| **to <= 0.0);
            let step = pairs.map(|(c, to)| c.1 / (c.1 - to)).fold(1.0, f64::min);
            corral.iter_mut().zip(&target).for_each(|(c, to)| c.1 += step * (to - c.1));
            let gone = corral.iter().zip(&target).enumerate().filter(|(_, (_, to))| **to <= 0.0);
            let Some(gone) = gone.min_by(|(_, (c, _)), (_, (d, _))| c.1.total_cmp(&d.1)).map(|(index, _)| index) else {
                break;
            };
            corral.remove(gone);
        }
    }
    best
}

/// Barycentric coordinates of the point of the affine hull nearest to the origin; `None` if the
/// points are not independent.
fn affine_shares(corral: &[(DVec3, f64)]) -> Option<Vec<f64>> {
    let root = corral[0].0;
    // Gram-Schmidt, twice for accuracy: spokes = directions times a triangular matrix.
    let (mut dirs, mut triangle): (Vec<DVec3>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
    for (w, _) in &corral[1..] {
        let spoke = *w - root;
        let (mut rest, mut column) = (spoke, vec![0.0; dirs.len()]);
        for _ in 0..2 {
            for (dir, entry) in dirs.iter().zip(&mut column) {
                let part = rest.dot(*dir);
                *entry += part;
                rest -= *dir * part;
            }
        }
        if !(rest.length() > FLAT * spoke.length()) || dirs.len() == 3 {
            return None;
        }
        column.push(rest.length());
        dirs.push(rest.normalize());
        triangle.push(column);
    }
    // The triangular matrix times the shares of the spokes is −root along the directions.
    let mut shares: Vec<f64> = dirs.iter().map(|dir| -root.dot(*dir)).collect();
    for row in (0..shares.len()).rev() {
        for later in row + 1..shares.len() {
            shares[row] -= triangle[later][row] * shares[later];
        }
        shares[row] /= triangle[row][row];
    }
    let first = 1.0 - shares.iter().sum::<f64>();
    shares.insert(0, first);
    Some(shares)
}

/// The slow twin of [`gap`], for separated hulls: the minimum distance of all vertices to all
/// vertices, segments and triangles of the other hull, and of all segments between vertices to each
/// other. O(n⁴).
pub fn distance_by_features(a: &[DVec3], b: &[DVec3]) -> f64 {
    let mut minimum = f64::INFINITY;
    for (points, others) in [(a, b), (b, a)] {
        for p in points {
            for i in 0..others.len() {
                minimum = minimum.min(p.distance(others[i]));
                for j in 0..i {
                    minimum = minimum.min(to_segment(*p, others[i], others[j]));
                    for k in 0..j {
                        minimum = minimum.min(to_triangle(*p, others[i], others[j], others[k]));
                    }
                }
            }
        }
    }
    for i in 0..a.len() {
        for j in 0..i {
            for k in 0..b.len() {
                for l in 0..k {
                    minimum = minimum.min(between_segments(a[i], a[j], b[k], b[l]));
                }
            }
        }
    }
    minimum
}

/// Distance of `p` from the inside of the triangle; infinite if its foot falls outside, because
/// then an edge is nearer.
pub(crate) fn to_triangle(p: DVec3, q: DVec3, r: DVec3, s: DVec3) -> f64 {
    let n = (r - q).cross(s - q);
    let inside = |side: DVec3, from: DVec3| n.cross(side).dot(p - from) >= 0.0;
    let solid = n.length() > FLAT * (r - q).length() * (s - q).length();
    if solid && inside(r - q, q) && inside(s - r, r) && inside(q - s, s) {
        (p - q).dot(n).abs() / n.length()
    } else {
        f64::INFINITY
    }
}

pub(crate) fn to_segment(p: DVec3, q: DVec3, r: DVec3) -> f64 {
    let side = r - q;
    let share = ((p - q).dot(side) / side.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    p.distance(q + side * share)
}

fn between_segments(p: DVec3, q: DVec3, r: DVec3, s: DVec3) -> f64 {
    let ends = [to_segment(p, r, s), to_segment(q, r, s), to_segment(r, p, q), to_segment(s, p, q)];
    let ends = ends.into_iter().fold(f64::INFINITY, f64::min);
    let (d, e, between) = (q - p, s - r, r - p);
    let n = d.cross(e);
    let n_sq = n.length_squared();
    if n_sq > FLAT * FLAT * d.length_squared() * e.length_squared() {
        let (t, u) = (between.cross(e).dot(n) / n_sq, between.cross(d).dot(n) / n_sq);
        if (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u) {
            return ends.min((p + d * t).distance(r + e * u));
        }
    }
    ends
}
