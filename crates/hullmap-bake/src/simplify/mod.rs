//! Simplified hulls: a hull with fewer vertices that contains a given hull, within a distance.
//!
//! # Steps
//! 1. Wrap the hull at many distances. Take the nearest wrap within the vertex limit, or the wrap
//!    at the allowed distance.
//! 2. Collapse a wrap with eight times as many vertices, or the hull itself. Keep the better of the
//!    two results. With 24 or more vertices, the polytope of [`outer`](mod@crate::outer) is a third
//!    candidate. Wraps are nearer on round shapes, collapses mostly on shapes with large faces.
//! 3. Push each vertex outward by more than rounding to f32 can move it back. Exact predicates
//!    certify that the result contains the hull.
//! 4. Measure the rounded vertices, where the convex distance from the hull has its maximum.

use glam::DVec3;

use crate::{
    error::BakeError,
    hull::{self, Hull},
};

pub mod collapse;
pub mod nearest;
pub mod polygon;
mod rounding;
pub mod surface;
pub mod wrap;

pub use crate::limit::{Limit, MIN_VERTICES};
use collapse::Collapse;
use hullmap_geometry::planes::HalfSpace;
use hullmap_geometry::quadratic_program::nearest_to_origin;
use nearest::Nearest;
pub use rounding::Simplified;
use rounding::{MAX_TRIES, PUSH, ROUNDING};
use surface::Surface;
use wrap::{Wrapped, wrap};

/// Ratio of the vertices at which a collapse starts and ends. Sixteen gave no better results.
const FINER: usize = 8;

/// Maximum distance of a wrap, in diameters. At this distance, four vertices suffice.
const MAX_DISTANCE: f64 = 128.0;

const HALVINGS: usize = 28;

/// Number of smaller distances tried after the bisection, in steps of 1 %. The vertex count of a
/// wrap is not monotonic in its distance.
const NEARER: usize = 24;

/// A hull with fewer vertices that contains `hull`, within the limit. `None` if `hull` already
/// satisfies it, or if a distance limit allows none. Points and segments are never simplified.
///
/// # Errors
/// [`BakeError::TooFewVertices`] below [`MIN_VERTICES`]; [`BakeError::InvalidDistance`] for a
/// negative distance or NaN; [`BakeError::NotSimplified`] if rounding to f32 defeats all candidates
/// within a vertex limit.
///
/// # Complexity
/// About a hundred nearest-point searches per vertex of the result. Each step of the final
/// measurement searches all vertices of the hull.
pub fn simplify(hull: &Hull, limit: Limit) -> Result<Option<Simplified>, BakeError> {
    match limit {
        Limit::Vertices(max_vertices) if max_vertices < MIN_VERTICES => {
            return Err(BakeError::TooFewVertices { requested: max_vertices });
        }
        // Written so that NaN fails.
        Limit::Distance(distance) if !(distance >= 0.0) => {
            return Err(BakeError::InvalidDistance { requested: distance });
        }
        Limit::Vertices(max_vertices) if hull.vertices.len() <= max_vertices => return Ok(None),
        _ => {}
    }
    let found = match hull.rank {
        3 => solid(hull, limit),
        2 => polygon::simplify(hull, limit),
        _ => return Ok(None),
    };
    match (found, limit) {
        (None, Limit::Vertices(max_vertices)) => Err(BakeError::NotSimplified { requested: max_vertices }),
        (found, _) => Ok(found),
    }
}

