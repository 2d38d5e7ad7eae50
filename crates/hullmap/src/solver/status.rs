//! How an answer came to be: no numerical trouble is silent.

use std::fmt;

/// How far an interval (of a distance or a depth) can be trusted to be as narrow as was asked.
///
/// The interval itself holds the truth under every status.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// The interval is as narrow as rounding allows.
    Exact,
    /// The interval is as narrow as [`Settings::tolerance`](crate::Settings::tolerance) asks.
    Within,
    /// The shapes touch: whether they are a hair apart or a hair deep is below rounding.
    Touching,
    /// The shapes overlap. Only from [`distance`](crate::distance), which then is 0.
    Overlapping,
    /// The shapes are apart, proved by a separating plane. Only from [`contact`](crate::contact).
    Separated,
    /// A cap on steps was reached first; the interval is wider than asked.
    IterationLimit,
    /// Rounding stopped all progress first; the interval is wider than asked.
    Stalled,
}

impl Status {
    /// The status as one lower-case word, for JSON and tables. Other programs may rely on it.
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Overlap {
    /// No: a plane lies between them.
    Separated,
    /// They share inner points.
    Overlapping,
    /// They touch, within rounding; a hair apart and a hair deep cannot be told from each other.
    Touching,
    /// A cap on steps was reached, or rounding stopped all progress: not settled.
    Undecided,
}

impl Overlap {
    /// The answer as one lower-case word, for JSON and tables. Other programs may rely on it.
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
