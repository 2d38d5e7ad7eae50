//! Wavefront OBJ: the numbers of a `v` line.

use crate::coordinate::{Coordinate, parse_coordinate};
use crate::fault::{Fault, excerpt};

/// x, y and z. A fourth number is a weight, and three more are a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VertexLine<'a> {
    words: [&'a str; 3],
    weight: Option<&'a str>,
}

impl<'a> VertexLine<'a> {
    /// The words behind the keyword: 3, 4 with a weight, or 6 with a colour, which is not read.
    pub fn new(words: impl Iterator<Item = &'a str>) -> Result<Self, Fault> {
        let mut first = [""; 4];
        let mut found = 0;
        for word in words {
            if let Some(entry) = first.get_mut(found) {
                *entry = word;
            }
            found += 1;
        }
        let [x, y, z, w] = first;
        match found {
            0..3 => Err(Fault::TooFewCoordinates { found }),
            3 | 4 | 6 => Ok(Self { words: [x, y, z], weight: (found == 4).then_some(w) }),
            _ => Err(Fault::CoordinateCount { found }),
        }
    }

    pub fn words(&self) -> &[&'a str] {
        &self.words
    }

    pub fn has_ignored_weight(&self) -> Result<bool, Fault> {
        let Some(weight) = self.weight else {
            return Ok(false);
        };
        let weight: f64 = weight.parse().map_err(|_| Fault::BadNumber { text: excerpt(weight) })?;
        Ok(weight != 1.0)
    }

    /// The point, each coordinate rounded to the nearest `T`. Fails if one is not a finite number.
    pub fn point<T: Coordinate>(&self) -> Result<[T; 3], Fault> {
        let [x, y, z] = self.words;
        Ok([parse_coordinate(x)?, parse_coordinate(y)?, parse_coordinate(z)?])
    }
}
