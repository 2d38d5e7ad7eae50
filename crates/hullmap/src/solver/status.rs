//! Status of an answer: numerical trouble is always visible to the caller.

use crate::fields::words;

/// How a distance or contact query ended, and thus how narrow its interval is.
///
/// The interval contains the true value whatever the status is.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// The interval is as narrow as rounding error allows.
    Exact = 0,
    /// The interval is within [`Settings::tolerance`](crate::Settings::tolerance).
    Within = 1,
    /// The shapes touch: rounding error leaves open whether they overlap. A gap or a penetration is
    /// at most 64 rounding errors: docs/contributors/intervals.md, section 6, states them. For
    /// baked hulls near the origin, that is 1e-10 of the sum of their outer radii.
    Touching = 2,
    /// The shapes overlap: their distance is 0, or a ray or a motion starts so.
    Overlapping = 3,
    /// Certainly no contact, or no hit of a ray or a motion: a separating plane proves it.
    Separated = 4,
    /// The iteration limit was reached; the interval is wider than the tolerance, or the witness
    /// points are less accurate than the interval.
    IterationLimit = 5,
    /// Rounding error stopped all progress; the interval is wider than the tolerance, or the
    /// witness points are less accurate than the interval.
    Stalled = 6,
}

words!(
    Status {
        Exact = "exact" Within = "within" Touching = "touching" Overlapping = "overlapping"
        Separated = "separated" IterationLimit = "iteration_limit" Stalled = "stalled"
    }
);

/// Whether two shapes share a point.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Overlap {
    /// They share no point: a separating plane proves it. Any other status counts as a hit.
    Separated = 0,
    /// Their interiors share points.
    Overlapping = 1,
    /// They touch, as [`Status::Touching`] defines it.
    Touching = 2,
    /// Not known: an iteration limit was reached, or rounding error stopped all progress.
    Undecided = 3,
}

words!(
    Overlap {
        Separated = "separated" Overlapping = "overlapping" Touching = "touching"
        Undecided = "undecided"
    }
);
