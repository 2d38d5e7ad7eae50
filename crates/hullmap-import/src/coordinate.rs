//! Coordinates in text formats (OBJ, STL, PLY), parsed and checked.

use std::str::FromStr;

use crate::fault::{Fault, excerpt};

pub trait Coordinate: FromStr + Copy + PartialEq + Send {
    /// Positive zero.
    const ZERO: Self;
    fn is_finite(self) -> bool;
    fn is_nan(self) -> bool;
}

impl Coordinate for f32 {
    const ZERO: f32 = 0.0;
    fn is_finite(self) -> bool {
        self.is_finite()
    }
    fn is_nan(self) -> bool {
        self.is_nan()
    }
}

impl Coordinate for f64 {
    const ZERO: f64 = 0.0;
    fn is_finite(self) -> bool {
        self.is_finite()
    }
    fn is_nan(self) -> bool {
        self.is_nan()
    }
}

/// Rounds to the nearest `T`. Fails for NaN, infinity, and numbers too large for `T`.
pub fn parse_coordinate<T: Coordinate>(word: &str) -> Result<T, Fault> {
    let text = || excerpt(word);
    match word.parse::<T>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(value) if value.is_nan() => Err(Fault::NotANumber { text: text() }),
        Ok(_) if word.contains(|c: char| c.is_ascii_digit()) => Err(Fault::Overflow { text: text() }),
        Ok(_) => Err(Fault::Infinite { text: text() }),
        Err(_) => Err(Fault::BadNumber { text: text() }),
    }
}
