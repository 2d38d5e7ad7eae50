//! Regret of a support query, by brute force in f64 over the source points.

use glam::{DVec3, Vec3};

/// The source points, and their diameter: the maximum distance between two of them.
pub struct Truth {
    points: Vec<DVec3>,
    diameter: f64,
}

impl Truth {
    /// Takes the source points.
    pub fn new(points: &[[f32; 3]]) -> Self {
        let points: Vec<DVec3> = points.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
        // The distance found is at most the diameter, and at least 1/√3 of it. A regret relative to
        // it is therefore never too small.
        let far = |from: DVec3| {
            points.iter().copied().max_by(|p, q| p.distance(from).total_cmp(&q.distance(from))).unwrap_or(from)
        };
        let a = far(points[0]);
        let diameter = a.distance(far(a));
        Self { points, diameter }
    }

    /// (maximum dot product − dot product of `got`) / (|dir| · diameter); 0 where all points are
    /// the same.
    pub fn regret(&self, dir: Vec3, got: Vec3) -> f64 {
        let (dir, got) = (dir.as_dvec3(), got.as_dvec3());
        let best = self.points.iter().map(|p| p.dot(dir)).fold(f64::NEG_INFINITY, f64::max);
        if self.diameter == 0.0 { 0.0 } else { (best - got.dot(dir)) / (dir.length() * self.diameter) }
    }
}
