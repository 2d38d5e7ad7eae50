//! Error of the answers: regret against a brute-force search over the source points, in f64.

use glam::Vec3;

use crate::subject::Subject;

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
    pub fn new(subject: &Subject, dirs: Vec<Vec3>) -> Self {
        let points: Vec<[f64; 3]> = subject.points.iter().map(|p| p.map(f64::from)).collect();
        let best = dirs.iter().map(|&dir| {
            let [x, y, z] = dir.as_dvec3().to_array();
            // Eight independent maxima: with one, each step would wait for the last.
            let mut best = [f64::NEG_INFINITY; 8];
            for group in points.chunks(best.len()) {
                for (best, p) in best.iter_mut().zip(group) {
                    *best = best.max(p[0] * x + p[1] * y + p[2] * z);
                }
            }
            best.into_iter().fold(f64::NEG_INFINITY, f64::max)
        });
        let best = best.collect();
        Self { dirs, best, diameter: subject.diameter() }
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
