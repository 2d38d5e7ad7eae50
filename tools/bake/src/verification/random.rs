//! Random numbers that are the same everywhere for the same seed.

use glam::{DVec3, Vec3};

/// Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
#[derive(Clone, Debug)]
pub struct SplitMix {
    state: u64,
}

impl SplitMix {
    /// A generator; equal seeds give equal numbers everywhere.
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The next 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.state;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^ (bits >> 31)
    }

    /// A number below `bound`, which is far below 2^32, so that the bias does not matter.
    pub fn below(&mut self, bound: usize) -> usize {
        (((self.bits() >> 32) * bound as u64) >> 32) as usize
    }

    /// Uniform in −1 … 1.
    pub fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Uniform in the unit ball without its very centre, so that every direction is as likely.
    pub fn in_ball_f64(&mut self) -> DVec3 {
        loop {
            let point = DVec3::new(self.signed(), self.signed(), self.signed());
            let length_sq = point.length_squared();
            // The ball fills more than half of the cube; a hundred misses in a row will not be seen.
            if length_sq <= 1.0 && length_sq > 1e-6 {
                return point;
            }
        }
    }

    /// The same in f32.
    pub fn in_ball(&mut self) -> Vec3 {
        self.in_ball_f64().as_vec3()
    }
}
