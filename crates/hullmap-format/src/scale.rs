//! A scale of 16 bits: coordinates between two bounds, by numbers from 0 to 65535. A box of a tree
//! that is rounded outwards to it contains the exact box.

/// Positions between a lower and an upper bound.
///
/// # Examples
/// ```
/// use hullmap_format::scale::Scale;
///
/// let scale = Scale::new(0.0, 65535.0);
/// assert_eq!((scale.below(2.5), scale.above(2.5)), (2, 3));
/// assert_eq!((scale.below(7.0), scale.above(7.0)), (7, 7));
/// assert_eq!(scale.position(65535), 65535.0);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    low: f64,
    high: f64,
    step: f64,
}

impl Scale {
    /// The positions between these bounds.
    pub fn new(low: f32, high: f32) -> Self {
        let (low, high) = (f64::from(low), f64::from(high));
        Self { low, high, step: (high - low) / f64::from(u16::MAX) }
    }

    /// The coordinate of a number: 0 is the lower bound, 65535 the upper one. It is monotone.
    #[inline]
    pub fn position(&self, number: u16) -> f64 {
        match number {
            0 => self.low,
            u16::MAX => self.high,
            _ => (self.low + f64::from(number) * self.step).min(self.high),
        }
    }

    /// The distance between the coordinates of consecutive numbers, up to rounding.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// The greatest number at or below a coordinate within the bounds; 0 if the bounds are equal.
    pub fn below(&self, coordinate: f64) -> u16 {
        // NaN takes the failing branch. Without extent all numbers have one coordinate.
        if !(self.step > 0.0) {
            return 0;
        }
        // A cast saturates. The guess is off by one at most: a step is at least 2⁻⁴⁰ of a
        // coordinate, since the bounds are of f32.
        let mut low = ((coordinate - self.low) / self.step) as u16;
        while low > 0 && self.position(low) > coordinate {
            low -= 1;
        }
        while low < u16::MAX && self.position(low + 1) <= coordinate {
            low += 1;
        }
        low
    }

    /// The smallest number at or above a coordinate within the bounds; 0 if the bounds are equal.
    pub fn above(&self, coordinate: f64) -> u16 {
        let low = self.below(coordinate);
        if self.step > 0.0 && self.position(low) < coordinate { low.saturating_add(1) } else { low }
    }
}
