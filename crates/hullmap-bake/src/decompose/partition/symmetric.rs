//! Hulls that are their own mirror images, and hulls that also contain what rounding moved.
//!
//! Simplification and cuts may leave an asymmetric hull around a symmetric piece. Its half on one
//! side of the mirror and the image of that half have a symmetric hull that contains the piece.

use glam::DVec3;

use super::{
    field::Field,
    piece::ON_PLANE,
    wrap::{self, HullLimits},
};
use crate::{
    hull::{self, Hull},
    mass,
    symmetry::Mirror,
};
use hullmap_geometry::planes::HalfSpace;

/// Maximum growth of a hull for rounding, as a share of its size.
const MAX_GROWTH: f64 = 1e-3;

/// A symmetric hull around the piece that `hull` contains, which is its own mirror image, proven to
/// be within the limits; `None` if there is none. The smaller one of both sides' is taken.
pub fn symmetric(field: &Field, hull: &Hull, mirror: &Mirror, bounds: &HullLimits) -> Option<Hull> {
    let of_side = |sign: f64| {
        let half = half(hull, mirror, sign, bounds.diagonal);
        let both: Vec<DVec3> = half.iter().copied().chain(half.iter().map(|p| mirror.image(*p))).collect();
        let around = grown(&wrap::tight(&both, bounds.diagonal, 0.0)?, mirror, bounds.diagonal)?;
        let found = hull::of_positions(doubled(&around, mirror, sign, bounds.diagonal))?;
        (found.vertices.len() <= bounds.max_vertices).then_some(found)
    };
    let mut found: Vec<(f64, Hull)> =
        [1.0, -1.0].into_iter().filter_map(of_side).map(|hull| (mass::mass(&hull).volume, hull)).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let is_proven = |hull: &Hull| wrap::prove(field, hull, bounds, wrap::MEASUREMENTS).is_ok();
    found.into_iter().map(|(_, hull)| hull).find(is_proven)
}

/// The mirror image of a hull.
pub fn image(hull: &Hull, mirror: &Mirror) -> Option<Hull> {
    hull::of_positions(hull.vertices.iter().map(|p| mirror.rounded_image(*p)).collect())
}

/// A hull that also contains all points within the error of a mirror, and what rounding moves by.
/// `None` if the hull is too thin for that.
pub fn grown(hull: &Hull, mirror: &Mirror, diagonal: f64) -> Option<Hull> {
    let is_exact = |p: &[f32; 3]| {
        let at = |p: [f32; 3]| DVec3::from_array(p.map(f64::from));
        mirror.image(at(*p)) == at(mirror.rounded_image(*p))
    };
    if mirror.error == 0.0 && hull.vertices.iter().all(is_exact) {
        return Some(hull.clone());
    }
    let points = hull.positions();
    let greatest = points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let room = mirror.error + 2.0 * wrap::ROUNDING * greatest;
    let mut centre = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    if hull.rank == 3 && mirror.plane.height(centre).abs() < hull.diameter * MAX_GROWTH {
        centre = mirror.foot(centre);
    }
    let planes = hull.half_spaces();
    let moved: Vec<HalfSpace> = planes.iter().map(|plane| plane.moved(room + wrap::ROUNDING * greatest)).collect();
    let rounded = |p: DVec3| p.as_vec3().to_array().map(|c| c + 0.0);
    if let Some(vertices) = wrap::polytope(&moved, centre, 2.0 * diagonal, 0.4 * room)
        && vertices.len() <= points.len()
    {
        return hull::of_positions(vertices.into_iter().map(rounded).collect());
    }
    // Where more than three faces meet, moved planes cut each other in several points.
    let depths = planes.into_iter().map(|plane| -plane.height(centre));
    let growth = room / depths.fold(f64::INFINITY, f64::min);
    // Written so that NaN fails.
    if !(growth > 0.0 && growth <= MAX_GROWTH) {
        return None;
    }
    hull::of_positions(points.iter().map(|p| rounded(*p + (*p - centre) * growth)).collect())
}

/// The stored vertices of a hull on one side of a mirror, with their images. Those that rounding
/// moved off the plane are put back.
fn doubled(hull: &Hull, mirror: &Mirror, sign: f64, diagonal: f64) -> Vec<[f32; 3]> {
    let room = if mirror.is_exact() { 0.0 } else { 2.0 * wrap::ROUNDING * (hull.diameter + mirror.plane.offset.abs()) };
    let mut found = Vec::new();
    for (stored, p) in hull.vertices.iter().zip(hull.positions()) {
        let height = sign * mirror.plane.height(p);
        if height.abs() <= room + ON_PLANE * diagonal {
            found.push(mirror.foot(p).as_vec3().to_array().map(|c| c + 0.0));
        } else if height > 0.0 {
            found.extend([*stored, mirror.rounded_image(*stored)]);
        }
    }
    found
}

/// The points of a hull on one side of a mirror: its vertices, and where its edges cross the plane.
fn half(hull: &Hull, mirror: &Mirror, sign: f64, diagonal: f64) -> Vec<DVec3> {
    let points = hull.positions();
    let heights: Vec<f64> = points.iter().map(|p| sign * mirror.plane.height(*p)).collect();
    let on_plane = ON_PLANE * diagonal;
    let own = points.iter().zip(&heights).filter(|(_, height)| **height >= -on_plane);
    let mut found: Vec<DVec3> = own.map(|(p, height)| if *height <= on_plane { mirror.foot(*p) } else { *p }).collect();
    // Each edge belongs to two faces.
    for (a, b) in hull.faces.iter().flat_map(|face| hull::edges(face)).filter(|(a, b)| a < b) {
        let (from, to) = (heights[a as usize], heights[b as usize]);
        if from.min(to) < -on_plane && from.max(to) > on_plane {
            found.push(mirror.foot(points[a as usize].lerp(points[b as usize], from / (from - to))));
        }
    }
    found
}
