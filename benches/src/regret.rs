//! Error of the answers: regret against a brute-force search over the source points, in f64.

use glam::{DVec3, Vec3};

/// Maximum regret of a support query that counts as exact, relative to the diameter. It is the
/// bound `bake verify` uses.
pub const EXACT: f64 = 2e-7;

/// The true maxima in a set of directions.
pub struct Truth {
    dirs: Vec<Vec3>,
    best: Vec<f64>,
    diameter: f64,
}

impl Truth {
    /// Finds the maximum over all source points for each direction. Complexity: one dot product for
    /// each point and direction.
    pub fn new(points: &[[f32; 3]], diameter: f64, dirs: Vec<Vec3>) -> Self {
        let points: Vec<DVec3> = points.iter().map(|p| DVec3::from(p.map(f64::from))).collect();
        let best = |dir: &Vec3| points.iter().map(|p| p.dot(dir.as_dvec3())).fold(f64::NEG_INFINITY, f64::max);
        Self { best: dirs.iter().map(best).collect(), dirs, diameter }
    }

    /// The directions.
    pub fn dirs(&self) -> &[Vec3] {
        &self.dirs
    }

    /// Maximum regret of one answer for each direction, at least 0. Panics if there are more or
    /// fewer answers than directions.
    pub fn max_regret(&self, answers: &[Vec3]) -> f64 {
        assert_eq!(answers.len(), self.dirs.len());
        let mut max_regret = 0.0_f64;
        for ((dir, best), answer) in self.dirs.iter().zip(&self.best).zip(answers) {
            let dir = dir.as_dvec3();
            let regret = (best - answer.as_dvec3().dot(dir)) / (dir.length() * self.diameter);
            max_regret = if regret.is_nan() { f64::INFINITY } else { max_regret.max(regret) };
        }
        max_regret
    }
}
