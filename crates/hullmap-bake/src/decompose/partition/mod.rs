//! Convex decomposition as a partition: planes divide a mesh's surface into pieces, until the hull
//! of none protrudes from the solid by more than a limit. The hulls contain the whole surface. Both
//! are proven: `fit/coverage.rs` certifies the cover, and `fit/protrusion.rs` the protrusion.
//!
//! # Steps
//! 1. Clip the mesh's triangles into cells whose hulls stay near the solid.
//! 2. Find points that are too far from the solid: evenly spread ones, and ones beside the surface.
//!    They are *forbidden*: no part may contain them.
//! 3. A piece whose hull contains no forbidden point, and is proven, is a part. Divide any other
//!    piece by the plane that leaves the fewest conflicts and forbidden points within both sides,
//!    and go on with the connected components of the sides.
//! 4. Where that gives a few parts, but more than a lower bound, also peel the piece, and take the
//!    fewer parts.
//! 5. Merge parts as long as the merged hull is proven, and barely overlaps other parts; unless too
//!    many parts to be useful are mutually unmergeable.
//!
//! # Why the bounds hold
//! - The pieces are clipped triangles, which together are the surface. A hull of a piece's corners,
//!   rounded outward, contains the piece.
//! - [`protrusion`](mod@crate::fit::protrusion) bounds each hull's protrusion, measured from the
//!   stored f32 vertices.
//! - Hulls on two sides of a plane overlap only by what simplification adds.
//!
//! # Complexity
//! O(n log n) for the cells of n triangles. The rest depends on the number of cells, which exceeds
//! 3,000 only where larger cells would protrude too far, and on the number of parts.

pub mod body;
pub mod cells;
pub mod clique;
pub mod conflicts;
pub mod context;
pub mod cuts;
pub mod extremes;
pub mod few;
pub mod field;
pub mod halves;
pub mod join;
pub mod peel;
pub mod piece;
pub mod sample;
pub mod shape;
pub mod surface;
pub mod symmetric;
pub mod wrap;

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use cells::Cutting;
use conflicts::Conflicts;
pub use conflicts::Samples;
use context::PartitionSearch;
use field::Field;
pub use join::Merged;
use peel::Along;
use piece::{Atom, Piece, Scale};
pub use shape::{Part, Shell};
use surface::Surface;
use wrap::HullLimits;

use crate::{decompose::patch::Patch, progress::Stage};

/// Share of the limit that a cell's hull may protrude at samples. Smaller cells take longer.
const CELL_SHARE: f64 = 0.08;

/// Share of the limit that no cell's hull may exceed, proven.
pub const HARD_SHARE: f64 = 0.8;

/// Share of the limit that pieces use; the rest is for simplified hulls, and for the proof.
const RESERVE: f64 = 0.94;

/// Number of cells above which cells are cut only where necessary.
const MAX_CELLS: usize = 3000;

const MAX_DEPTH: u32 = 40;

/// Number of parts of a piece up to which it is peeled, too.
const PEELED: usize = 12;

/// Share of a search after which its cells are cut, and after which all pieces are divided.
const STAGES: [f64; 2] = [0.1, 0.95];

/// Limits of a search.
#[derive(Clone, Copy, Debug)]
pub struct PartitionLimits<'a> {
    /// Limits of a part.
    pub bounds: HullLimits<'a>,
    /// Sum of the volumes of parts, less the volume of their union, up to which they are merged;
    /// relative to the latter.
    pub overlap: f64,
    /// Numbers of parts above which the search gives up.
    pub useful: Option<Useful>,
    /// Number of parts down to which they are merged, where they can be.
    pub wanted: usize,
    /// Whether pieces are also peeled, which takes longer and may give fewer parts.
    pub peels: bool,
    /// Whether a part may hold several shells that are apart.
    pub bridges: bool,
}

/// Numbers of parts above which a result is unusable.
#[derive(Clone, Copy, Debug)]
pub struct Useful {
    /// Number of parts.
    pub parts: usize,
    /// Number of parts before mergers.
    pub divided: usize,
}

