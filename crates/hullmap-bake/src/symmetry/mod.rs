//! Mirror symmetry: the plane about which a mesh, or a set of parts, is symmetric.
//!
//! Coordinates decide, so it applies to any pack, whatever tool made its parts.

mod mirror;
mod search;

use std::collections::HashSet;

use glam::DVec3;

pub use mirror::Mirror;

use crate::fit::solid::Solid;
use hullmap_geometry::{PointSet, triangle};

/// Maximum number of parts that are compared with each other where coordinates are rounded.
const MAX_ROUNDED: usize = 1024;

/// Length across a second mirror, relative to the first, up to which it is not used: most parts of
/// a plate are their own images about the middle of its thickness.
const THIN: f64 = 0.5;

/// Maximum number of triangles whose reflections are compared with the surface.
const MAX_TRIANGLES: usize = 4096;

/// Up to two mirror planes of a mesh, whose solid is `solid`, at right angles to each other. Each
/// vertex has another within rounding of its reflection, and reflected triangles lie on the
/// surface. Coordinate planes are preferred, then the one across which the mesh is longest. The
/// mesh is at least half as long across the second.
///
/// # Complexity
/// O(n log n) for n vertices and triangles.
pub fn mirrors_of_mesh(mesh: &PointSet, solid: &Solid) -> Vec<Mirror> {
    let points: Vec<[f32; 3]> = mesh.triangles.iter().flatten().map(|v| mesh.positions[*v as usize]).collect();
    let is_mirrored = |mirror: &Mirror| {
        let step = mesh.triangles.len().div_ceil(MAX_TRIANGLES);
        mesh.triangles.iter().step_by(step.max(1)).all(|corners| {
            let corners = mesh.corners(corners);
            let centre = triangle::centroid(&corners);
            let within = 2.0 * (search::tolerance(&points) + solid.tolerance());
            // The image of one point could lie on the edge of a hole.
            std::iter::once(centre).chain(corners.map(|p| p.midpoint(centre))).all(|p| {
                let image = mirror.image(p);
                let near = solid.near(image, within);
                near.is_some_and(|near| triangle::nearest(&near.triangle, image).distance(image) <= within)
            })
        })
    };
    let size = |mirror: &Mirror| {
        let heights = points.iter().map(|p| mirror.plane.height(DVec3::from_array(p.map(f64::from))).abs());
        heights.fold(0.0, f64::max)
    };
    let mut found: Vec<Mirror> = search::mirrors(&points).into_iter().filter(is_mirrored).take(2).collect();
    if let [first, second] = &found[..]
        && size(second) < THIN * size(first)
    {
        found.pop();
    }
    found
}

/// The plane about which parts, each given by its vertices, are symmetric: each is the mirror image
/// of another, or of itself. `None` if there is none, or for a single part.
///
/// # Complexity
/// O(n log n) for n vertices about a plane through the origin that is at right angles to an axis.
/// About others, parts of equal numbers of vertices are compared pair by pair.
pub fn mirror_of_parts(parts: &[&[[f32; 3]]]) -> Option<Mirror> {
    if parts.len() < 2 {
        return None;
    }
    let points: Vec<[f32; 3]> = parts.concat();
    search::mirrors(&points).into_iter().find(|mirror| are_mirrored(parts, mirror))
}

fn are_mirrored(parts: &[&[[f32; 3]]], mirror: &Mirror) -> bool {
    let sorted = |mut points: Vec<[u32; 3]>| {
        points.sort_unstable();
        points
    };
    let bits = |p: [f32; 3]| p.map(|c| (c + 0.0).to_bits());
    let own = |part: &&[[f32; 3]]| sorted(part.iter().map(|p| bits(*p)).collect());
    let all: HashSet<Vec<[u32; 3]>> = parts.iter().map(own).collect();
    let image = |part: &&[[f32; 3]]| sorted(part.iter().map(|p| bits(mirror.rounded_image(*p))).collect());
    if parts.iter().all(|part| all.contains(&image(part))) {
        return true;
    }
    !mirror.is_exact() && parts.len() <= MAX_ROUNDED && are_nearly_mirrored(parts, mirror)
}

/// As [`are_mirrored`], within rounding.
fn are_nearly_mirrored(parts: &[&[[f32; 3]]], mirror: &Mirror) -> bool {
    let points: Vec<[f32; 3]> = parts.concat();
    let tolerance = search::tolerance(&points);
    let at = |p: &[f32; 3]| DVec3::from_array(p.map(f64::from));
    let is_near = |p: &[f32; 3], q: &[f32; 3]| mirror.image(at(p)).distance(at(q)) <= tolerance;
    let is_image = |part: &[[f32; 3]], other: &[[f32; 3]]| {
        part.len() == other.len() && part.iter().all(|p| other.iter().any(|q| is_near(p, q)))
    };
    parts.iter().all(|part| parts.iter().any(|other| is_image(part, other)))
}

#[cfg(test)]
mod tests;
