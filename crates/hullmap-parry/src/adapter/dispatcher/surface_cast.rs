//! Linear shape casts of a surface and a body.
//!
//! # Steps
//! 1. Find the first impact of all triangles and pieces.
//! 2. A contact at the start is ignored if the triangle and the piece move apart. The body then
//!    slides on the ground, and may meet other triangles. So cast on each triangle near the path,
//!    by the rule for two convex shapes.

use hullmap::glam::DVec3;
use hullmap::shapes::Rounded;
use hullmap::{Cache, CastSettings, Geometry, Impact, Motion, Pose, Shape};

use super::super::convert::wide;
use super::super::parry::math::Vector;
use super::super::parry::query::{ShapeCastHit, ShapeCastOptions};
use super::cast::Cast;
use super::nearby::{Ball, first_hit};
use super::pair::Nearest;
use super::surface_pair::{Part, SurfacePair};

const BALLS: u32 = 32;

/// The first hit of a pair: arguments and answers as in [`cast`](super::cast::cast).
pub(super) fn cast(
    pair: &SurfacePair<'_>,
    velocity12: Vector,
    options: &ShapeCastOptions,
) -> Option<Option<ShapeCastHit>> {
    let cast = Cast::new(pair.placement, velocity12, options);
    let mut first: Option<(Impact, [u32; 2])> = None;
    for part in pair.parts() {
        let max_t = first.as_ref().map_or(cast.max_t, |(impact, _)| impact.t);
        let found = part_cast(&cast, &part, max_t)?;
        if cast.is_hit(&found) && first.as_ref().is_none_or(|(impact, _)| found.t < impact.t) {
            first = Some((part.in_surface(&found), part.subshapes(found.parts[0])));
        }
    }
    let Some((impact, subshapes)) = first else { return Some(None) };
    if !cast.is_at_start(&impact) {
        return Some(Some(pair.numbered(cast.hit(&impact), subshapes)));
    }
    let (contact, subshapes) = pair.nearest()?;
    if let Some(hit) = cast.start(&contact, impact.t) {
        return Some(Some(pair.numbered(hit, subshapes)));
    }
    let hits = pair.parts().filter_map(|part| beyond_start(pair, &cast, &part));
    Some(hits.min_by(|a, b| a.time_of_impact.total_cmp(&b.time_of_impact)))
}

/// The first impact of a tile and a piece, in the frame of the tile; `None` for invalid numbers.
fn part_cast(cast: &Cast<'_>, Part { tile, piece, b_in_a }: &Part<'_>, max_t: f64) -> Option<Impact> {
    let motion = Motion::new(tile.place().inverse_transform_vector(cast.velocity)).ok()?;
    let settings = CastSettings { max_t, ..CastSettings::default() };
    impact((*tile, piece.shape(), *b_in_a), motion, cast.target, &settings, &mut Cache::with_pairs(1))
}

/// The first impact of `a`, grown by `target`, and `b`; `None` if the target is invalid.
fn impact<A: Geometry + ?Sized>(
    (a, b, b_in_a): (&A, &dyn Shape, Pose),
    motion: Motion,
    target: f64,
    settings: &CastSettings,
    cache: &mut Cache,
) -> Option<Impact> {
    if !(target > 0.0) {
        return Some(hullmap::cast(a, b, b_in_a, motion, settings, cache));
    }
    // B grows instead of A. The points are moved to where a grown A would have them.
    let impact = hullmap::cast(a, &Rounded::new(b, target).ok()?, b_in_a, motion, settings, cache);
    let shift = impact.normal * target;
    Some(Impact { point_a: impact.point_a + shift, point_b: impact.point_b + shift, ..impact })
}

fn beyond_start(pair: &SurfacePair<'_>, cast: &Cast<'_>, part: &Part<'_>) -> Option<ShapeCastHit> {
    let Part { tile, piece, b_in_a } = part;
    let velocity = tile.place().inverse_transform_vector(cast.velocity);
    let (shape, motion) = (piece.shape(), Motion::new(velocity).ok()?);
    let test = |index: usize, triangle: &dyn Shape| {
        let front = tile.front(index);
        let center = b_in_a.transform_point(shape.interior_point());
        let behind = front
            .is_some_and(|front| !(front.dot(velocity) < 0.0) || front.dot(center - triangle.interior_point()) <= 0.0);
        if behind {
            return None;
        }
        let (settings, cache) = (CastSettings { max_t: cast.max_t, ..CastSettings::default() }, &mut Cache::new());
        let impact = impact((triangle, shape, *b_in_a), motion, cast.target, &settings, cache)?;
        if !cast.is_hit(&impact) {
            return None;
        }
        let hit = if cast.is_at_start(&impact) {
            cast.start(&part.nearest_in_surface(Nearest::find(triangle, shape, *b_in_a, cache)), impact.t)?
        } else {
            cast.hit(&part.in_surface(&impact))
        };
        Some((impact.t, pair.numbered(hit, part.subshapes(index as u32))))
    };
    first_hit(tile, way(cast, part, velocity), test).map(|(_, hit)| hit)
}

/// Balls that cover the path of a piece, until it is beyond the tile.
fn way(cast: &Cast<'_>, Part { tile, piece, b_in_a }: &Part<'_>, velocity: DVec3) -> impl Iterator<Item = Ball> {
    let shape = piece.shape();
    let (center, radius) = (b_in_a.transform_point(shape.interior_point()), shape.outer_radius() + cast.target);
    let [low, high] = [tile.bounds().mins, tile.bounds().maxs].map(wide);
    let middle = tile.place().inverse().transform_point(0.5 * (low + high));
    let farthest = middle.distance(center) + 0.5 * low.distance(high) + radius;
    let (speed, max_t) = (velocity.length(), cast.max_t);
    let end = if speed * max_t > farthest { farthest / speed } else { max_t };
    let (count, end) = if speed > 0.0 { (BALLS, end) } else { (1, 0.0) };
    let step = end / f64::from(count);
    (0..count).map(move |i| {
        let start = step * f64::from(i);
        Ball { center: center + velocity * (start + 0.5 * step), radius: radius + 0.5 * speed * step, start }
    })
}
