//! When a computation stops.

use std::time::{Duration, Instant};

/// The time at which a computation stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deadline {
    start: Instant,
    limit: Duration,
}

impl Deadline {
    /// The deadline `seconds` from now.
    pub fn after(seconds: f64) -> Self {
        let limit = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        Self { start: Instant::now(), limit }
    }

    /// A deadline that is earlier by twice the time so far, and by at least a share of the whole time.
    #[must_use]
    pub fn with_reserve(self, least: f64) -> Self {
        let reserve = self.limit.mul_f64(least).max(self.start.elapsed().saturating_mul(2));
        Self { limit: self.limit.saturating_sub(reserve), ..self }
    }

    /// Whether the deadline has passed.
    pub fn is_over(&self) -> bool {
        self.start.elapsed() >= self.limit
    }
}
