//! When a search stops.

use std::time::{Duration, Instant};

/// The time at which a search stops.
#[derive(Clone, Copy, Debug)]
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

    /// Whether the deadline has passed.
    pub fn is_over(&self) -> bool {
        self.start.elapsed() >= self.limit
    }
}
