//! Deadlines.

use std::time::Duration;

/// The time that has passed on a clock since some fixed moment.
pub type Clock = fn() -> Duration;

/// The time at which a computation stops.
#[derive(Clone, Copy, Debug)]
pub struct Deadline {
    clock: Clock,
    start: Duration,
    limit: Duration,
}

impl Deadline {
    /// The deadline `seconds` from now. Infinity and NaN mean never.
    pub fn after(seconds: f64) -> Self {
        Self::by(monotonic, seconds)
    }

    /// The deadline `seconds` from now by the caller's clock.
    pub fn by(clock: Clock, seconds: f64) -> Self {
        let never = if seconds < 0.0 { Duration::ZERO } else { Duration::MAX };
        let limit = Duration::try_from_secs_f64(seconds).unwrap_or(never);
        Self { clock, start: clock(), limit }
    }

    /// An earlier deadline, which leaves `reserve` for what follows: this share of the whole time,
    /// and at most the seconds.
    #[must_use]
    pub fn with_reserve(self, Reserve { share, seconds }: Reserve) -> Self {
        let reserve = (share * self.limit.as_secs_f64()).min(seconds);
        Self { limit: self.limit.saturating_sub(Duration::try_from_secs_f64(reserve).unwrap_or_default()), ..self }
    }

    /// Whether the deadline has passed.
    pub fn is_over(&self) -> bool {
        (self.clock)().saturating_sub(self.start) >= self.limit
    }
}

/// Time that is left for what follows a deadline.
#[derive(Clone, Copy, Debug)]
pub struct Reserve {
    /// Share of the whole time.
    pub share: f64,
    /// Maximum number of seconds.
    pub seconds: f64,
}

/// Whether the time is over; without a deadline, it never is.
pub fn is_over(deadline: Option<Deadline>) -> bool {
    deadline.is_some_and(|deadline| deadline.is_over())
}

/// The time that has passed since the first call.
#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
pub fn monotonic() -> Duration {
    use std::{sync::OnceLock, time::Instant};

    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed()
}

/// Always 0: in the browser, the standard library has no clock. Deadlines do not pass.
#[cfg(all(target_family = "wasm", target_os = "unknown"))]
pub fn monotonic() -> Duration {
    Duration::ZERO
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;

    #[test]
    fn deadlines_pass_when_their_clock_says_so() {
        static NOW: AtomicU64 = AtomicU64::new(7);
        let deadline = Deadline::by(|| Duration::from_secs(NOW.load(Ordering::Relaxed)), 10.0);
        let earlier = deadline.with_reserve(Reserve { share: 0.4, seconds: 3.0 });
        let early = deadline.with_reserve(Reserve { share: 0.4, seconds: 9.0 });
        let passed = |now| {
            NOW.store(now, Ordering::Relaxed);
            [early, earlier, deadline].map(|deadline| deadline.is_over())
        };
        assert_eq!(passed(12), [false; 3]);
        assert_eq!(passed(13), [true, false, false]);
        assert_eq!(passed(14), [true, true, false]);
        assert_eq!(passed(17), [true; 3]);
        // A clock that is set back ends nothing.
        assert_eq!(passed(3), [false; 3]);
        assert!(!is_over(None) && Deadline::after(-1.0).is_over());
        assert!([f64::INFINITY, f64::NAN].iter().all(|seconds| !Deadline::after(*seconds).is_over()));
    }
}
