//! What counts as the inside of the mesh that convex parts stand for.

use std::fmt;

/// What counts as the inside of the mesh that convex parts stand for. It decides from where a part's
/// protrusion is measured.
///
/// # Examples
/// ```
/// use hullmap_format::SolidKind;
///
/// assert_eq!(SolidKind::Watertight.to_string(), "watertight");
/// assert_eq!(SolidKind::from_code(SolidKind::Sheet.code()), Some(SolidKind::Sheet));
/// assert_eq!(SolidKind::from_code(0), None, "unmeasured");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SolidKind {
    /// The mesh is closed. Its winding number decides what is inside.
    Watertight,
    /// The mesh has holes, and each was closed by a cone over its border before the winding number
    /// was evaluated.
    Closed,
    /// The mesh has no inside: protrusion is the distance from its surface.
    Sheet,
}

impl SolidKind {
    /// All kinds, in order of their codes.
    pub const ALL: [Self; 3] = [Self::Watertight, Self::Closed, Self::Sheet];

    /// Name of the kind.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Watertight => "watertight",
            Self::Closed => "closed",
            Self::Sheet => "sheet",
        }
    }

    /// Code of the kind in [`HullRecord::solid`](crate::archive::HullRecord::solid), at least 1: 0
    /// stands for a hull that was not measured.
    pub const fn code(self) -> u32 {
        match self {
            Self::Watertight => 1,
            Self::Closed => 2,
            Self::Sheet => 3,
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
    fn codes_are_those_of_the_document() {
        assert_eq!(SolidKind::ALL.map(SolidKind::code), [1, 2, 3]);
        assert_eq!((0..6).map(SolidKind::from_code).filter(Option::is_some).count(), 3);
    }
}
