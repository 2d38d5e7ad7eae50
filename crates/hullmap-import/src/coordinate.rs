//! Coordinates in text formats (OBJ, STL, PLY), parsed and checked.

use std::str::FromStr;

use crate::fault::{Fault, excerpt};

/// A floating-point type of coordinates.
pub trait Coordinate: FromStr + Copy + PartialEq + Send {
    /// Positive zero.
    const ZERO: Self;
    /// Whether the value is neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// Whether the value is NaN.
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

/// Parses a coordinate and rounds it to the nearest `T`. Fails if the word is not a number, is NaN
/// or infinite, or is too large for `T`.
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
