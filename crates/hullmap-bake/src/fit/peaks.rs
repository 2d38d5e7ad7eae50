//! Local maxima of the distance from a solid: in its cavities, holes and grooves.
//!
//! # Why a box has none
//! The triangles nearest to any point of a box are within the distance of its centre plus twice its
//! radius.
//! - At a local maximum, no plane separates a point from all nearest points of the solid: away from
//!   the plane, the distance would grow. So a box has none if a plane separates it from all such
//!   triangles.
//! - Along the surface, a box may reach into the solid. Let all triangles near it have heights
//!   between `low` and `high` along some normal, and let what is below `low` be inside. A point of
//!   the box above `high` is separated from the triangles. Any other is above the inside by at most
//!   `high − low`. If that is too little to count, the box has no local maximum that counts.

use glam::DVec3;

use super::{
    branch::LOOK,
    solid::{Near, Solid},
};
use crate::deadline::{Deadline, is_over};
use hullmap_geometry::{planes::HalfSpace, triangle};

/// Number of planes that are tried between a box and what is near.
const TURNS: usize = 4;

/// Radius of the boxes that are searched for peaks, relative to their least distance.
const SMALLEST: f64 = 0.25;

/// Maximum number of boxes, relative to the allowed measurements: each box is measured for each
/// part.
const MAX_BOXES: f64 = 1.0 / 64.0;

/// Distance above a surface that is safely beside it, relative to the error of distances.
const BESIDE: f64 = 4.0;

/// The local maxima of the distance from a solid above some length.
#[derive(Clone, Debug)]
pub struct Peaks {
    above: f64,
    boxes: Vec<[DVec3; 2]>,
}

impl Peaks {
    /// The local maxima greater than `above`, which is positive; `None` if they are not found by
    /// `measurements`, are too many, or are not found before the deadline.
    ///
    /// # Complexity
    /// One nearest-triangle search per measurement.
    pub fn new(solid: &Solid, above: f64, measurements: usize, deadline: Option<Deadline>) -> Option<Self> {
        let [low, high] = solid.bounds();
        let most = (MAX_BOXES * measurements as f64) as usize;
        let mut boxes = Vec::new();
        let mut stack = vec![((low + high) * 0.5, (high - low) * 0.5, f64::INFINITY, None)];
        for count in 0..measurements {
            if boxes.len() > most || count % LOOK == 0 && is_over(deadline) {
                return None;
            }
            let Some((centre, half, within, hint)) = stack.pop() else { return Some(Self { above, boxes }) };
            let radius = half.length();
            let near = solid.near_beside(centre, within, hint.as_ref())?;
            // The maximum may be higher than it is measured.
            let least = above * (1.0 - 1e-9);
            if near.distance + radius <= least
                || near.bound_in_box(centre, half) <= least
                || near.gap > radius && solid.is_inside(centre)
                || is_none_in_box(solid, centre, half, &near, least)
            {
                continue;
            }
            if radius <= SMALLEST * above {
                boxes.push([centre - half, centre + half]);
                continue;
            }
            let axis = half.max_position();
            let mut smaller = half;
            smaller[axis] *= 0.5;
            for side in [-1.0, 1.0] {
                let mut middle = centre;
                middle[axis] += side * smaller[axis];
                stack.push((middle, smaller, near.distance + smaller[axis], Some(near.triangle)));
            }
        }
        None
    }

    /// The length that they exceed.
    pub fn above(&self) -> f64 {
        self.above
    }

    /// Boxes that contain them, given by two corners.
    pub fn boxes(&self) -> &[[DVec3; 2]] {
        &self.boxes
    }
}

/// Whether the distance from the solid has no local maximum greater than `above` in a box around
/// `centre`, of which `near` is the neighbourhood. `false` may mean unknown.
pub fn is_none_in_box(solid: &Solid, centre: DVec3, half: DVec3, near: &Near, above: f64) -> bool {
    is_separated(solid, centre, half, near) || is_along_surface(solid, centre, half, near, above)
}

/// Whether a plane separates a box from all triangles nearest to any of its points. As for a
/// perceptron, each triangle in the way turns the plane.
fn is_separated(solid: &Solid, centre: DVec3, half: DVec3, near: &Near) -> bool {
    let slack = solid.tolerance();
    let radius = near.distance + 2.0 * half.length() + slack;
    let mut away = centre - triangle::nearest(&near.triangle, centre);
    for _ in 0..TURNS {
        let Some(normal) = away.try_normalize() else { return false };
        let plane = HalfSpace { normal, offset: normal.dot(centre) - normal.abs().dot(half) - slack };
        match solid.triangle_above(&plane, centre, radius) {
            None => return true,
            Some(triangle) => {
                let Some(push) = (centre - triangle::nearest(&triangle, centre)).try_normalize() else { return false };
                away = normal + push;
            }
        }
    }
    false
}

/// Whether all triangles near a box are about as high along the normal of the nearest one, above
/// the inside.
fn is_along_surface(solid: &Solid, centre: DVec3, half: DVec3, near: &Near, above: f64) -> bool {
    let [a, b, c] = near.triangle;
    let Some(normal) = (b - a).cross(c - a).try_normalize() else { return false };
    let beside = BESIDE * solid.tolerance();
    let radius = half.length();
    // Also what is near the points below the box.
    let reach = (near.distance + 2.0 * radius).max(radius + above) + beside;
    let most = above - 2.0 * beside;
    let Some([low, high]) = solid.heights_near(normal, centre, reach, most) else { return false };
    let is_inside_below = |normal: DVec3, low: f64, high: f64| {
        let corner = centre - DVec3::select(normal.cmpge(DVec3::ZERO), half, -half);
        let height = normal.dot(corner);
        height > high + beside || solid.is_inside(corner - normal * (height - low + beside).max(0.0))
    };
    is_inside_below(normal, low, high) || is_inside_below(-normal, -high, -low)
}