/// Parts that together contain a surface; of half a surface, with their mirror images.
///
/// Without a deadline, the result depends on the surface and the limits only. In the worst case,
/// each polygon becomes a part, thickened. After the deadline, undivided pieces become parts with
/// infinite bounds. `None` without cells, or with too many parts before mergers.
pub fn search(surface: &Surface, field: &mut Field, limits: &PartitionLimits) -> Option<Merged> {
    let triangles = &surface.triangles;
    field.find_peaks(limits.bounds.limit * HARD_SHARE, limits.bounds.deadline);
    let field = &*field;
    let diagonal = field.solid().diagonal();
    let PartitionLimits { bounds, overlap, useful, wanted, peels, bridges } = *limits;
    let (limit, stage) = (bounds.limit, bounds.stage);
    let hard = HullLimits { limit: limit * HARD_SHARE, max_vertices: usize::MAX, thickness: 0.0, ..bounds };
    let cutting = Cutting { limit: limit * CELL_SHARE, hard, max_cells: MAX_CELLS };
    let cells::Cells { cells, planes } = cells::cells(triangles, field, &cutting)?;
    stage.reach(STAGES[0]);
    let scale = Scale { limit: limit * RESERVE, diagonal };
    let atoms: Vec<Arc<Atom>> = cells.into_iter().map(|patch| Arc::new(Atom::new(patch))).collect();
    let hull = scale.body_of_atoms(&atoms);
    let search = PartitionSearch {
        field,
        scale,
        planes: &planes,
        bounds,
        enough: useful.map_or(usize::MAX, |useful| useful.parts),
        peels,
    };
    let mut forbidden = search.forbidden(triangles, &hull);
    let shells = if bridges { vec![atoms] } else { scale.components(&atoms) };
    let shells: Vec<Piece> = shells.into_iter().map(|atoms| scale.piece(atoms, Vec::new(), &forbidden)).collect();
    let meets_mirror: Vec<bool> = shells
        .iter()
        .map(|shell| bridges || surface.mirror.as_ref().is_some_and(|m| scale.meets(&shell.body, &m.plane)))
        .collect();
    let most = useful.map_or(usize::MAX, |useful| useful.divided);
    let found = each_divided(&search, shells, most, 0, &mut forbidden, stage.from_to(STAGES[0], STAGES[1]))?;
    let of_shell = |(index, parts): (u32, Vec<Part>)| {
        let shell = Shell { index, meets_mirror: meets_mirror[index as usize] };
        parts.into_iter().map(move |part| Part { shell, ..part }).collect::<Vec<_>>()
    };
    let parts: Vec<Part> = (0..).zip(found).flat_map(of_shell).collect();
    let Some(mirror) = &surface.mirror else {
        return Some(join::merge(&search, parts, None, &mut forbidden, overlap, wanted));
    };
    let found = join::merge(&search, parts, Some(mirror), &mut forbidden, overlap, wanted.div_ceil(2));
    Some(halves::merge(&search, found, mirror, &mut forbidden, overlap, wanted))
}

/// Divides parts further, up to `count` in all: those that protrude much from a large surface
/// first, until each is within the limit of `bounds`. A part that would become too many is kept.
pub fn divided_further(
    surface: &Surface,
    field: &mut Field,
    bounds: HullLimits,
    parts: Vec<Part>,
    count: usize,
) -> Vec<Part> {
    field.find_peaks(bounds.limit * HARD_SHARE, bounds.deadline);
    let scale = Scale { limit: bounds.limit * RESERVE, diagonal: bounds.diagonal };
    let planes = cells::FacePlanes::new(&surface.triangles, bounds.diagonal);
    let search = PartitionSearch { field, scale, planes: &planes, bounds, enough: usize::MAX, peels: true };
    let mut room = count.saturating_sub(parts.len());
    let mut parts = parts;
    let excess = |part: &Part| part.bound * part.piece.area();
    parts.sort_by(|a, b| excess(b).total_cmp(&excess(a)));
    let further = |part: Part| {
        if room == 0 || part.bound <= bounds.limit || search.is_over() {
            return vec![part];
        }
        let piece = part.piece.clone();
        match divided(&search, piece, room + 1, 0, &mut Vec::new(), Stage::default()) {
            // When the time ends, the bounds of what is left are not known.
            Some(found) if found.iter().all(|found| found.bound <= part.bound) => {
                room -= found.len() - 1;
                found
            }
            _ => vec![part],
        }
    };
    parts.into_iter().flat_map(further).collect()
}

