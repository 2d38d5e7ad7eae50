//! Shared by the steps of a search: the solid, lengths, and points that no part may contain.

use glam::DVec3;
use rayon::prelude::*;

use super::{
    body::Body,
    field::Field,
    piece::{Piece, Scale},
    planes::FacePlanes,
    sample::spread_points,
    shape::{self, Component, Part},
    wrap::HullLimits,
};
use crate::spread::spread;

/// Number of evenly spread points of which the forbidden ones are used.
const SPREAD: usize = 6000;

/// Approximate number of places on the surface next to which forbidden points are searched for.
const BESIDE: f64 = 3000.0;

/// Maximum number of points of a hull that are found too far from the solid.
const REFUTING: usize = 12;

/// Maximum number of distances measured to find them.
const MEASURED: usize = 800;

/// State that the steps of a search share.
pub struct PartitionSearch<'a> {
    /// The mesh's solid.
    pub field: &'a Field<'a>,
    /// Lengths.
    pub scale: Scale<'a>,
    /// Planes of faces that may divide pieces.
    pub planes: &'a FacePlanes,
    /// Limits of hulls.
    pub bounds: HullLimits<'a>,
}

impl PartitionSearch<'_> {
    /// Whether the deadline has passed, or the search is cancelled.
    pub fn is_over(&self) -> bool {
        self.bounds.is_over()
    }

    /// Points in the hull of the whole surface that are too far from the solid; when the time is
    /// over, some of them.
    pub fn forbidden(&self, triangles: &[[DVec3; 3]], hull: &Body) -> Vec<DVec3> {
        let size = hull.high - hull.low;
        let mut found: Vec<DVec3> = (0..SPREAD).map(|k| hull.low + size * DVec3::from_array(spread(k))).collect();
        let normal = |[a, b, c]: &[DVec3; 3]| (*b - *a).cross(*c - *a);
        let area: f64 = triangles.iter().map(|triangle| 0.5 * normal(triangle).length()).sum();
        let spacing = self.scale.limit.max((area / BESIDE).sqrt());
        for (index, p) in spread_points(triangles.iter().copied(), spacing * spacing) {
            let up = normal(&triangles[index]).normalize_or_zero();
            let height = 1.02 * self.scale.limit;
            found.extend([p + up * height, p - up * height]);
        }
        let is_forbidden =
            |p: &DVec3| hull.holds(*p, 0.0) && !self.is_over() && self.field.is_far(*p, self.scale.limit);
        found.into_par_iter().filter(is_forbidden).collect()
    }

    /// Points of a piece's hull that are too far from the solid; none if none are found.
    pub fn beyond(&self, piece: &Piece) -> Vec<DVec3> {
        if !piece.forbidden.is_empty() {
            return piece.forbidden.clone();
        }
        self.points_beyond(&piece.body)
    }

    /// Points of a body that are too far from the solid; none if none are found.
    pub fn points_beyond(&self, body: &Body) -> Vec<DVec3> {
        let limit = self.scale.limit;
        let mut found = self.field.points_beyond(&body.triangles, limit, REFUTING, MEASURED);
        if self.scale.is_small(body) {
            found.retain(|p| self.field.is_far(*p, limit));
        }
        found
    }

    /// A piece whose surface is free of points that are too far from the solid, without the corners
    /// that are not: no cut need part such corners, which both of its sides see. They are left to
    /// other pieces. `None` if there are none.
    pub fn without_far_corners(&self, piece: &Piece) -> Option<Piece> {
        if piece.forbidden.is_empty() || piece.corners.is_empty() {
            return None;
        }
        let free = |corners: &[DVec3]| {
            let found = self.scale.piece(piece.atoms.clone(), corners.to_vec(), piece.planes.clone(), &piece.forbidden);
            (found.forbidden.is_empty() && self.points_beyond(&found.body).is_empty()).then_some(found)
        };
        let (mut best, mut corners) = (free(&[])?, Vec::new());
        for corner in &piece.corners {
            corners.push(*corner);
            match free(&corners) {
                Some(found) => best = found,
                None => drop(corners.pop()),
            }
        }
        (corners.len() < piece.corners.len()).then_some(best)
    }

    /// The part of a piece.
    pub fn shaped(&self, piece: &Piece) -> Result<Part, Option<DVec3>> {
        let (hull, bound) = shape::shaped(self.field, &piece.body, &self.bounds)?;
        Ok(Part { piece: piece.clone(), hull, bound, component: Component::default() })
    }
}
