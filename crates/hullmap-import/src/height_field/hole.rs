//! The value of samples without ground.
//!
//! Programs write the value of a 32-bit sample as a decimal, often rounded: -9999.9 for
//! -9999.900390625, or -3.402823e+38 for the least f32. So a sample of numbers is a hole if
//! 1. it rounds to the same f32 as the value, or
//! 2. the value is in scientific notation with 6 to 17 digits, and the sample, rounded to as many
//!    digits, is the value. C's `%e` and `%g` write such values; an f32 keeps any 6 decimal digits.
//!
//! Other values have no second rule: 0 or 100000 must not remove heights of 0.3 or 100000.2.

use std::fmt;
use std::str::FromStr;

/// Digits in scientific notation from which rounding is expected; at most what f64 distinguishes.
const ROUNDED_DIGITS: std::ops::RangeInclusive<usize> = 6..=17;

/// A value of samples without ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hole {
    value: f64,
    /// Digits of the second rule; 0 if only the first one applies.
    digits: usize,
    /// Half a unit of the last digit.
    slack: f64,
}

impl Hole {
    /// The value, compared by the first rule only.
    pub fn new(value: f64) -> Self {
        Self { value, digits: 0, slack: 0.0 }
    }

    /// Whether a sample of a grid of numbers has no ground. NaN never has, whatever the value.
    pub fn is_number(&self, sample: f64) -> bool {
        let rounded = sample as f32;
        let is_same = sample == self.value || rounded.is_finite() && rounded == self.value as f32;
        is_same || self.digits != 0 && (sample - self.value).abs() <= self.slack
    }

    /// The grey value, if it is one from 0 to `white`.
    pub fn grey(&self, white: u16) -> Option<u16> {
        let is_grey = (0.0..=f64::from(white)).contains(&self.value) && self.value.fract() == 0.0;
        is_grey.then_some(self.value as u16)
    }
}

impl FromStr for Hole {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let value = text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or("expected a finite number")?;
        let Some((mantissa, exponent)) = text.split_once(['e', 'E']) else { return Ok(Self::new(value)) };
        let fraction = mantissa.split_once('.').map_or(0, |(_, fraction)| fraction.len());
        let digits = mantissa.bytes().filter(u8::is_ascii_digit).skip_while(|digit| *digit == b'0').count();
        let last = exponent.parse::<i64>().unwrap_or_default().saturating_sub(fraction as i64);
        let slack = format!("5e{}", last.saturating_sub(1)).parse().unwrap_or(0.0);
        Ok(if ROUNDED_DIGITS.contains(&digits) { Self { value, digits, slack } } else { Self::new(value) })
    }
}

impl fmt::Display for Hole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.digits {
            0 => write!(f, "{}", self.value),
            digits => write!(f, "{:.*e}", digits - 1, self.value),
        }
    }
}
