//! A convex hull → one of fewer vertices that holds it and leaves it by no more than a stated distance.
//!
//! | file | concept |
//! |---|---|
//! | [`wrap`](mod@wrap) | few vertices at one distance from the hull |
//! | [`collapse`] | fewer vertices, edge by edge |
//! | [`surface`] | the triangles that both work on |
//! | [`nearest`], [`half_spaces`] | nearest points of a hull, of half-spaces |
//! | [`polygon`] | the same of flat hulls |
//!
//! # Steps
//! 1. Wraps of many distances: the nearest one of at most so many vertices, or that of the allowed distance.
//! 2. A wrap of eight times as many vertices (or the hull itself), collapsed. The better of the two is kept, with the coarse
//!    polytope of [`outer`](mod@crate::outer) as a third. On round shapes wraps are nearer, on those with facets collapses mostly.
//! 3. Each vertex is pushed outward by more than its rounding to f32 takes away; exact predicates say whether all of the hull is
//!    inside.
//! 4. The distance is measured anew, at the vertices as they are written, by a look at all vertices of the hull. Distance to a
//!    convex set is a convex function: it is greatest at a vertex.

use glam::DVec3;

use crate::{
    BakeError, NO_SOURCE_VERTEX, PointSet,
    hull::{self, Hull},
};

pub mod collapse;
pub mod half_spaces;
pub mod nearest;
pub mod polygon;
pub mod surface;
pub mod wrap;

use collapse::Collapse;
use half_spaces::{HalfSpace, nearest_to_origin};
use nearest::Nearest;
use surface::Surface;
use wrap::{Wrapped, wrap};

/// How far a hull is to be simplified.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// At most so many vertices, 4 or more, as near to the hull as is found.
    Vertices(usize),
    /// As few vertices as are found, none farther from the hull than this, in the points' units.
    Distance(f64),
}

/// A simplified hull.
#[derive(Clone, Debug)]
pub struct Simplified {
    /// The hull. No vertex of it is a source vertex. Its containment error is 0 unless it is flat.
    pub hull: Hull,
    /// How far it reaches beyond the hull that it was made of at most, in the points' units.
    pub outer_error: f64,
}

/// Fewest vertices that may be asked for: those of a tetrahedron.
pub const FEWEST: usize = 4;

/// How many times as many vertices a collapse starts with as it shall end with. Sixteen times brought no more.
const FINER: usize = 8;

/// Greatest distance of a wrap that is tried, in diameters: at this one four vertices do.
const FARTHEST: f64 = 128.0;

/// Halvings of the range of distances: to a thousandth of the distance found.
const HALVINGS: usize = 28;

/// Distances below the one found that are tried besides, each a hundredth less: how many vertices a wrap takes does not fall evenly.
const NEARER: usize = 24;

/// By how much of the greatest coordinate vertices are pushed outward before they are rounded to f32: rounding moves each coordinate by
/// up to 6e-8 of it, and a point by up to 1.04e-7.
const PUSH: f64 = 1.1e-7;

/// How often that is doubled before the hull is left as it is.
const MAX_TRIES: i32 = 8;

/// By how much a distance may be off: rounding, over the diameter.
const ROUNDING: f64 = 1e-14;

/// A hull of fewer vertices that holds `hull`, within the limit; `None` where `hull` is within it already, and where nothing of fewer
/// vertices is found (with a limit on the distance).
///
/// A point or a segment is left as it is. The result depends on nothing but the arguments.
///
/// # Errors
/// A limit of fewer than [`FEWEST`] vertices, a distance that is negative or not a number, or a hull of so few vertices that rounding
/// to f32 defeats all that is tried.
///
/// # Complexity
/// Some hundred nearest-point searches for each vertex of the result; one look at all vertices for each step of its last
/// measurement.
pub fn simplify(hull: &Hull, limit: Limit) -> Result<Option<Simplified>, BakeError> {
    match limit {
        Limit::Vertices(most) if most < FEWEST => return Err(BakeError::TooFewVertices { asked: most }),
        // NaN, too.
        Limit::Distance(distance) if !(distance >= 0.0) => return Err(BakeError::NoDistance { asked: distance }),
        Limit::Vertices(most) if hull.vertices.len() <= most => return Ok(None),
        _ => {}
    }
    let found = match hull.rank {
        3 => solid(hull, limit),
        2 => polygon::simplify(hull, limit),
        _ => return Ok(None),
    };
    match (found, limit) {
        (None, Limit::Vertices(most)) => Err(BakeError::NotSimplified { asked: most }),
        (found, _) => Ok(found),
    }
}

