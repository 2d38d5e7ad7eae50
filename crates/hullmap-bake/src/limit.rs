//! How far a hull is simplified.

/// How far to simplify a hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// Maximum number of vertices, at least [`MIN_VERTICES`]; as near to the hull as found.
    Vertices(usize),
    /// Maximum distance from the hull, in the points' units; with as few vertices as found.
    Distance(f64),
}

/// Minimum number of vertices that may be requested: a tetrahedron's.
pub const MIN_VERTICES: usize = 4;
