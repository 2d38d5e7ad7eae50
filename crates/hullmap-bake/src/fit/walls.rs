//! Whether the solid of an open mesh is its inside or its walls.
//!
//! A pot, a bottle or a room that is modelled in one layer has openings that bodies must be able to
//! enter. A scan has holes that nobody wants.

use std::fmt;

use hullmap_geometry::triangle::Triangle;

/// Share of its area that has faces on both sides, from which a mesh is its walls: modellers double
/// the faces of walls that are seen from both sides.
const DOUBLED: f64 = 0.5;

/// Area of a hole relative to the mesh's, above which the mesh is its walls. The mouth of a cup of
/// one layer, as high as it is wide, has a fifth, the bottom that the teapot of V-HACD lacks 12 %,
/// and a hole of a scan at most 2 %.
const MOUTH: f64 = 0.125;

/// Rule for the solid of an open mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SolidRule {
    /// The walls of a mesh that is open, if half of its area has faces on both sides, or a hole has
    /// more than an eighth of its area. Otherwise its inside, after its holes are closed.
    #[default]
    Auto,
    /// Its inside, after its holes are closed.
    Closed,
    /// Its triangles alone.
    Walls,
}

impl SolidRule {
    /// All rules, the default first.
    pub const ALL: [Self; 3] = [Self::Auto, Self::Closed, Self::Walls];

    /// Name of the rule.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Closed => "closed",
            Self::Walls => "walls",
        }
    }

    /// Whether the solid of a mesh is its walls. `is_first` states for each of its triangles
    /// whether it repeats none before it; `holes` are the triangles that close each of its holes.
    pub(super) fn is_walls(self, triangles: &[Triangle], is_first: &[bool], holes: &[Vec<Triangle>]) -> bool {
        if self != Self::Auto {
            return self == Self::Walls;
        }
        let of = |triangles: &[Triangle]| triangles.iter().map(area).sum::<f64>();
        let once: f64 = triangles.iter().zip(is_first).filter(|(_, first)| **first).map(|(t, _)| area(t)).sum();
        let doubled = of(triangles) - once;
        !holes.is_empty() && (doubled >= DOUBLED * once || holes.iter().any(|hole| of(hole) > MOUTH * once))
    }
}

impl fmt::Display for SolidRule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

fn area([a, b, c]: &Triangle) -> f64 {
    0.5 * (*b - *a).cross(*c - *a).length()
}
