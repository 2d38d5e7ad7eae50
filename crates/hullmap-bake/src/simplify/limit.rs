//! How far a hull is simplified.

/// How far to simplify a hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// Maximum number of vertices, at least [`MIN_VERTICES`]. The result is as near to the hull as
    /// the search finds.
    Vertices(usize),
    /// Maximum distance from the hull, in the points' units. The result has as few vertices as the
    /// search finds.
    Distance(f64),
}

/// Minimum number of vertices that may be requested: a tetrahedron's.
pub const MIN_VERTICES: usize = 4;
