//! Exact sums of products of f64 numbers: a long accumulator.
//!
//! # Steps
//! 1. Multiply the mantissas as integers, and add the exponents.
//! 2. Add the product to a fixed-point number that spans the whole range of such products. Positive
//!    and negative products have a number each, so a carry does not run far.
//! 3. Compare both numbers for the sign, and subtract them for the value.
//!
//! # Deviations
//! The crate `robust` has predicates of points, but a ray has a direction: origin + direction is
//! rounded. Expansions (Shewchuk 1997) are exact only while no product underflows, and a direction
//! may have any length. This is slower, and only runs where f64 cannot decide.
//!
//! # Reference
//! Kulisch, "Computer Arithmetic and Validity", 2008, chapter 8.

use std::cmp::Ordering;

use glam::DVec3;

/// Maximum number of factors of a product.
const FACTORS: usize = 4;

/// Exponent of the lowest bit: of the product of the smallest factors, less a word that is scaled.
const LOWEST: i32 = -1074 * FACTORS as i32 - 64;

/// Words of 64 bits from there to the product of the greatest factors, and one word for the sum of
/// many.
const WORDS: usize = (2100 * FACTORS) / 64 + 3;

/// A vector as a difference of two points: from the first one to the second one.
pub(super) type Way = [DVec3; 2];

/// The sum of products of up to [`FACTORS`] finite numbers, without any rounding.
#[derive(Clone)]
pub(super) struct Sum {
    /// Sums of the positive and of the negative products. Lowest words first.
    parts: [[u64; WORDS]; 2],
}

impl Sum {
    fn new() -> Self {
        Self { parts: [[0; WORDS]; 2] }
    }

    /// A coordinate of a vector.
    pub(super) fn coordinate(way: Way, axis: usize) -> Self {
        let mut sum = Self::new();
        sum.add(&[way[1][axis]]);
        sum.add(&[-way[0][axis]]);
        sum
    }

    /// A coordinate of the cross product of two vectors.
    pub(super) fn cross(a: Way, b: Way, axis: usize) -> Self {
        let (mut sum, [y, z]) = (Self::new(), [(axis + 1) % 3, (axis + 2) % 3]);
        for (a, of_a) in signed(a) {
            for (b, of_b) in signed(b) {
                sum.add(&[of_a * of_b * a[y], b[z]]);
                sum.add(&[-of_a * of_b * a[z], b[y]]);
            }
        }
        sum
    }

    /// The volume that three vectors span: a · (b × c).
    pub(super) fn volume(a: Way, b: Way, c: Way) -> Self {
        let mut sum = Self::new();
        for (a, of_a) in signed(a) {
            for (b, of_b) in signed(b) {
                for (c, of_c) in signed(c) {
                    let sign = of_a * of_b * of_c;
                    for (x, y, z) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
                        sum.add(&[sign * a[x], b[y], c[z]]);
                        sum.add(&[-sign * a[x], b[z], c[y]]);
                    }
                }
            }
        }
        sum
    }

    /// Adds a product.
    fn add(&mut self, factors: &[f64]) {
        if factors.contains(&0.0) {
            return;
        }
        let (mut product, mut exponent, mut is_negative) = ([1, 0, 0, 0], 0, false);
        for factor in factors {
            let (mantissa, power) = decoded(*factor);
            product = times(product, mantissa);
            exponent += power;
            is_negative ^= factor.is_sign_negative();
        }
        self.accumulate(product, exponent, is_negative);
    }

    /// Adds `factor` times another sum, of products of at most three factors.
    fn add_scaled(&mut self, other: &Self, factor: f64) {
        let (mantissa, power) = decoded(factor);
        for (part, is_negative) in other.parts.iter().zip([false, true]) {
            for (word, place) in part.iter().zip(0..).filter(|(word, _)| **word != 0) {
                let product = times([*word, 0, 0, 0], mantissa);
                self.accumulate(product, LOWEST + 64 * place + power, is_negative != factor.is_sign_negative());
            }
        }
    }

    /// Adds an integer times a power of two.
    fn accumulate(&mut self, product: [u64; 4], exponent: i32, is_negative: bool) {
        let shift = (exponent - LOWEST) as usize;
        let (first, bits) = (shift / 64, shift % 64);
        let (mut below, mut carry) = (0, 0);
        for (word, to) in self.parts[usize::from(is_negative)].iter_mut().skip(first).enumerate() {
            let above = product.get(word).copied().unwrap_or(0);
            // A shift by 64 is a shift by 1 and one by 63.
            let added = above << bits | below >> 1 >> (63 - bits);
            below = above;
            let (sum, is_over) = to.overflowing_add(added);
            let (sum, is_over_again) = sum.overflowing_add(carry);
            (*to, carry) = (sum, u64::from(is_over | is_over_again));
            if word >= product.len() && carry == 0 {
                break;
            }
        }
    }

    /// −1, 0 or 1.
    pub(super) fn sign(&self) -> i32 {
        let [positive, negative] = &self.parts;
        match positive.iter().rev().cmp(negative.iter().rev()) {
            Ordering::Less => -1,
            Ordering::Equal => 0,
            Ordering::Greater => 1,
        }
    }

    /// Whether the quotient of this number and another, which is not 0, is greater than `limit`.
    /// Both are sums of products of at most three factors.
    pub(super) fn is_over(&self, other: &Self, limit: f64) -> bool {
        let mut excess = self.clone();
        excess.add_scaled(other, -limit);
        excess.sign() * other.sign() > 0
    }

    /// The quotient of this number and another, which is not 0, between its bounds: they are a few
    /// units in the last place apart, and equal if it is 0.
    pub(super) fn over(&self, other: &Self) -> [f64; 3] {
        let ((p, power), (q, other_power)) = (self.leading(), other.leading());
        let sign = f64::from(self.sign() * other.sign());
        if sign == 0.0 {
            return [0.0; 3];
        }
        // Both leading numbers have an error of one unit, the quotient another one.
        let (size, error) = (p / q, 4.0 * f64::EPSILON);
        let [least, size, most] =
            [size * (1.0 - error), size, size * (1.0 + error)].map(|size| scaled(size, power - other_power));
        let [least, most] = [least.next_down().max(0.0), most.next_up()];
        if sign > 0.0 { [least, size, most] } else { [-most, -size, -least] }
    }

    /// The size of the number: its leading bits, as a number below 2⁶⁴, and a power of two. 0 if it
    /// is 0.
    fn leading(&self) -> (f64, i32) {
        let [greater, smaller] = if self.sign() < 0 { [1, 0] } else { [0, 1] }.map(|part: usize| &self.parts[part]);
        let (mut words, mut borrow) = ([0; WORDS], false);
        for ((word, p), q) in words.iter_mut().zip(greater).zip(smaller) {
            let (less, is_under) = p.overflowing_sub(*q);
            let (less, is_under_again) = less.overflowing_sub(u64::from(borrow));
            (*word, borrow) = (less, is_under | is_under_again);
        }
        let Some(top) = words.iter().rposition(|word| *word != 0) else { return (0.0, 0) };
        let (high, low) = (words[top], if top > 0 { words[top - 1] } else { 0 });
        let lead = high.leading_zeros();
        let bits = high << lead | low >> 1 >> (63 - lead);
        (bits as f64, LOWEST + 64 * top as i32 - lead as i32)
    }
}

