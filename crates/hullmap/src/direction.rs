//! A direction of a support query, in single or double precision.

/// A direction: what locates it, and what decides between candidates.
pub(crate) trait Direction: Copy {
    /// Rounded to f32.
    fn narrow(self) -> [f32; 3];
    /// In f64, unrounded.
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

/// The same direction with a largest coordinate of 1; the first axis for one that is zero or not finite.
pub(crate) fn in_range(dir: [f64; 3]) -> [f64; 3] {
    let largest = dir.iter().fold(0.0, |largest: f64, c| largest.max(c.abs()));
    if largest > 0.0 && dir.iter().all(|c| c.is_finite()) { dir.map(|c| c / largest) } else { [1.0, 0.0, 0.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_comes_is_in_range_after() {
        for dir in [[1e300, -2e300, 0.0], [5e-324, 0.0, 0.0], [f64::MAX; 3], [1e-310, 3e-310, -2e-310]] {
            let scaled = in_range(dir);
            assert_eq!(scaled.iter().fold(0.0, |m: f64, c| m.max(c.abs())), 1.0, "{dir:?}");
            assert!(scaled.iter().zip(dir).all(|(s, d)| (*s > 0.0) == (d > 0.0)));
        }
        for none in [[0.0; 3], [f64::NAN, 1.0, 1.0], [f64::INFINITY, 0.0, 0.0], [1.0, 2.0, f64::NAN]] {
            assert_eq!(in_range(none), [1.0, 0.0, 0.0]);
        }
    }
}
