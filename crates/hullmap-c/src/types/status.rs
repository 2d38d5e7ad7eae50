//! How a query ended, and whether two shapes share a point.

/// How a query ended, and thus how narrow its interval is. The interval contains the true value
/// whatever the status is.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The interval is as narrow as rounding error allows.
    Exact = 0,
    /// The interval is within the tolerance.
    Within = 1,
    /// The shapes touch: any gap or penetration is below rounding error.
    Touching = 2,
    /// The shapes overlap.
    Overlapping = 3,
    /// The shapes are certainly separated; of a ray or a cast: certainly no hit.
    Separated = 4,
    /// The iteration limit was reached; the interval is wider than the tolerance.
    IterationLimit = 5,
    /// Rounding error stopped all progress; the interval is wider than the tolerance.
    Stalled = 6,
}

impl From<hullmap::Status> for Status {
    fn from(status: hullmap::Status) -> Self {
        match status {
            hullmap::Status::Exact => Self::Exact,
            hullmap::Status::Within => Self::Within,
            hullmap::Status::Touching => Self::Touching,
            hullmap::Status::Overlapping => Self::Overlapping,
            hullmap::Status::Separated => Self::Separated,
            hullmap::Status::IterationLimit => Self::IterationLimit,
            hullmap::Status::Stalled => Self::Stalled,
        }
    }
}

/// Whether two shapes share a point.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlap {
    /// They share no point: a separating plane proves it.
    Separated = 0,
    /// Their interiors share points.
    Overlapping = 1,
    /// They touch: any gap or penetration is below rounding error.
    Touching = 2,
    /// Not known: an iteration limit was reached, or rounding error stopped all progress.
    Undecided = 3,
}

impl From<hullmap::Overlap> for Overlap {
    fn from(overlap: hullmap::Overlap) -> Self {
        match overlap {
            hullmap::Overlap::Separated => Self::Separated,
            hullmap::Overlap::Overlapping => Self::Overlapping,
            hullmap::Overlap::Touching => Self::Touching,
            hullmap::Overlap::Undecided => Self::Undecided,
        }
    }
}