/// At most `count` parts with unknown bounds, for about the time of the mesh's hull: the surface is
/// halved in the middle of its longest side.
pub fn halved(surface: &Surface, bounds: &HullLimits, count: usize) -> Vec<Part> {
    let scale = Scale { limit: bounds.limit, diagonal: bounds.diagonal };
    let polygons = surface.triangles.iter().map(|triangle| triangle.to_vec()).collect();
    let atoms = Patch::new(polygons).map(|patch| vec![Arc::new(Atom::new(patch))]);
    let piece = |atoms: Vec<Arc<Atom>>| scale.piece(atoms, Vec::new(), &[]);
    let mut pieces: Vec<Piece> = atoms.into_iter().map(piece).collect();
    while !pieces.is_empty() && 2 * pieces.len() <= count {
        let halves = pieces.par_iter().map(|piece| scale.divided(&piece.atoms, &cuts::middle(piece)));
        let halves: Vec<[Vec<Arc<Atom>>; 2]> = halves.collect();
        let halves: Vec<Vec<Arc<Atom>>> = halves.into_iter().flatten().filter(|atoms| !atoms.is_empty()).collect();
        if halves.len() == pieces.len() {
            break;
        }
        pieces = halves.into_par_iter().map(piece).collect();
    }
    let part = |piece: Piece| {
        let tight = wrap::tight(&piece.body.points, bounds.diagonal, bounds.thickness)?;
        let hull = few::quickly_within_vertices(tight, bounds.max_vertices);
        Some(Part { hull, piece, bound: f64::INFINITY, shell: Shell::default() })
    };
    pieces.into_par_iter().filter_map(part).collect()
}

/// The parts of a piece, at most `most`; `None` if there are more. Points that are found to be
/// too far from the solid are added to `known`.
fn divided(
    search: &PartitionSearch,
    piece: Piece,
    most: usize,
    depth: u32,
    known: &mut Vec<DVec3>,
    stage: Stage,
) -> Option<Vec<Part>> {
    let mut piece = piece;
    if search.is_over() {
        return Some(search.shaped(&piece).into_iter().collect());
    }
    if piece.forbidden.is_empty() {
        let mut beyond = search.beyond(&piece);
        if beyond.is_empty() {
            match search.shaped(&piece) {
                Ok(part) => {
                    stage.reach(1.0);
                    return Some(vec![part]);
                }
                Err(point) => beyond.extend(point),
            }
        }
        known.extend_from_slice(&beyond);
        piece.forbidden = beyond;
    }
    if most < 2 {
        return None;
    }
    let components = search.scale.components(&piece.atoms);
    if components.len() > 1 {
        let of = |atoms| search.scale.piece(atoms, piece.planes.clone(), &piece.forbidden);
        let pieces = components.into_iter().map(of).collect();
        return all_divided(search, pieces, most, depth, known, stage);
    }
    // Without forbidden points there are only too many vertices.
    let conflicts = (!piece.forbidden.is_empty()).then(|| Conflicts::new(search, &piece));
    let needed = conflicts.as_ref().map_or(1, Conflicts::needed);
    // Mergers with other pieces do not save any of these.
    if needed > most.min(search.enough) {
        return None;
    }
    let Some(halves) = halves(search, &piece, conflicts.as_ref()).filter(|_| depth < MAX_DEPTH) else {
        if search.is_over() {
            return Some(search.shaped(&piece).into_iter().collect());
        }
        return Some(of_polygons(search, &piece)).filter(|parts| parts.len() <= most);
    };
    let best = all_divided(search, halves.into(), most, depth + 1, known, stage)?;
    let is_peeled = |best: &[Part]| conflicts.is_some() && best.len() <= PEELED && best.len() > needed;
    if search.peels && is_peeled(&best) { Some(peeled(search, &piece, best, needed)) } else { Some(best) }
}

