//! How exact an answer is asked for, and how long to try.

/// What a caller asks of [`distance`](crate::distance) and [`contact`](crate::contact).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Width of the interval that is good enough, relative to its upper end. Dimensionless; NaN and negative
    /// values count as 0, which asks for all that rounding allows.
    pub tolerance: f64,
    /// Most steps of the last phase (closest point, or expansion). Reaching it is
    /// [`Status::IterationLimit`](crate::Status::IterationLimit); the interval still holds. The solver's own caps
    /// are upper limits to it.
    ///
    /// With 0, [`contact`](crate::contact) is the paper's own algorithm: the depth along the normal of the portal that
    /// the centres' line meets, which is a true upper bound and no more.
    pub max_iterations: u32,
}

impl Settings {
    /// 1e-5 of a distance or depth: below what a physics step can see, above what single-precision coordinates round.
    pub const DEFAULT_TOLERANCE: f64 = 1e-5;

    /// As many steps as the expansion has room for.
    pub const DEFAULT_MAX_ITERATIONS: u32 = 1000;

    /// The tolerance, made safe: NaN and negative numbers are 0.
    pub(crate) fn relative_gap(&self) -> f64 {
        self.tolerance.max(0.0)
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self { tolerance: Self::DEFAULT_TOLERANCE, max_iterations: Self::DEFAULT_MAX_ITERATIONS }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn senseless_tolerances_ask_for_everything() {
        for tolerance in [f64::NAN, -1.0, 0.0] {
            assert_eq!(Settings { tolerance, ..Settings::default() }.relative_gap(), 0.0);
        }
    }
}
