//! Which parts a mesh gets: symmetric ones if it has a mirror plane, unless others are fewer.
//!
//! # Steps
//! 1. Search the parts of the surface on one side of the mirror plane, and add their images. Merge
//!    parts at the plane with their images where the limit allows. All are symmetric, except merged
//!    parts without a proven symmetric hull.
//! 2. If a part and its image meet at the plane unmerged, or mergers left far fewer parts, cuts
//!    elsewhere may need fewer parts. Then also search the whole surface, unless there is a
//!    deadline. Its parts win if they are fewer. With a maximum number of parts, they win if they
//!    protrude by less than nine tenths, or if they are more and protrude less; so only lower
//!    limits are searched.

use super::{
    finish::{COVERED, finished},
    levels::{Found, Levels},
    parameters::Cover,
    part::SourceVertices,
    partition::{Part, surface::Surface},
};
use crate::{
    deadline::Deadline,
    fit::{solid::Solid, uncovered_triangles},
    hull::Hull,
    progress::Stage,
    symmetry::{self, Mirror},
};
use hullmap_geometry::PointSet;

/// Protrusion of other parts at which they replace symmetric ones, relative to the protrusion of
/// the latter, with a maximum number of parts.
const TIGHTER: f64 = 0.9;

/// Share of the progress after which the parts of the half surface are found.
const HALF: f64 = 0.4;

pub struct SymmetrySearch<'a> {
    pub mesh: &'a PointSet,
    pub solid: &'a Solid,
    pub vertices: &'a SourceVertices<'a>,
    pub parameters: &'a Cover,
    pub max_vertices: usize,
    /// When the parts must be finished.
    pub deadline: Option<Deadline>,
}

struct Parts {
    hulls: Vec<Hull>,
    reached: f64,
    /// Whether parts of the whole surface may be better.
    others_may_win: bool,
}

#[derive(Clone, Copy)]
enum UsefulParts {
    All,
    AtMost(usize),
    Within(f64),
}

impl SymmetrySearch<'_> {
    pub fn best(&self, stage: Stage) -> Option<Vec<Hull>> {
        let mirror = self.parameters.symmetry.then(|| symmetry::mirror_of_mesh(self.mesh, self.solid)).flatten();
        let Some(mirror) = mirror else {
            return Some(self.parts(&self.surface(), UsefulParts::All, stage)?.hulls);
        };
        let symmetric = self.symmetric(mirror, stage.from_to(0.0, HALF));
        let stage = stage.from_to(HALF, 1.0);
        let uses_all = |parts: &Parts| self.parameters.max_parts.is_none_or(|most| parts.hulls.len() >= most as usize);
        let is_settled = |parts: &Parts| !parts.others_may_win && uses_all(parts) || self.deadline.is_some();
        if let Some(parts) = &symmetric
            && is_settled(parts)
        {
            return symmetric.map(|parts| parts.hulls);
        }
        let useful = symmetric.as_ref().map_or(UsefulParts::All, |parts| match self.parameters.max_parts {
            // Fewer are not better.
            Some(_) if uses_all(parts) => UsefulParts::Within(TIGHTER * parts.reached),
            Some(_) => UsefulParts::Within(parts.reached),
            None => UsefulParts::AtMost(parts.hulls.len() - 1),
        });
        let other = self.parts(&self.surface(), useful, stage);
        let is_better = |other: &Parts| match (&symmetric, self.parameters.max_parts) {
            (None, _) => true,
            (Some(symmetric), None) => other.hulls.len() < symmetric.hulls.len(),
            (Some(symmetric), Some(_)) if other.hulls.len() > symmetric.hulls.len() => {
                other.reached < symmetric.reached
            }
            (Some(symmetric), Some(_)) => other.reached < TIGHTER * symmetric.reached,
        };
        other.filter(is_better).or(symmetric).map(|parts| parts.hulls)
    }

    fn surface(&self) -> Surface {
        Surface::new(self.mesh)
    }

    /// Parts of half the surface, with their images, proven to cover the mesh.
    fn symmetric(&self, mirror: Mirror, stage: Stage) -> Option<Parts> {
        let half = self.surface().halved(mirror, self.solid.diagonal());
        let found = self.parts(&half, UsefulParts::All, stage)?;
        let hulls: Vec<&Hull> = found.hulls.iter().collect();
        let uncovered = uncovered_triangles(self.mesh, &hulls, COVERED * self.solid.diagonal(), self.deadline);
        uncovered.is_empty().then_some(found)
    }

    fn parts(&self, surface: &Surface, useful: UsefulParts, stage: Stage) -> Option<Parts> {
        let cover = self.parameters;
        let mut levels = Levels::new(surface, self.solid, cover, self.max_vertices, self.deadline, stage);
        match useful {
            UsefulParts::All => {}
            UsefulParts::AtMost(count) => levels.enough = Some(count),
            UsefulParts::Within(limit) => levels.within = Some(limit),
        }
        let found = levels.parts()?;
        let on_plane = COVERED * self.solid.diagonal();
        let is_at =
            |part: &Part, mirror: &Mirror| part.piece.body.points.iter().any(|p| mirror.plane.height(*p) <= on_plane);
        let meet = surface.mirror.as_ref().is_some_and(|mirror| found.mirrored.iter().any(|part| is_at(part, mirror)));
        let are_merged = surface.mirror.is_some() && cover.max_parts.is_none() && found.is_merged();
        let others_may_win = meet || are_merged;
        let reached = found.reached();
        let is_useful = |found: &Found| levels.enough.is_none_or(|enough| found.count() <= enough);
        let found = Some(found).filter(is_useful)?;
        Some(Parts {
            hulls: finished(self.mesh, self.vertices, &levels, found, cover.max_parts),
            reached,
            others_may_win,
        })
    }
}
