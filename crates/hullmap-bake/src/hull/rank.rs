//! Rank (dimension) of a point set, and a simplex that spans it.
//!
//! 1. Find two points far from each other: the ends of the last of three farthest-point sweeps.
//! 2. Find the point farthest from their line.
//! 3. Find the point farthest from the plane of these three.
//!
//! A set has a lower rank if the farthest point lies within [`FLAT`] of the line or plane, which
//! bounds the error of leaving the other points out.

use glam::DVec3;

/// Maximum distance from a line or plane, relative to the span, of a set that counts as lying in
/// it: half a unit in the last place of f32 coordinates near 1, as rotating a flat sheet leaves,
/// and half of what [`super::certify`] allows.
pub const FLAT: f64 = 5e-8;

/// Indices of points that span the set: one more than its rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simplex {
    /// All points coincide.
    Point(usize),
    /// All points lie on the line through these.
    Segment([usize; 2]),
    /// All points lie in the plane of these.
    Triangle([usize; 3]),
    /// The points span space.
    Tetrahedron([usize; 4]),
}

/// Finds a simplex that spans `points`, which must not be empty.
pub fn spanning_simplex(points: &[DVec3]) -> Simplex {
    let start = farthest(points, |p| -p.x);
    let mut a = start;
    let mut b = start;
    for _ in 0..3 {
        (a, b) = (b, farthest(points, |p| p.distance_squared(points[b])));
    }
    let span = points[a].distance(points[b]);
    if span == 0.0 {
        return Simplex::Point(start);
    }
    let origin = points[a];
    let along = (points[b] - origin) / span;
    let off_line = |p: DVec3| (p - origin).cross(along).length();
    let c = farthest(points, off_line);
    if off_line(points[c]) <= FLAT * span {
        return Simplex::Segment([a, b]);
    }
    let normal = along.cross(points[c] - origin).normalize();
    let off_plane = |p: DVec3| (p - origin).dot(normal).abs();
    let d = farthest(points, off_plane);
    if off_plane(points[d]) <= FLAT * span {
        return Simplex::Triangle([a, b, c]);
    }
    Simplex::Tetrahedron([a, b, c, d])
}

fn farthest(points: &[DVec3], measure: impl Fn(DVec3) -> f64) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (i, p) in points.iter().enumerate() {
        let m = measure(*p);
        if m > best.1 {
            best = (i, m);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rank_is_recognised() {
        let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        assert!(matches!(spanning_simplex(&[p(1., 2., 3.), p(1., 2., 3.)]), Simplex::Point(_)));
        assert!(matches!(spanning_simplex(&[p(0., 0., 0.), p(1., 1., 1.), p(2., 2., 2.)]), Simplex::Segment(_)));
        let sheet = [p(0., 0., 5.), p(1., 0., 5.), p(0., 1., 5.), p(1., 1., 5.)];
        assert!(matches!(spanning_simplex(&sheet), Simplex::Triangle(_)));
        let thin = [p(0., 0., 5.), p(1., 0., 5.), p(0., 1., 5.), p(1., 1., 5.000001)];
        assert!(matches!(spanning_simplex(&thin), Simplex::Tetrahedron(_)));
    }
}
