//! Kinds of primitive that may replace a convex part: `box`, `sphere`, `capsule`, `cylinder`.

use std::fmt;

/// The shape of a primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PrimitiveKind {
    /// A cuboid, with three half extents.
    Box,
    /// A ball, with a radius.
    Sphere,
    /// All points within a radius of a segment along z, with half of its length.
    Capsule,
    /// A cylinder along z, with a radius and half of its height.
    Cylinder,
}

impl PrimitiveKind {
    /// All kinds, in order of their codes.
    pub const ALL: [Self; 4] = [Self::Box, Self::Sphere, Self::Capsule, Self::Cylinder];

    /// Name of the kind.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Sphere => "sphere",
            Self::Capsule => "capsule",
            Self::Cylinder => "cylinder",
        }
    }

    /// Code of the kind in a record.
    pub const fn code(self) -> u32 {
        match self {
            Self::Box => 1,
            Self::Sphere => 2,
            Self::Capsule => 3,
            Self::Cylinder => 4,
        }
    }

    /// The kind with this code.
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.code() == code)
    }

    /// Number of lengths that describe the size of a primitive of this kind.
    pub const fn size_count(self) -> usize {
        match self {
            Self::Box => 3,
            Self::Sphere => 1,
            Self::Capsule | Self::Cylinder => 2,
        }
    }
}

impl fmt::Display for PrimitiveKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_match_the_document() {
        assert_eq!(PrimitiveKind::ALL.map(PrimitiveKind::code), [1, 2, 3, 4]);
        assert_eq!((0..9).map(PrimitiveKind::from_code).filter(Option::is_some).count(), 4);
    }
}
