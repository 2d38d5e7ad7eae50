//! Direction of a support query, in single or double precision.

/// A query direction: f32 locates its cell and filters candidates, f64 decides near ties.
pub(crate) trait Direction: Copy {
    /// The direction rounded to f32.
    fn narrow(self) -> [f32; 3];
    /// The direction in f64, without rounding.
    fn exact(self) -> [f64; 3];
}

impl Direction for [f32; 3] {
    #[inline]
    fn narrow(self) -> [f32; 3] {
        self
    }

    #[inline]
    fn exact(self) -> [f64; 3] {
        self.map(f64::from)
    }
}

impl Direction for [f64; 3] {
    #[inline]
    fn narrow(self) -> [f32; 3] {
        self.map(|c| c as f32)
    }

    #[inline]
    fn exact(self) -> [f64; 3] {
        self
    }
}

/// `dir` scaled so that its largest coordinate magnitude is 1; the x axis if `dir` is zero or not
/// finite.
pub(crate) fn normalise_range(dir: [f64; 3]) -> [f64; 3] {
    let largest = dir.iter().fold(0.0, |largest: f64, c| largest.max(c.abs()));
    if largest > 0.0 && dir.iter().all(|c| c.is_finite()) { dir.map(|c| c / largest) } else { [1.0, 0.0, 0.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_direction_is_brought_into_range() {
        for dir in [[1e300, -2e300, 0.0], [5e-324, 0.0, 0.0], [f64::MAX; 3], [1e-310, 3e-310, -2e-310]] {
            let scaled = normalise_range(dir);
            assert_eq!(scaled.iter().fold(0.0, |m: f64, c| m.max(c.abs())), 1.0, "{dir:?}");
            assert!(scaled.iter().zip(dir).all(|(s, d)| (*s > 0.0) == (d > 0.0)));
        }
        for invalid in [[0.0; 3], [f64::NAN, 1.0, 1.0], [f64::INFINITY, 0.0, 0.0], [1.0, 2.0, f64::NAN]] {
            assert_eq!(normalise_range(invalid), [1.0, 0.0, 0.0]);
        }
    }
}
