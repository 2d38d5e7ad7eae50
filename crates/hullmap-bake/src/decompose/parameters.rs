//! Parameters of a decomposition.

/// A length, absolute or relative to the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// In the unit of the positions.
    Absolute(f64),
    /// In diagonals of the mesh's box.
    Relative(f64),
}

impl Length {
    /// The length for a mesh with this diagonal.
    pub fn of(self, diagonal: f64) -> f64 {
        match self {
            Self::Absolute(length) => length,
            Self::Relative(share) => share * diagonal,
        }
    }
}

/// Parameters of a cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cover {
    /// Maximum protrusion of a part from the mesh's solid, above 0. With `max_parts`, the search
    /// starts with this limit, or with 1 % of the diagonal if that is more, and finds the smallest
    /// one that suffices.
    pub max_error: Length,
    /// Maximum number of parts, at least 1. It is never exceeded: if `max_error` takes more parts,
    /// `max_error` is exceeded.
    pub max_parts: Option<u32>,
    /// Maximum number of vertices of a part, at least
    /// [`MIN_VERTICES`](crate::simplify::MIN_VERTICES).
    pub max_vertices: u32,
    /// Overlap up to which parts are merged: the sum of their volumes less that of their union,
    /// relative to the latter.
    pub overlap: f64,
    /// Thickness of the parts of a sheet, and of other thin parts, above 0. It is at most half of
    /// the maximum error.
    pub min_thickness: Length,
    /// Time after which the search stops, in seconds. The result then depends on the machine, and
    /// its parts may exceed `max_error`. In the worst case, there are up to eight parts: the hulls
    /// of what the surface is halved into.
    pub seconds: Option<f64>,
}

impl Default for Cover {
    fn default() -> Self {
        Self {
            max_error: Length::Relative(0.02),
            max_parts: None,
            max_vertices: 64,
            overlap: 0.05,
            min_thickness: Length::Relative(0.005),
            seconds: None,
        }
    }
}