/// The parts of several pieces, at most `most`.
fn all_divided(
    search: &PartitionSearch,
    pieces: Vec<Piece>,
    most: usize,
    depth: u32,
    known: &mut Vec<DVec3>,
    stage: Stage,
) -> Option<Vec<Part>> {
    Some(each_divided(search, pieces, most, depth, known, stage)?.concat())
}

/// The parts of each of several pieces, at most `most` in all.
fn each_divided(
    search: &PartitionSearch,
    pieces: Vec<Piece>,
    most: usize,
    depth: u32,
    known: &mut Vec<DVec3>,
    stage: Stage,
) -> Option<Vec<Vec<Part>>> {
    let area: f64 = pieces.iter().map(Piece::area).sum();
    let (mut found, mut count, mut done, mut left) = (Vec::new(), 0, 0.0, pieces.len());
    for piece in pieces {
        left -= 1;
        let share = piece.area() / area;
        // Each of the others takes one part at least.
        let most = most.checked_sub(count + left).filter(|most| *most > 0)?;
        let parts = divided(search, piece, most, depth, known, stage.from_to(done, done + share))?;
        (count, done) = (count + parts.len(), done + share);
        found.push(parts);
    }
    Some(found)
}

fn halves(search: &PartitionSearch, piece: &Piece, conflicts: Option<&Conflicts>) -> Option<[Piece; 2]> {
    let plane = match conflicts {
        Some(conflicts) => cuts::best_plane(search, piece, &search.scale.neighbours(&piece.atoms), conflicts)?,
        None => cuts::middle(piece),
    };
    let back = plane.opposite();
    let [below, above] = search.scale.divided(&piece.atoms, &plane);
    if below.is_empty() || above.is_empty() {
        return None;
    }
    let of = |atoms, plane| {
        let planes = piece.planes.iter().copied().chain([plane]).collect();
        search.scale.piece(atoms, planes, &piece.forbidden)
    };
    Some([of(below, plane), of(above, back)])
}

/// The parts of a piece by peeling, if they are fewer than `best`. At least `needed` are needed.
fn peeled(search: &PartitionSearch, piece: &Piece, best: Vec<Part>, needed: usize) -> Vec<Part> {
    let mut best = best;
    let directions = cuts::directions(piece).map(Along::One);
    for along in [Along::All].into_iter().chain(directions) {
        let most = best.len() - 1;
        // A piece that is not a part takes two at least.
        if most < needed.max(2) {
            break;
        }
        let Some(pieces) = peel::peel(search, piece, along, most) else { continue };
        let parts: Result<Vec<Part>, _> = pieces.into_par_iter().map(|piece| search.shaped(&piece)).collect();
        best = parts.unwrap_or(best);
    }
    best
}

/// One part for each polygon, none of which protrudes.
fn of_polygons(search: &PartitionSearch, piece: &Piece) -> Vec<Part> {
    let HullLimits { diagonal, max_vertices, .. } = search.bounds;
    let polygons = piece.atoms.iter().flat_map(|atom| &atom.patch.polygons);
    let thin = polygons.flat_map(|polygon| wrap::of_polygon(polygon, diagonal, search.bounds.thickness, max_vertices));
    thin.filter_map(|(polygon, hull)| {
        let bound = wrap::prove(search.field, &hull, &search.bounds, wrap::MEASUREMENTS).unwrap_or(f64::INFINITY);
        let atoms = vec![Arc::new(Atom::new(Patch::new(vec![polygon])?))];
        let piece = search.scale.piece(atoms, piece.planes.clone(), &[]);
        Some(Part { piece, hull, bound, shell: Shell::default() })
    })
    .collect()
}

#[cfg(test)]
mod tests;
