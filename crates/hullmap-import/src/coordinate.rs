//! Coordinates in text, or why they are none.

use crate::fault::{Fault, excerpt};

/// A floating-point type that coordinates are read as.
pub trait Coordinate: std::str::FromStr + Copy {
    /// Whether it is neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// Whether it is NaN.
    fn is_nan(self) -> bool;
}

impl Coordinate for f32 {
    fn is_finite(self) -> bool {
        self.is_finite()
    }
    fn is_nan(self) -> bool {
        self.is_nan()
    }
}

impl Coordinate for f64 {
    fn is_finite(self) -> bool {
        self.is_finite()
    }
    fn is_nan(self) -> bool {
        self.is_nan()
    }
}

/// A coordinate, rounded to the nearest, or why it is none.
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
