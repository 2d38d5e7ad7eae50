//! Convex decomposition as a partition: planes divide a mesh's surface into pieces, until the hull
//! of none protrudes from the solid by more than a limit. The hulls contain the whole surface. Both
//! are proven: `fit/coverage.rs` certifies the cover, and `fit/protrusion.rs` the protrusion.
//!
//! # Steps
//! 1. Group neighbouring triangles as atoms, which only planes divide.
//! 2. Find points that are too far from the solid, or stand out of a large flat face: evenly spread
//!    ones, and ones beside the surface. They are *forbidden*: no part may contain them.
//! 3. Start with each closed shell, and with the rest. A piece whose hull contains no forbidden
//!    point, and is proven, is a part. Divide any other piece by the plane that leaves the fewest
//!    conflicts and forbidden points within both sides, and go on with the connected components of
//!    the sides. Atoms that see each other through the solid are connected, and the points inside
//!    at which planes meet belong to a piece, so that parts contain the solid, too.
//! 4. Where that gives a few parts, also peel the piece, and take the fewer parts.
//! 5. Merge parts as long as the merged hull is proven, and barely overlaps other parts.
//! 6. Cut off features of a shell, such as teeth. If that leaves a part, merge these parts, too,
//!    and take the fewer.
//!
//! About a mirror, one half is searched; about two mirrors, a quarter. Parts are then merged across
//! the mirrors, into parts that both mirror.
//!
//! # Why the bounds hold
//! - The pieces are clipped triangles, which together are the surface. A hull of a piece's corners,
//!   rounded outward, contains the piece.
//! - [`protrusion`](mod@crate::fit::protrusion) bounds each hull's protrusion, measured from the
//!   stored f32 vertices.
//! - Hulls on two sides of a plane overlap only by what simplification adds.
//!
//! # Complexity
//! O(n log n) for n triangles and a plane; the number of planes that are tried grows with the
//! number of parts.

pub mod atom;
pub mod body;
pub mod conflicts;
pub mod context;
pub mod cuts;
pub mod extremes;
pub mod features;
pub mod few;
pub mod field;
pub mod flats;
pub mod halves;
pub mod join;
pub mod links;
pub mod peel;
pub mod piece;
pub mod planes;
pub mod sample;
pub mod shape;
pub mod surface;
pub mod symmetric;
pub mod wrap;

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use atom::Atom;
use conflicts::Conflicts;
use context::PartitionSearch;
use field::Field;
pub use halves::Halves;
use peel::Along;
use piece::{Cloud, Piece, Scale};
use planes::FacePlanes;
pub use shape::{Component, Part};
use surface::Surface;
use wrap::HullLimits;

use crate::{
    decompose::patch::{Patch, patches},
    progress::Stage,
    symmetry::Mirror,
};
use hullmap_geometry::planes::HalfSpace;

/// Number of atoms along the diagonal. More atoms take longer; fewer are cut more often.
const ATOMS: f64 = 80.0;

/// Share of the limit above which the local maxima of the distance are found.
const PEAKS: f64 = 0.8;

/// Share of the limit that pieces use; the rest is for simplified hulls, and for the proof.
const RESERVE: f64 = 0.94;

/// Number of cuts that lead to a piece, after which pieces are only halved, and after which they
/// end as polygons.
const DEPTHS: [u32; 2] = [24, 60];

/// Number of parts of a piece up to which it is peeled, too.
const PEELED: usize = 12;

/// Share of a search after which all pieces are divided.
const DIVIDED: f64 = 0.9;

/// Limits of a search.
#[derive(Clone, Copy, Debug)]
pub struct PartitionLimits<'a> {
    /// Limits of a part.
    pub bounds: HullLimits<'a>,
    /// Number of parts before mergers above which the search gives up.
    pub most: usize,
    /// Number of parts down to which they are merged, where they can be.
    pub wanted: usize,
    /// Whether a part may hold several shells that are apart.
    pub bridges: bool,
}

