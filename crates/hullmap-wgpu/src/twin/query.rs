//! The questions that the kernels answer.

/// Which question a pair is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Query {
    /// Yes or no: stop at the first proof.
    Intersects,
    /// The distance, until the interval is within the tolerance.
    Distance,
    /// The penetration depth, until the interval is within the tolerance.
    Contact,
}
