//! Coordinates in text formats (OBJ, STL, PLY), parsed and checked.

use std::str::FromStr;

use crate::fault::{Fault, excerpt};

/// Type of a mesh's coordinates.
pub trait Coordinate: FromStr + Copy + Default + PartialEq + Into<f64> + Send {}

impl Coordinate for f32 {}
impl Coordinate for f64 {}

/// Rounds to the nearest `T`. Fails for NaN, infinity, and numbers too large for `T`.
pub fn parse_coordinate<T: Coordinate>(word: &str) -> Result<T, Fault> {
    let text = || excerpt(word);
    match word.parse::<T>() {
        Ok(value) if value.into().is_finite() => Ok(value),
        Ok(value) if value.into().is_nan() => Err(Fault::NotANumber { text: text() }),
        Ok(_) if word.contains(|c: char| c.is_ascii_digit()) => Err(Fault::Overflow { text: text() }),
        Ok(_) => Err(Fault::Infinite { text: text() }),
        Err(_) => Err(Fault::BadNumber { text: text() }),
    }
}
