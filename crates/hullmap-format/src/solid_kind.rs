//! Kinds of solid that the parts of a mesh are measured against: `watertight`, `closed`, `walls`.

use std::fmt;

/// How the solid bounded by a mesh was determined. A part's protrusion is measured from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SolidKind {
    /// Bounded by the triangles of the mesh: where their winding number is not 0.
    Watertight,
    /// Holes were closed by cones over their loops, which decide what is inside near them.
    Closed,
    /// Surfaces that are open or enclose nothing are their triangles alone. Closed ones may be
    /// solid.
    Walls,
}

impl SolidKind {
    /// All kinds, in order of their codes.
    pub const ALL: [Self; 3] = [Self::Watertight, Self::Closed, Self::Walls];

    /// Name of the kind.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Watertight => "watertight",
            Self::Closed => "closed",
            Self::Walls => "walls",
        }
    }

    /// Code of the kind in [`HullRecord::solid`](crate::archive::HullRecord::solid), at least 1: 0
    /// stands for a hull that was not measured.
    pub const fn code(self) -> u32 {
        match self {
            Self::Watertight => 1,
            Self::Closed => 2,
            Self::Walls => 3,
        }
    }

    /// The kind with this code.
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.code() == code)
    }
}

impl fmt::Display for SolidKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_match_the_document() {
        assert_eq!(SolidKind::ALL.map(SolidKind::code), [1, 2, 3]);
        assert_eq!((0..6).map(SolidKind::from_code).filter(Option::is_some).count(), 3);
    }
}
