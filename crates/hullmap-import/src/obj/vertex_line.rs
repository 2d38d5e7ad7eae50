//! Wavefront OBJ: the numbers of a `v` line.

use crate::coordinate::{Coordinate, parse_coordinate};
use crate::fault::{Fault, excerpt};

/// Words of a `v` line that define a point: x, y, z, and the weight w where the line has exactly
/// four.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VertexLine<'a> {
    words: [&'a str; 4],
    has_weight: bool,
}

impl<'a> VertexLine<'a> {
    /// Takes the words behind the keyword. The last three of six are a colour, which is not read.
    ///
    /// # Errors
    /// The line has neither 3, 4 nor 6 numbers.
    pub fn new(words: impl Iterator<Item = &'a str>) -> Result<Self, Fault> {
        let mut first = [""; 4];
        let mut found = 0;
        for word in words {
            if let Some(slot) = first.get_mut(found) {
                *slot = word;
            }
            found += 1;
        }
        match found {
            0..3 => Err(Fault::TooFewCoordinates { found }),
            3 | 4 | 6 => Ok(Self { words: first, has_weight: found == 4 }),
            _ => Err(Fault::CoordinateCount { found }),
        }
    }

    /// The three or four words.
    pub fn words(&self) -> &[&'a str] {
        self.words.get(..if self.has_weight { 4 } else { 3 }).unwrap_or_default()
    }

    /// The weight, where there is one.
    ///
    /// # Errors
    /// It is not a finite number, or is zero.
    pub fn weight<T: Coordinate>(&self) -> Result<Option<T>, Fault> {
        let [.., weight] = self.words;
        if !self.has_weight {
            return Ok(None);
        }
        let weight: T = parse_coordinate(weight)?;
        if weight == T::ZERO { Err(Fault::ZeroWeight) } else { Ok(Some(weight)) }
    }

    /// The point: each coordinate rounded to the nearest `T`, then divided by the weight.
    ///
    /// # Errors
    /// A coordinate, the weight or a quotient is not a finite number, or the weight is zero.
    pub fn point<T: Coordinate>(&self) -> Result<[T; 3], Fault> {
        let [x, y, z, _] = self.words;
        let mut point = [parse_coordinate::<T>(x)?, parse_coordinate(y)?, parse_coordinate(z)?];
        if let Some(weight) = self.weight::<T>()? {
            for (coordinate, word) in point.iter_mut().zip(self.words) {
                *coordinate = *coordinate / weight;
                if !coordinate.is_finite() {
                    return Err(Fault::Overflow { text: excerpt(&format!("{word} / {weight}")) });
                }
            }
        }
        Ok(point)
    }
}
