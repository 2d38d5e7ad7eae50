//! Status of an answer: numerical trouble is always visible to the caller.

use std::fmt;

/// How a distance or contact query ended, and thus how narrow its interval is.
///
/// The interval contains the true value whatever the status is.
///
/// ```
/// use hullmap::Status;
///
/// assert_eq!(Status::IterationLimit.to_string(), "iteration_limit");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// The interval is as narrow as rounding error allows.
    Exact,
    /// The interval is within [`Settings::tolerance`](crate::Settings::tolerance).
    Within,
    /// The shapes touch: rounding error leaves open whether they overlap. A gap or a penetration is
    /// at most 64 rounding errors: docs/contributors/intervals.md, section 6, states them. For
    /// baked hulls near the origin, that is 1e-10 of the sum of their outer radii.
    Touching,
    /// The shapes overlap. Only [`distance`](crate::distance) returns it, with a distance of 0.
    Overlapping,
    /// A separating plane proves the shapes separated. Only [`contact`](crate::contact) returns it.
    Separated,
    /// The iteration limit was reached; the interval is wider than the tolerance, or the witness
    /// points are less accurate than the interval.
    IterationLimit,
    /// Rounding error stopped all progress; the interval is wider than the tolerance, or the
    /// witness points are less accurate than the interval.
    Stalled,
}

impl Status {
    /// The status in snake case, for JSON and tables. The names are stable.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Within => "within",
            Self::Touching => "touching",
            Self::Overlapping => "overlapping",
            Self::Separated => "separated",
            Self::IterationLimit => "iteration_limit",
            Self::Stalled => "stalled",
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// Whether two shapes share a point.
///
/// ```
/// use hullmap::Overlap;
///
/// assert_eq!(Overlap::Separated.as_str(), "separated");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Overlap {
    /// They share no point: a separating plane proves it.
    Separated,
    /// Their interiors share points.
    Overlapping,
    /// They touch, as [`Status::Touching`] defines it.
    Touching,
    /// Not known: an iteration limit was reached, or rounding error stopped all progress.
    Undecided,
}

impl Overlap {
    /// The answer as one lower-case word, for JSON and tables. The names are stable.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Separated => "separated",
            Self::Overlapping => "overlapping",
            Self::Touching => "touching",
            Self::Undecided => "undecided",
        }
    }
}

impl fmt::Display for Overlap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}