fn solid(hull: &Hull, limit: Limit) -> Option<Simplified> {
    let nearest = Nearest::new(hull);
    match limit {
        Limit::Vertices(max_vertices) => {
            let written = |surface: Surface| write(&surface, hull, &nearest);
            let wrapped = || {
                let coarse = (max_vertices >= 24).then(|| crate::outer::outer(hull)).filter(|outer| !outer.is_empty());
                let coarse = coarse.and_then(|outer| measured(outer, hull, &nearest));
                (fewest_by_wrap(&nearest, hull, max_vertices).and_then(written), coarse)
            };
            let collapsed = || collapsed(&nearest, hull, max_vertices, f64::INFINITY).and_then(written);
            let (collapsed, (wrapped, coarse)) = rayon::join(collapsed, wrapped);
            let fits = |found: &Simplified| found.hull.vertices.len() <= max_vertices;
            // The nearest hull; of equally near ones, the first.
            let candidates = [wrapped, collapsed, coarse].into_iter().flatten().filter(fits);
            candidates.reduce(|a, b| if b.outer_error < a.outer_error { b } else { a })
        }
        Limit::Distance(distance) => {
            // Room for the outward push.
            let scale = hull.positions().iter().fold(0.0, |scale: f64, p| scale.max(p.abs().max_element()));
            let mut room = 2.0 * PUSH * scale;
            for _ in 0..MAX_TRIES {
                let within = distance - room;
                if !(within > 0.0) {
                    return None;
                }
                let max_vertices = hull.vertices.len() - 1;
                let wrapped = wrap(&nearest, hull.diameter, within, max_vertices).map(|wrapped| wrapped.surface);
                let start = wrapped.as_ref().map_or(max_vertices, |surface| surface.vertex_count());
                let written = |surface: Surface| write(&surface, hull, &nearest);
                let (collapsed, wrapped) = rayon::join(
                    || collapsed(&nearest, hull, start, within).and_then(written),
                    || wrapped.and_then(written),
                );
                let fits =
                    |found: &Simplified| found.outer_error <= distance && found.hull.vertices.len() <= max_vertices;
                let fewer =
                    |a: Simplified, b: Simplified| if b.hull.vertices.len() < a.hull.vertices.len() { b } else { a };
                if let Some(found) = [wrapped, collapsed].into_iter().flatten().filter(fits).reduce(fewer) {
                    return Some(found);
                }
                room *= 2.0;
            }
            None
        }
    }
}

fn fewest_by_wrap(nearest: &Nearest, hull: &Hull, max_vertices: usize) -> Option<Surface> {
    let try_at = |distance: f64| wrap(nearest, hull.diameter, distance, max_vertices).map(|wrapped| wrapped.surface);
    let (mut low, mut high) = (0.0, MAX_DISTANCE * hull.diameter);
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

/// A larger wrap, or the hull, collapsed to `max_vertices` vertices, or as far as `reach` allows.
fn collapsed(nearest: &Nearest, hull: &Hull, max_vertices: usize, reach: f64) -> Option<Surface> {
    let start = if hull.vertices.len() <= FINER * max_vertices {
        Wrapped { surface: Surface::new(hull), feet: (0..hull.vertices.len() as u32).collect() }
    } else {
        let (mut low, mut high) = (0.0, MAX_DISTANCE * hull.diameter);
        let mut found = None;
        for _ in 0..HALVINGS {
            if high - low <= 0.1 * high {
                break;
            }
            let distance = (low + high) * 0.5;
            match wrap(nearest, hull.diameter, distance, FINER * max_vertices) {
                Some(wrapped) => (found, high) = (Some(wrapped), distance),
                None => low = distance,
            }
        }
        found?
    };
    let mut collapse = Collapse::new(nearest, start, hull.diameter);
    let stop_at = if reach.is_finite() { MIN_VERTICES } else { max_vertices };
    while collapse.surface().vertex_count() > stop_at && collapse.step(reach.min(MAX_DISTANCE * hull.diameter)) {}
    collapse.settle_all();
    Some(collapse.into_surface())
}

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
        let finite = rounded.iter().flatten().all(|c| c.is_finite());
        (finite && crate::outer::holds(&rounded, &positions)).then(|| measured(rounded, hull, nearest)).flatten()
    })
}

fn measured(points: Vec<[f32; 3]>, hull: &Hull, nearest: &Nearest) -> Option<Simplified> {
    let mut outer = hull::of_positions(points)?;
    outer.containment_error = hull::certify::certify(&outer, &hull.positions()).ok()?;
    let distance = |p: DVec3| nearest.certain(p).point.distance(p);
    let farthest = outer.positions().into_iter().map(distance).fold(0.0, f64::max);
    Some(Simplified { outer_error: farthest + ROUNDING * hull.diameter, hull: outer })
}

#[cfg(test)]
mod tests;
