//! A hash of numbers by their bits.

use glam::DVec3;
use hullmap::{Contact, Distance, Intersection, Manifold, SupportVertex};
use std::hash::Hasher;
use twox_hash::XxHash3_64;

/// XXH3-64 of little-endian numbers. Negative zero is hashed as zero, because the sign of a zero
/// sum carries no information.
pub struct Bits(XxHash3_64);

impl Default for Bits {
    fn default() -> Self {
        Self(XxHash3_64::with_seed(0))
    }
}

impl Bits {
    /// The hash of all numbers added so far.
    pub fn finish(&self) -> u64 {
        self.0.finish()
    }

    /// Adds a count.
    pub fn count(&mut self, count: u32) {
        self.0.write(&count.to_le_bytes());
    }

    /// Adds a hash.
    pub fn hash(&mut self, hash: u64) {
        self.0.write(&hash.to_le_bytes());
    }

    /// Adds a number other than NaN. Panics if it is NaN, which no answer may contain.
    pub fn number(&mut self, number: f64) {
        assert!(!number.is_nan(), "an answer is NaN");
        self.0.write(&(number + 0.0).to_bits().to_le_bytes());
    }

    /// Adds three numbers.
    pub fn vector(&mut self, v: DVec3) {
        v.to_array().into_iter().for_each(|c| self.number(c));
    }

    /// Adds a support point.
    pub fn support(&mut self, s: SupportVertex) {
        self.count(s.index);
        self.vector(s.point.as_dvec3());
    }

    /// Adds all fields of an answer.
    pub fn intersection(&mut self, i: &Intersection) {
        self.0.write(i.status.as_str().as_bytes());
        self.count(i.iterations);
        self.count(i.support_calls);
    }

    /// Adds all fields of an answer.
    pub fn contact(&mut self, c: &Contact) {
        self.0.write(c.status.as_str().as_bytes());
        [c.depth, c.depth_lower, c.depth_upper].into_iter().for_each(|n| self.number(n));
        [c.normal, c.point_a, c.point_b].into_iter().for_each(|v| self.vector(v));
        [u32::from(c.hit), c.iterations, c.support_calls].into_iter().for_each(|n| self.count(n));
    }

    /// Adds all fields of an answer.
    pub fn distance(&mut self, d: &Distance) {
        self.0.write(d.status.as_str().as_bytes());
        [d.distance, d.lower, d.upper].into_iter().for_each(|n| self.number(n));
        [d.normal, d.point_a, d.point_b].into_iter().for_each(|v| self.vector(v));
        [d.iterations, d.support_calls].into_iter().for_each(|n| self.count(n));
    }

    /// Adds all points.
    pub fn manifold(&mut self, m: &Manifold) {
        self.vector(m.normal());
        for p in m.points() {
            [p.point_a, p.point_b, p.local_b].into_iter().for_each(|v| self.vector(v));
            self.number(p.depth);
            self.count(p.age);
        }
    }
}
