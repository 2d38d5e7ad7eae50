//! Tight hulls of parts: of few vertices, around the surface that a part has, and hardly farther
//! out than its proven hull.
//!
//! # Steps
//! 1. Take the hull of the surface. Simplify it by a small share of the limit.
//! 2. If it has too many vertices, simplify it to the allowed number. Where it then protrudes too
//!    far, cut it by planes of the hull of the surface.
//! 3. If that fails, take the proven hull, cut by the planes between it and other parts.
//!
//! # Why the bound holds
//! The distance from the solid changes by at most the distance between two points. So a hull within
//! a distance of the proven hull protrudes by at most that much more.

use glam::DVec3;

use super::cover::{
    CoverPart,
    body::Body,
    field::Field,
    wrap::{self, Bounds},
};
use crate::{
    hull::Hull,
    simplify::{self, Limit, nearest::Nearest},
};

/// Distance by which a simplified hull may exceed the tight one, relative to the limit. Proven
/// hulls leave it free.
pub const LOOSE: f64 = 0.02;

/// Numbers of vertices to which a hull is simplified before it is cut, relative to the maximum.
/// Each cut adds about two.
const BEFORE_CUTS: [f64; 3] = [0.75, 0.5, 0.3];

/// A hull of a part's surface with at most the allowed number of vertices, of which no point is
/// farther from the solid than the limit. It is the part's proven hull if no tighter one is found.
pub fn tightened(field: &Field, part: &CoverPart, bounds: &Bounds) -> Hull {
    let points: Vec<DVec3> = part.patches.iter().flat_map(|patch| patch.points.iter().copied()).collect();
    let (points, proven) = (points.as_slice(), &part.hull);
    let Some(tight) = wrap::tight(points, bounds.diagonal, bounds.thickness()) else { return proven.clone() };
    let is_few = |hull: &Hull| hull.vertices.len() <= bounds.max_vertices;
    let around = Nearest::new(proven);
    let is_proven = |hull: &Hull| {
        let room = bounds.limit - part.bound;
        farthest(hull, &around) <= room || wrap::prove(field, hull, bounds, wrap::MEASUREMENTS).is_ok()
    };
    let simplified = |limit| simplify::simplify(&tight, limit).ok().flatten().map(|found| found.hull);
    let loose = simplified(Limit::Distance(LOOSE * bounds.limit)).filter(is_few).filter(is_proven);
    if let Some(found) = loose {
        return found;
    }
    if is_few(&tight) && is_proven(&tight) {
        return tight;
    }
    let few = simplified(Limit::Vertices(bounds.max_vertices)).filter(is_few).filter(is_proven);
    if let Some(found) = few {
        return found;
    }
    let body = Body::new(points, 0.0);
    for share in BEFORE_CUTS {
        let vertices = ((share * bounds.max_vertices as f64) as usize).max(simplify::MIN_VERTICES);
        let start = simplified(Limit::Vertices(vertices));
        let found = start.and_then(|start| wrap::wrap(field, &body, bounds, Some(&start)).ok());
        if let Some((found, _)) = found {
            return found;
        }
    }
    let region = region(part, points, bounds).filter(is_few).filter(is_proven);
    region.unwrap_or_else(|| proven.clone())
}

/// The greatest distance of a vertex from another hull.
fn farthest(hull: &Hull, from: &Nearest) -> f64 {
    hull.positions().iter().map(|p| from.nearest_from(*p, 0).point.distance(*p)).fold(0.0, f64::max)
}

/// The proven hull, cut by the planes between it and other parts.
fn region(part: &CoverPart, points: &[DVec3], bounds: &Bounds) -> Option<Hull> {
    let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let vertices = wrap::polytope(&part.planes, middle, 4.0 * bounds.diagonal, 1e-7 * bounds.diagonal)?;
    wrap::tight(&vertices, bounds.diagonal, 0.0)
}