/// The points of a vector, with their signs.
fn signed([from, to]: Way) -> [(DVec3, f64); 2] {
    [(to, 1.0), (from, -1.0)]
}

/// The mantissa of a finite number as an integer, and the exponent of its lowest bit.
fn decoded(number: f64) -> (u64, i32) {
    let bits = number.to_bits();
    let (exponent, mantissa) = ((bits >> 52 & 0x7ff) as i32, bits & ((1 << 52) - 1));
    if exponent == 0 { (mantissa, -1074) } else { (mantissa | 1 << 52, exponent - 1075) }
}

fn times(product: [u64; 4], factor: u64) -> [u64; 4] {
    let mut carry = 0;
    product.map(|word| {
        let wide = u128::from(word) * u128::from(factor) + carry;
        carry = wide >> 64;
        wide as u64
    })
}

/// `size` times a power of two, in steps that f64 has; infinite beyond its range.
fn scaled(mut size: f64, mut power: i32) -> f64 {
    while power != 0 && size != 0.0 && size.is_finite() {
        let step = power.clamp(-1000, 1000);
        size *= f64::from_bits(((step + 1023) as u64) << 52);
        power -= step;
    }
    size
}

#[cfg(test)]
mod tests {
    use super::*;

    const TINY: f64 = f64::from_bits(1);

    fn sum(products: &[[f64; 3]]) -> Sum {
        let mut sum = Sum::new();
        products.iter().for_each(|factors| sum.add(factors));
        sum
    }

    #[test]
    fn sums_are_exact_from_the_smallest_to_the_greatest_numbers() {
        let (big, least) = ([f64::MAX; 3], [TINY; 3]);
        assert_eq!(sum(&[big, least, [f64::MIN, f64::MAX, f64::MAX]]).sign(), 1);
        assert_eq!(sum(&[big, [-TINY, TINY, TINY], [f64::MAX, f64::MIN, f64::MAX]]).sign(), -1);
        assert_eq!(sum(&[big, [f64::MAX, f64::MAX, f64::MIN]]).sign(), 0);
        // (1 + u)(1 − u) = 1 − u² is below 1.
        assert_eq!(sum(&[[1.0 + f64::EPSILON, 1.0 - f64::EPSILON, 1.0], [-1.0, 1.0, 1.0]]).sign(), -1);
    }

    #[test]
    fn quotients_are_within_their_bounds() {
        for (p, q) in [(1.0, 3.0), (-7.0, 0.1), (1e300, 1e-300), (TINY, 3.0), (5.0, -f64::MAX), (8.0, 2.0)] {
            let [least, _, most] = sum(&[[p, 1.0, 1.0]]).over(&sum(&[[q, 1.0, 1.0]]));
            let quotient: f64 = p / q;
            assert!(least <= quotient && quotient <= most, "{p} / {q}: {least}, {most}");
            assert!(most - least <= 16.0 * f64::EPSILON * quotient.abs() + 4.0 * TINY || quotient.is_infinite());
        }
        let (one, three) = (sum(&[[1.0; 3]]), sum(&[[3.0, 1.0, 1.0]]));
        // The closest number to 1/3 is below it.
        assert!(one.is_over(&three, 1.0 / 3.0) && !one.is_over(&three, (1.0_f64 / 3.0).next_up()));
        assert!(!three.is_over(&one, 3.0) && three.is_over(&one, 3.0_f64.next_down()));
    }
}