fn solid(hull: &Hull, limit: Limit) -> Option<Simplified> {
    let nearest = Nearest::new(hull);
    match limit {
        Limit::Vertices(most) => {
            let candidates = [fewest_by_wrap(&nearest, hull, most), collapsed(&nearest, hull, most, f64::INFINITY)];
            let written = candidates.into_iter().flatten().filter_map(|surface| write(&surface, hull, &nearest));
            let coarse = (most >= 24).then(|| crate::outer::outer(hull)).filter(|outer| !outer.is_empty());
            let coarse = coarse.and_then(|outer| measured(outer, hull, &nearest));
            let fits = |found: &Simplified| found.hull.vertices.len() <= most;
            // The first of the nearest.
            written.chain(coarse).filter(fits).reduce(|a, b| if b.outer_error < a.outer_error { b } else { a })
        }
        Limit::Distance(distance) => {
            // Room for the push.
            let scale = hull.positions().iter().fold(0.0, |scale: f64, p| scale.max(p.abs().max_element()));
            let mut room = 2.0 * PUSH * scale;
            for _ in 0..MAX_TRIES {
                let within = distance - room;
                if !(within > 0.0) {
                    return None;
                }
                let most = hull.vertices.len() - 1;
                let wrapped = wrap(&nearest, hull.diameter, within, most).map(|wrapped| wrapped.surface);
                let start = wrapped.as_ref().map_or(most, |surface| surface.vertex_count());
                let candidates = [wrapped, collapsed(&nearest, hull, start, within)];
                let written = candidates.into_iter().flatten().filter_map(|surface| write(&surface, hull, &nearest));
                let fits = |found: &Simplified| found.outer_error <= distance && found.hull.vertices.len() <= most;
                let fewer =
                    |a: Simplified, b: Simplified| if b.hull.vertices.len() < a.hull.vertices.len() { b } else { a };
                if let Some(found) = written.filter(fits).reduce(fewer) {
                    return Some(found);
                }
                room *= 2.0;
            }
            None
        }
    }
}

/// The wrap of at most `most` vertices that is nearest, of those tried.
fn fewest_by_wrap(nearest: &Nearest, hull: &Hull, most: usize) -> Option<Surface> {
    let try_at = |distance: f64| wrap(nearest, hull.diameter, distance, most).map(|wrapped| wrapped.surface);
    let (mut low, mut high) = (0.0, FARTHEST * hull.diameter);
    let mut best = None;
    for halving in 0..HALVINGS {
        let distance = if halving == 0 { high } else { (low + high) * 0.5 };
        match try_at(distance) {
            Some(surface) => (best, high) = (Some(surface), distance),
            None => low = distance,
        }
        if high - low < 1e-3 * high {
            break;
        }
    }
    let mut nearer = (1..=NEARER).rev().map(|less| high * (1.0 - 0.01 * less as f64));
    nearer.find_map(try_at).or(best)
}

/// A wrap of some more vertices, or the hull, collapsed to at most `most` vertices, or as far as `reach` allows.
fn collapsed(nearest: &Nearest, hull: &Hull, most: usize, reach: f64) -> Option<Surface> {
    let start = if hull.vertices.len() <= FINER * most {
        Wrapped { surface: Surface::new(hull), feet: (0..hull.vertices.len() as u32).collect() }
    } else {
        let (mut low, mut high) = (0.0, FARTHEST * hull.diameter);
        let mut found = None;
        for _ in 0..HALVINGS {
            if high - low <= 0.1 * high {
                break;
            }
            let distance = (low + high) * 0.5;
            match wrap(nearest, hull.diameter, distance, FINER * most) {
                Some(wrapped) => (found, high) = (Some(wrapped), distance),
                None => low = distance,
            }
        }
        found?
    };
    let mut collapse = Collapse::new(nearest, start, hull.diameter);
    let fewest = if reach.is_finite() { FEWEST } else { most };
    while collapse.surface().vertex_count() > fewest && collapse.step(reach.min(FARTHEST * hull.diameter)) {}
    collapse.settle_all();
    Some(collapse.into_surface())
}

/// The surface's vertices rounded to f32, as a hull that holds `hull`.
fn write(surface: &Surface, hull: &Hull, nearest: &Nearest) -> Option<Simplified> {
    let scale = surface.vertices().fold(0.0, |scale: f64, (_, p)| scale.max(p.abs().max_element()));
    let positions = hull.positions();
    (0..MAX_TRIES).find_map(|tried| {
        let push = PUSH * scale * 2_f64.powi(tried);
        let pushed = |(vertex, p): (u32, DVec3)| {
            let normal = |[b, c]: [u32; 2]| HalfSpace { normal: surface.normal([vertex, b, c]), offset: 1.0 };
            let outward: Vec<HalfSpace> =
                surface.around(vertex).map(normal).filter(|h| h.normal != DVec3::ZERO).collect();
            let step = nearest_to_origin(&outward, f64::INFINITY)?;
            Some((p + step * push).to_array().map(|c| c as f32 + 0.0))
        };
        let rounded: Vec<[f32; 3]> = surface.vertices().map(pushed).collect::<Option<_>>()?;
        if std::env::var("DBG").is_ok() {
            eprintln!("push {push} holds {}", crate::outer::holds(&rounded, &positions));
        }
        let finite = rounded.iter().flatten().all(|c| c.is_finite());
        (finite && crate::outer::holds(&rounded, &positions)).then(|| measured(rounded, hull, nearest)).flatten()
    })
}

/// The hull of `points`, which holds `hull`, with both errors.
fn measured(points: Vec<[f32; 3]>, hull: &Hull, nearest: &Nearest) -> Option<Simplified> {
    let mut outer = of_points(points)?;
    outer.containment_error = hull::certify::certify(&outer, &hull.positions()).ok()?;
    let distance = |p: DVec3| nearest.certain(p).point.distance(p);
    let farthest = outer.positions().into_iter().map(distance).fold(0.0, f64::max);
    Some(Simplified { outer_error: farthest + ROUNDING * hull.diameter, hull: outer })
}

/// The hull of points that are none of the source's.
fn of_points(positions: Vec<[f32; 3]>) -> Option<Hull> {
    let source_vertices = vec![NO_SOURCE_VERTEX; positions.len()];
    hull::build(&PointSet { positions, source_vertices, ..PointSet::default() }).ok()
}

#[cfg(test)]
mod tests;