/// Parts that together contain a surface; of half a surface, with their mirror images.
///
/// Without a deadline, the result depends on the surface and the limits only. In the worst case,
/// each polygon becomes a part, thickened. After the deadline, undivided pieces become parts with
/// infinite bounds. `None` with too many parts before mergers.
pub fn search(surface: &Surface, field: &mut Field, limits: &PartitionLimits) -> Option<Halves> {
    let PartitionLimits { bounds, most, wanted, bridges } = *limits;
    let (limit, stage) = (bounds.limit, bounds.stage);
    field.find_peaks(limit * PEAKS, bounds.deadline);
    field.keep_flats(limit, bounds.thickness);
    let field = &*field;
    let diagonal = field.solid().diagonal();
    let scale = Scale { limit: limit * RESERVE, diagonal, field };
    let Surface { triangles, mirrors } = surface;
    let planes = FacePlanes::new(triangles);
    let search = PartitionSearch { field, scale, planes: &planes, bounds };
    let atoms = patches(triangles, diagonal / ATOMS);
    let atoms: Vec<Arc<Atom>> = atoms.into_iter().map(|patch| Arc::new(Atom::new(patch))).collect();
    let mut forbidden = search.forbidden(triangles, &scale.body_of(&Cloud::of_atoms(&atoms)));
    let sides: Vec<HalfSpace> = mirrors.iter().map(|mirror| mirror.plane.opposite()).collect();
    let shells = if bridges {
        vec![(0, scale.piece(atoms, Vec::new(), sides, &forbidden))]
    } else {
        scale.shells(atoms, &sides, &forbidden)
    };
    let meets = |mirror: &Mirror| {
        let at_mirror = shells.iter().filter(|(_, piece)| bridges || scale.meets(&piece.body, &mirror.plane));
        at_mirror.map(|(index, _)| *index).collect::<Vec<u32>>()
    };
    let meeting: Vec<Vec<u32>> = mirrors.iter().map(meets).collect();
    let (indices, shells): (Vec<u32>, Vec<Piece>) = shells.into_iter().unzip();
    let found = each_divided(&search, shells.clone(), most, 0, &mut forbidden, stage.from_to(0.0, DIVIDED))?;
    let pairs = features::pairs(&planes.edges, mirrors);
    let featured = |(shell, parts): (&Piece, &Vec<Part>)| features::parts(&search, shell, &pairs, parts.len());
    let featured: Vec<Option<Vec<Part>>> = shells.iter().zip(&found).map(featured).collect();
    let mut merged = |parts: Vec<Vec<Part>>| {
        let of_shell = |(index, parts): (&u32, Vec<Part>)| {
            let component = Component { index: *index, image: 0 };
            parts.into_iter().map(move |part| Part { component, ..part })
        };
        let parts = indices.iter().zip(parts).flat_map(of_shell).collect();
        halves::merge_all(&search, parts, mirrors, &meeting, &mut forbidden, wanted)
    };
    if featured.iter().all(Option::is_none) {
        return merged(found);
    }
    let plain = merged(found.clone());
    let featured = featured.into_iter().zip(found).map(|(featured, plain)| featured.unwrap_or(plain)).collect();
    [merged(featured), plain].into_iter().flatten().min_by_key(Halves::count)
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
    field.find_peaks(bounds.limit * PEAKS, bounds.deadline);
    field.keep_flats(bounds.limit, bounds.thickness);
    let scale = Scale { limit: bounds.limit * RESERVE, diagonal: bounds.diagonal, field: &*field };
    let planes = FacePlanes::new(&surface.triangles);
    let search = PartitionSearch { field, scale, planes: &planes, bounds };
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
pub fn halved(surface: &Surface, field: &Field, bounds: &HullLimits, count: usize) -> Vec<Part> {
    let scale = Scale { limit: bounds.limit, diagonal: bounds.diagonal, field };
    let polygons = surface.triangles.iter().map(|triangle| triangle.to_vec()).collect();
    let atoms = Patch::new(polygons).map(|patch| vec![Arc::new(Atom::new(patch))]);
    let piece = |atoms: Vec<Arc<Atom>>| scale.piece(atoms, Vec::new(), Vec::new(), &[]);
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
        Some(Part { hull, piece, bound: f64::INFINITY, component: Component::default() })
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
    if search.scale.is_small(&piece.body) {
        piece.forbidden.retain(|p| search.field.is_far(*p, search.scale.limit));
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
    if let Some(piece) = search.without_far_corners(&piece) {
        return divided(search, piece, most, depth, known, stage);
    }
    if most < 2 {
        return None;
    }
    let mut pieces = search.scale.parted(piece);
    let [piece] = pieces.as_mut_slice() else {
        return all_divided(search, pieces, most, depth, known, stage);
    };
    // Without forbidden points there are only too many vertices.
    let conflicts = (!piece.forbidden.is_empty() && depth < DEPTHS[0]).then(|| Conflicts::new(search, piece));
    let Some(halves) = halves(search, piece, conflicts.as_ref()).filter(|_| depth < DEPTHS[1]) else {
        if search.is_over() {
            return Some(search.shaped(piece).into_iter().collect());
        }
        return Some(of_polygons(search, piece)).filter(|parts| parts.len() <= most);
    };
    // A piece that only has too many vertices may never have few enough.
    let step = if conflicts.is_some() { 1 } else { DEPTHS[1] / 4 };
    let best = all_divided(search, halves.into(), most, depth + step, known, stage)?;
    let is_peeled = conflicts.is_some() && (3..=PEELED).contains(&best.len());
    if is_peeled { Some(peeled(search, piece, best)) } else { Some(best) }
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

/// The sides of the best plane. Where there are only too many vertices, of the plane that leaves
/// the fewest on either side. `None` if nothing is cut.
fn halves(search: &PartitionSearch, piece: &Piece, conflicts: Option<&Conflicts>) -> Option<[Piece; 2]> {
    let links = || search.scale.links(&piece.atoms);
    let best = conflicts.and_then(|conflicts| cuts::best_plane(search, piece, &links(), conflicts));
    let best = best.and_then(|plane| search.scale.cut(piece, &plane));
    best.or_else(|| {
        let sides = cuts::through_middle(piece).filter_map(|plane| search.scale.cut(piece, &plane));
        sides.min_by_key(|sides| sides.iter().map(|side| side.body.points.len()).max())
    })
}

/// The parts of a piece by peeling, if they are fewer than `best`.
fn peeled(search: &PartitionSearch, piece: &Piece, best: Vec<Part>) -> Vec<Part> {
    let mut best = best;
    let directions = cuts::directions(piece).map(Along::One);
    for along in [Along::All].into_iter().chain(directions) {
        let most = best.len() - 1;
        // A piece that is not a part takes two at least.
        if most < 2 {
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
        let piece = search.scale.piece(atoms, Vec::new(), piece.planes.clone(), &[]);
        Some(Part { piece, hull, bound, component: Component::default() })
    })
    .collect()
}

#[cfg(test)]
mod tests;
