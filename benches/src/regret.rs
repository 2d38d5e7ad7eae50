//! How far from the truth answers are: by brute force in f64 over the source points.

use glam::Vec3;

use crate::subject::Subject;

/// Regret up to which a support query counts as exact, relative to the diameter. The project's promise.
pub const EXACT: f64 = 2e-7;

/// The greatest dot products in some directions.
pub struct Truth {
    dirs: Vec<Vec3>,
    best: Vec<f64>,
    diameter: f64,
}

/// What is wrong with a rival's answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// Greatest regret; negative by rounding is 0.
    pub max_regret: f64,
    /// Share of the directions with a regret above [`EXACT`].
    pub wrong_share: f64,
}

impl Truth {
    /// Asks all source points in all directions.
    ///
    /// # Complexity
    /// One dot product a point and direction.
    pub fn new(subject: &Subject, dirs: Vec<Vec3>) -> Self {
        let points: Vec<[f64; 3]> = subject.points.iter().map(|p| p.map(f64::from)).collect();
        let best = dirs.iter().map(|&dir| {
            let [x, y, z] = dir.as_dvec3().to_array();
            // Eight maxima side by side: one would wait for itself at every point.
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

    /// Judges one answer a direction.
    ///
    /// # Panics
    /// If there are more or fewer.
    pub fn judge(&self, answers: &[Vec3]) -> Verdict {
        assert_eq!(answers.len(), self.dirs.len());
        let (mut max_regret, mut wrong) = (0.0_f64, 0);
        for ((dir, best), answer) in self.dirs.iter().zip(&self.best).zip(answers) {
            let dir = dir.as_dvec3();
            let regret = (best - answer.as_dvec3().dot(dir)) / (dir.length() * self.diameter);
            // NaN counts as wrong.
            wrong += usize::from(!(regret <= EXACT));
            max_regret = if regret.is_nan() { f64::INFINITY } else { max_regret.max(regret) };
        }
        Verdict { max_regret, wrong_share: wrong as f64 / self.dirs.len() as f64 }
    }
}
