//! Remainder: what the parts of a closed mesh leave of its solid, as convex polytopes.
//!
//! # Steps
//! 1. Divide the box around the mesh into eight, and so on. Drop a cell that is in a part, or
//!    outside the solid.
//! 2. Subtract the parts from a cell that few of their planes cross: what is beyond the first plane
//!    is one piece, what is below it and beyond the second is the next one.
//! 3. Keep the pieces that are in the solid. The parts contain the surface, so no piece crosses it,
//!    and one point of a piece decides.
//!
//! Parts count as grown by [`GROWN`]. So nothing is left only because of rounding, and no piece is
//! so close to the surface that rounding decides.
//!
//! # Complexity
//! At most 8⁶ cells, each with the planes of the parts that touch it.

use glam::DVec3;
use rayon::prelude::*;

use super::{Solid, polytope::Polytope, region::Region};
use crate::hull::Hull;
use hullmap_geometry::planes::HalfSpace;

/// Distance by which the planes of parts are moved outward, relative to the diagonal. The parts
/// contain the surface to within half of that.
pub const GROWN: f64 = 2e-7;

/// Height above a part's plane up to which a piece is dropped, relative to the diagonal.
const LEAST: f64 = 1e-9;

/// Distance from a plane up to which corners count as on it, relative to the diagonal.
const ON_PLANE: f64 = 1e-12;

/// Number of times that the box around the mesh is halved along each axis, at most.
const LEVELS: u32 = 6;

/// Number of levels whose cells are divided in any case, and then handled in parallel.
const FIRST_LEVELS: u32 = 2;

/// Number of planes that cross a cell up to which parts are subtracted from it.
const FEW_PLANES: usize = 24;

/// A convex piece of a solid that is in no part.
#[derive(Clone, Debug)]
pub struct Remnant {
    /// The piece.
    pub body: Polytope,
    /// Indices of the parts that are near it.
    pub near: Vec<u32>,
}

struct Parts<'a> {
    solid: &'a Solid,
    /// `None` for a part without volume.
    regions: Vec<Option<Region>>,
    diagonal: f64,
}

struct Octant {
    low: DVec3,
    high: DVec3,
    level: u32,
    near: Vec<u32>,
}

/// Convex pieces that make up what `parts` leave of `solid`, a closed one whose surface they
/// contain, in one frame. Without pieces, every point of the solid is in a part grown by [`GROWN`].
pub fn remainder(solid: &Solid, parts: &[&Hull]) -> Vec<Remnant> {
    let diagonal = solid.diagonal();
    let region = |part: &&Hull| (part.rank == 3).then(|| Region::grown(part, GROWN * diagonal));
    let parts = Parts { solid, regions: parts.iter().map(region).collect(), diagonal };
    let [low, high] = solid.bounds();
    let mut cells = vec![Octant { low, high, level: 0, near: (0..parts.regions.len() as u32).collect() }];
    for _ in 0..FIRST_LEVELS {
        cells = cells.iter().flat_map(Octant::divided).collect();
    }
    cells.into_par_iter().flat_map_iter(|cell| parts.of_cell(&cell)).collect()
}

impl Octant {
    fn divided(&self) -> impl Iterator<Item = Self> + '_ {
        let middle = 0.5 * (self.low + self.high);
        (0..8).map(move |child| {
            let is_upper = [0, 1, 2].map(|axis| child >> axis & 1 == 1);
            let pick = |yes: DVec3, no: DVec3| {
                DVec3::from_array([0, 1, 2].map(|axis| if is_upper[axis] { yes[axis] } else { no[axis] }))
            };
            let (low, high) = (pick(middle, self.low), pick(self.high, middle));
            Self { low, high, level: self.level + 1, near: self.near.clone() }
        })
    }
}

impl Parts<'_> {
    fn of_cell(&self, cell: &Octant) -> Vec<Remnant> {
        let (low, high) = (cell.low, cell.high);
        let of_part = |part: u32| Some((part, self.regions[part as usize].as_ref()?));
        let touches = |(_, region): &(u32, &Region)| !region.misses_box(low, high);
        let (near, regions): (Vec<u32>, Vec<&Region>) =
            cell.near.iter().filter_map(|part| of_part(*part).filter(touches)).unzip();
        if regions.iter().any(|region| region.holds_box(low, high)) {
            return Vec::new();
        }
        let has_surface = !self.solid.triangles_in(low, high).is_empty();
        if !has_surface && !self.solid.is_inside(0.5 * (low + high)) {
            return Vec::new();
        }
        let crossing: usize = regions.iter().map(|region| region.crossing_box(low, high).count()).sum();
        let is_simple = crossing <= FEW_PLANES && !(near.is_empty() && has_surface);
        if cell.level < LEVELS && !is_simple {
            let own = Octant { near, ..*cell };
            return own.divided().flat_map(|child| self.of_cell(&child)).collect();
        }
        let [least, on_plane] = [LEAST, ON_PLANE].map(|share| share * self.diagonal);
        let mut left = vec![Polytope::of_box(low, high)];
        for region in regions {
            let planes: Vec<HalfSpace> = region.crossing_box(low, high).copied().collect();
            left = left.into_iter().flat_map(|piece| piece.beyond(&planes, least, on_plane)).collect();
        }
        left.retain(|piece| !has_surface || self.solid.is_inside(piece.middle()));
        left.into_iter().map(|body| Remnant { body, near: near.clone() }).collect()
    }
}
