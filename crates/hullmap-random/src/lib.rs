//! SplitMix64, a small seeded generator of pseudo-random numbers.
//!
//! The state is a counter that grows by an odd constant; each output is the counter put through an
//! invertible mixing of 64 bits. Any seed is a good seed, 0 included, and the period is 2^64. It is
//! for shapes and directions, not for secrets.
//!
//! # Reference
//! G. L. Steele, D. Lea, C. H. Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA
//! 2014.

#![forbid(unsafe_code)]

use core::f64::consts::TAU;

/// The step of the counter: 2^64 divided by the golden ratio, made odd.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// Seeded generator; the same seed gives the same numbers on every machine.
///
/// ```
/// let mut rng = hullmap_random::SplitMix64::new(1_234_567);
/// assert_eq!(rng.next_u64(), 6_457_827_717_110_365_317);
/// ```
#[derive(Clone, Debug)]
pub struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    /// A generator that starts from `seed`.
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The seed of a generator that continues here: a failing test prints it.
    pub fn state(&self) -> u64 {
        self.state
    }

    /// The next 64 bits.
    pub fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(STEP);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1): a multiple of 2^-53.
    pub fn unit(&mut self) -> f64 {
        const ULP: f64 = 1.0 / (1_u64 << 53) as f64;
        (self.next_u64() >> 11) as f64 * ULP
    }

    /// Uniform in [`low`, `high`), up to the rounding error of the two operations.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform among 0, 1, … `count` − 1, with a bias below `count` / 2^64.
    ///
    /// # Panics
    /// If `count` is zero.
    pub fn below(&mut self, count: usize) -> usize {
        assert!(count > 0, "the range is empty");
        ((u128::from(self.next_u64()) * count as u128) >> 64) as usize
    }

    /// Unit vector, uniform over the sphere: by Archimedes, z is uniform in [-1, 1].
    pub fn direction(&mut self) -> [f64; 3] {
        let z = self.between(-1.0, 1.0);
        let angle_rad = TAU * self.unit();
        let r = libm::sqrt(1.0 - z * z);
        [r * libm::cos(angle_rad), r * libm::sin(angle_rad), z]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_generator_continues_from_its_state() {
        let mut rng = SplitMix64::new(7);
        rng.next_u64();
        let mut resumed = SplitMix64::new(rng.state());
        assert_eq!(resumed.next_u64(), rng.next_u64());
    }

    #[test]
    fn known_sequence() {
        let mut rng = SplitMix64::new(1_234_567);
        let expected = [
            6_457_827_717_110_365_317,
            3_203_168_211_198_807_973,
            9_817_491_932_198_370_423,
            4_593_380_528_125_082_431,
            16_408_922_859_458_223_821,
        ];
        assert_eq!(expected.map(|_| rng.next_u64()), expected);
    }

    #[test]
    fn below_reaches_every_number_about_equally() {
        let mut rng = SplitMix64::new(1);
        let mut hits = [0_u32; 7];
        for _ in 0..7_000 {
            hits[rng.below(7)] += 1;
        }
        assert!(hits.iter().all(|h| (850..1_150).contains(h)), "{hits:?}");
    }

    #[test]
    fn directions_are_unit_vectors_around_zero() {
        let mut rng = SplitMix64::new(2);
        let length = |v: [f64; 3]| v.map(|x| x * x).iter().sum::<f64>().sqrt();
        let mut sum = [0.0; 3];
        for _ in 0..10_000 {
            let d = rng.direction();
            assert!((length(d) - 1.0).abs() < 1e-14);
            sum = std::array::from_fn(|i| sum[i] + d[i]);
        }
        // The mean of 10,000 has a standard deviation of 0.006 on each axis.
        assert!(length(sum) / 10_000.0 < 0.03, "{sum:?}");
    }
}
