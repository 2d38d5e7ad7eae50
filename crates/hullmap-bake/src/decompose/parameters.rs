//! Parameters of a decomposition.

use std::fmt;

use crate::fit::{Solid, SolidRule};
use hullmap_geometry::{
    PointSet,
    number::{percent, short},
};

/// Overlap of the parts up to which they are merged: the sum of their volumes less the volume of
/// their union, relative to the latter.
pub const OVERLAP: f64 = 0.05;

/// Maximum number of vertices of one of several parts, unless [`Cover::max_vertices`] states it.
pub const PART_VERTICES: u32 = 64;

/// Maximum number of vertices of the part of a mesh that one part represents within the error, so
/// that it is not divided for its vertices. Engines allow no more (PhysX).
pub const ONE_PART_VERTICES: u32 = 255;

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
    pub fn resolve(self, diagonal: f64) -> f64 {
        match self {
            Self::Absolute(length) => length,
            Self::Relative(share) => share * diagonal,
        }
    }
}

impl fmt::Display for Length {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Absolute(length) => write!(f, "{}", short(*length)),
            Self::Relative(share) => write!(f, "{} of the diagonal", percent(*share)),
        }
    }
}

/// Parameters of a cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cover {
    /// Maximum protrusion of a part from the mesh's solid, above 0. With `max_parts`, the search
    /// for the smallest sufficient limit starts here.
    pub max_error: Length,
    /// Maximum number of parts, at least 1. It has precedence over `max_error`.
    pub max_parts: Option<u32>,
    /// Maximum number of vertices of a part, at least
    /// [`MIN_VERTICES`](crate::simplify::MIN_VERTICES). `None`: [`PART_VERTICES`], and
    /// [`ONE_PART_VERTICES`] for a mesh that one part represents within the error.
    pub max_vertices: Option<u32>,
    /// The rule for the solid of an open mesh.
    pub solid: SolidRule,
    /// Thickness of the parts of walls, and least thickness of any part, above 0. It is at most
    /// half of the maximum error.
    pub wall: Length,
    /// Time to search, finish and measure the parts of a mesh, in seconds. A fifth of it, but at
    /// most four seconds, is left for measuring. The result then depends on the machine, and may
    /// exceed `max_error`; in the worst case it is up to eight hulls of halves of the surface.
    pub seconds: Option<f64>,
}

impl Default for Cover {
    fn default() -> Self {
        Self {
            max_error: Length::Relative(0.02),
            max_parts: None,
            max_vertices: None,
            solid: SolidRule::Auto,
            wall: Length::Relative(0.005),
            seconds: None,
        }
    }
}

impl Cover {
    /// Maximum number of vertices of one of several parts.
    pub fn part_vertices(&self) -> u32 {
        self.max_vertices.unwrap_or(PART_VERTICES)
    }

    /// Maximum number of vertices of a mesh's only part.
    pub fn one_part_vertices(&self) -> u32 {
        self.max_vertices.unwrap_or(ONE_PART_VERTICES)
    }

    /// The solid from which protrusion is measured.
    ///
    /// # Complexity
    /// The cost of [`Solid::by`].
    pub fn solid_of(&self, mesh: &PointSet) -> Solid {
        Solid::by(mesh, self.solid)
    }
}
