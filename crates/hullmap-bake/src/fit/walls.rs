//! Whether open surfaces of a mesh are walls, or bound an inside after their holes are closed.
//!
//! A pot, a bottle or a room that is modelled in one layer has openings that bodies must be able to
//! enter. A scan has holes that nobody wants.

use std::fmt;

use glam::DVec3;
use hullmap_geometry::triangle::Triangle;

use super::closing;

/// Share of its area that has faces on both sides, from which an open surface is walls: modellers
/// double the faces of walls that are seen from both sides.
const DOUBLED: f64 = 0.5;

/// Area of a hole relative to the open surfaces, above which they are walls. The mouth of a cup of
/// one layer, as high as it is wide, has a fifth, the bottom that the teapot of V-HACD lacks 12 %,
/// and a hole of a scan at most 2 %.
const MOUTH: f64 = 0.125;

/// Rule for the solid of an open mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SolidRule {
    /// Open surfaces are walls if half of their area has faces on both sides, if a hole has more
    /// than an eighth of their area, or if all holes together have more than their area. Otherwise
    /// their holes are closed. The inside of closed surfaces is solid.
    #[default]
    Auto,
    /// The inside, after all holes are closed.
    Closed,
    /// All triangles, and no inside.
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

    /// For each triangle, whether it is a wall; `None` if none is one. Triangles that are not
    /// `distinct` repeat another one.
    pub(super) fn walls(
        self,
        positions: &[DVec3],
        triangles: &[[u32; 3]],
        distinct: &[bool],
        is_closed: bool,
    ) -> Option<Vec<bool>> {
        if self != Self::Auto {
            return (self == Self::Walls).then(|| vec![true; triangles.len()]);
        }
        if is_closed {
            return None;
        }
        let is_open = closing::are_open(triangles, distinct);
        let open = |first: bool| {
            let own = triangles.iter().zip(distinct.iter().zip(&is_open));
            own.filter(move |(_, (distinct, open))| **open && **distinct == first).map(|(t, _)| *t)
        };
        let area = |[a, b, c]: Triangle| 0.5 * (b - a).cross(c - a).length();
        let total =
            |own: &mut dyn Iterator<Item = [u32; 3]>| own.map(|t| area(t.map(|v| positions[v as usize]))).sum::<f64>();
        let (once, doubled) = (total(&mut open(true)), total(&mut open(false)));
        let holes = closing::cones(positions, &open(true).collect::<Vec<_>>());
        let holes: Vec<f64> = holes.into_iter().map(|hole| hole.into_iter().map(area).sum()).collect();
        let has_mouth = holes.iter().any(|hole| *hole > MOUTH * once) || holes.iter().sum::<f64>() > once;
        (once > 0.0 && (doubled >= DOUBLED * once || has_mouth)).then_some(is_open)
    }
}

impl fmt::Display for SolidRule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}
