//! Random directions and points; the same everywhere for the same seed.

use glam::{DVec3, Vec3};
use hullmap_random::SplitMix64;

/// Seeded generator of directions and points.
#[derive(Clone, Debug)]
pub struct SplitMix(SplitMix64);

impl SplitMix {
    /// A generator; equal seeds give equal sequences everywhere.
    pub fn new(seed: u64) -> Self {
        Self(SplitMix64::new(seed))
    }

    /// The next 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform among 0 … `bound` − 1.
    pub fn below(&mut self, bound: usize) -> usize {
        self.0.below(bound)
    }

    /// Uniform in [−1, 1).
    pub fn signed(&mut self) -> f64 {
        self.0.between(-1.0, 1.0)
    }

    /// Uniform in the unit ball without a small ball around its centre, so that all directions are
    /// equally likely.
    pub fn in_ball_f64(&mut self) -> DVec3 {
        loop {
            let point = DVec3::new(self.signed(), self.signed(), self.signed());
            let length_sq = point.length_squared();
            // The ball fills more than half of the cube: fewer than two draws on average.
            if length_sq <= 1.0 && length_sq > 1e-6 {
                return point;
            }
        }
    }

    /// As [`Self::in_ball_f64`], rounded to f32.
    pub fn in_ball(&mut self) -> Vec3 {
        self.in_ball_f64().as_vec3()
    }
}
