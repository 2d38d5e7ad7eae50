//! Settings of distance and contact queries: tolerance and iteration limit.

/// Accuracy and effort of [`distance`](crate::distance) and [`contact`](crate::contact).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Maximum width of the interval, relative to its upper bound. Dimensionless.
    ///
    /// NaN and negative values count as 0: the interval becomes as narrow as rounding error allows.
    pub tolerance: f64,
    /// Maximum number of steps of the last phase: GJK for a distance, EPA for a contact.
    ///
    /// A query that reaches it returns [`Status::IterationLimit`](crate::Status::IterationLimit),
    /// and its interval still contains the true value. Larger values than the solver's own limits
    /// have no effect.
    ///
    /// With 0, [`contact`](crate::contact) stops after portal refinement (MPR), as Kenwright's
    /// paper does: the depth along the normal of the portal that the centre ray pierces. It is a
    /// true upper bound, and may be far above the depth.
    pub max_iterations: u32,
}

impl Settings {
    /// 1e-5, relative: below what a physics step can resolve, above the rounding error of f32
    /// coordinates.
    pub const DEFAULT_TOLERANCE: f64 = 1e-5;

    /// About as many steps as the largest polytope has room for.
    pub const DEFAULT_MAX_ITERATIONS: u32 = 1000;

    /// Stack in bytes that is enough for every query with these settings and without
    /// [`Scratch`](crate::Scratch): on 64-bit processors, in an optimised build, in addition to
    /// what a user's own shape needs.
    ///
    /// Depends on the maximum number of iterations, because each adds at most one vertex to the
    /// polytope of EPA. The stack of a thread is 1 MB or more by default. With a `Scratch`,
    /// [`Scratch::STACK_SIZE`](crate::Scratch::STACK_SIZE) is enough for all settings.
    ///
    /// # Reference
    /// Measured: `tests/stack.rs` runs every query on a stack of this size.
    ///
    /// # Examples
    /// ```
    /// use hullmap::Settings;
    ///
    /// assert_eq!(Settings::default().stack_size(), 384 * 1024);
    /// assert_eq!(Settings { max_iterations: 200, ..Settings::default() }.stack_size(), 128 * 1024);
    /// ```
    pub const fn stack_size(&self) -> usize {
        if self.max_iterations <= super::epa::MAX_BIG_EXPANSIONS { 128 * 1024 } else { 384 * 1024 }
    }

    /// The tolerance, with 0 for NaN and for negative values.
    pub(crate) fn relative_tolerance(&self) -> f64 {
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
    fn invalid_tolerances_count_as_zero() {
        for tolerance in [f64::NAN, -1.0, 0.0] {
            assert_eq!(Settings { tolerance, ..Settings::default() }.relative_tolerance(), 0.0);
        }
    }
}
