//! Numbers without rounding: an integer times a power of two, and vectors of them.

use std::cmp::Ordering;

use glam::DVec3;
use num_bigint::{BigInt, Sign};

/// An integer times a power of two.
#[derive(Clone, Debug)]
pub struct Dyadic {
    integer: BigInt,
    exponent: i32,
}

impl Dyadic {
    /// The exact value of `x`. Panics if `x` is not finite.
    pub fn new(x: f64) -> Self {
        assert!(x.is_finite(), "{x} has no exact value");
        let bits = x.to_bits();
        let (fraction, biased) = (bits & ((1 << 52) - 1), (bits >> 52 & 0x7ff) as i32);
        let (mantissa, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
        let zeros = if mantissa == 0 { 0 } else { mantissa.trailing_zeros() };
        let integer = BigInt::from(mantissa >> zeros);
        Self { integer: if x < 0.0 { -integer } else { integer }, exponent: exponent + zeros as i32 }
    }

    /// `integer` times 2 to the power of `exponent`.
    pub fn scaled(integer: BigInt, exponent: i32) -> Self {
        Self { integer, exponent }
    }

    /// The number times 2 to the power of `digits`, rounded down.
    pub fn integer(&self, digits: i32) -> BigInt {
        let shift = self.exponent + digits;
        if shift >= 0 { &self.integer << shift } else { &self.integer >> -shift }
    }

    /// The number with at most 60 of its digits.
    pub fn rounded(&self) -> f64 {
        let excess = self.integer.bits().saturating_sub(60);
        let digits = i64::try_from(&self.integer >> excess).unwrap_or_default();
        let exponent = excess as i32 + self.exponent;
        digits as f64 * f64::from(exponent / 2).exp2() * f64::from(exponent - exponent / 2).exp2()
    }

    /// 0.
    pub fn zero() -> Self {
        Self { integer: BigInt::ZERO, exponent: 0 }
    }

    /// Both integers under the lower of both exponents.
    fn aligned(&self, other: &Self) -> (BigInt, BigInt, i32) {
        let exponent = self.exponent.min(other.exponent);
        let shifted = |x: &Self| &x.integer << (x.exponent - exponent) as usize;
        (shifted(self), shifted(other), exponent)
    }

    /// The sum.
    pub fn plus(&self, other: &Self) -> Self {
        let (a, b, exponent) = self.aligned(other);
        Self { integer: a + b, exponent }
    }

    /// The difference.
    pub fn minus(&self, other: &Self) -> Self {
        let (a, b, exponent) = self.aligned(other);
        Self { integer: a - b, exponent }
    }

    /// The product.
    pub fn times(&self, other: &Self) -> Self {
        Self { integer: &self.integer * &other.integer, exponent: self.exponent + other.exponent }
    }

    /// The order of both.
    pub fn compare(&self, other: &Self) -> Ordering {
        let (a, b, _) = self.aligned(other);
        a.cmp(&b)
    }

    /// The order of the number and 0.
    pub fn sign(&self) -> Ordering {
        match self.integer.sign() {
            Sign::Minus => Ordering::Less,
            Sign::NoSign => Ordering::Equal,
            Sign::Plus => Ordering::Greater,
        }
    }
}

/// A point or a vector without rounding.
pub type Vector = [Dyadic; 3];

/// The exact value of a point.
pub fn exact(p: DVec3) -> Vector {
    p.to_array().map(Dyadic::new)
}

/// a − b.
pub fn minus(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|i| a[i].minus(&b[i]))
}

/// a × b.
pub fn cross(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j].times(&b[k]).minus(&a[k].times(&b[j]))
    })
}

/// a · b.
pub fn dot(a: &Vector, b: &Vector) -> Dyadic {
    a[0].times(&b[0]).plus(&a[1].times(&b[1])).plus(&a[2].times(&b[2]))
}

/// Whether all components are 0.
pub fn is_zero(a: &Vector) -> bool {
    a.iter().all(|c| c.sign() == Ordering::Equal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dyadic_numbers_are_exact() {
        let third = Dyadic::new(1.0 / 3.0);
        let sum = third.plus(&third).plus(&third);
        assert_eq!(sum.compare(&Dyadic::new(1.0)), Ordering::Less);
        assert_eq!(Dyadic::new(-0.0).sign(), Ordering::Equal);
        assert_eq!(Dyadic::new(5e-324).sign(), Ordering::Greater);
        let product = Dyadic::new(1e-300).times(&Dyadic::new(1e-300));
        assert_eq!(product.compare(&Dyadic::new(0.0)), Ordering::Greater);
        assert_eq!(Dyadic::new(0.5).minus(&Dyadic::new(0.25)).compare(&Dyadic::new(0.25)), Ordering::Equal);
    }
}
