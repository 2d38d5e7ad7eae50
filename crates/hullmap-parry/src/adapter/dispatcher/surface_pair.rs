//! A surface and a body of convex pieces: overlap, distance and contact.

use hullmap::{Cache, Contact, Distance, Impact, Pose, Settings, Status};

use super::super::convert::narrow_pose;
use super::super::parry;
use super::super::parry::bounding_volume::Aabb;
use super::super::parry::query::ShapeCastHit;
use super::super::parry::shape::Shape;
use super::super::surface::{BakedSurface, SurfaceTile};
use super::pair::{Nearest, Placement, placement};
use super::pieces::{Piece, pieces};

/// A surface, which is A, and a body, which is B.
pub(super) struct SurfacePair<'s> {
    pub(super) surface: &'s BakedSurface,
    pub(super) pieces: Vec<Piece<'s>>,
    pub(super) body: &'s dyn Shape,
    pub(super) placement: Placement,
}

pub(super) struct Part<'p> {
    pub(super) tile: &'p SurfaceTile,
    pub(super) piece: &'p Piece<'p>,
    /// The piece in the frame of the tile.
    pub(super) b_in_a: Pose,
}

/// `None` if neither or both are surfaces, or hullmap does not solve a piece of the other.
pub(super) fn surface_pair<'s>(
    pos12: &parry::math::Pose,
    shape1: &'s dyn Shape,
    shape2: &'s dyn Shape,
) -> Option<SurfacePair<'s>> {
    let (surface, body, flipped) = match (shape1.as_shape::<BakedSurface>(), shape2.as_shape::<BakedSurface>()) {
        (Some(surface), None) => (surface, shape2, false),
        (None, Some(surface)) => (surface, shape1, true),
        _ => return None,
    };
    Some(SurfacePair { surface, pieces: pieces(body)?, body, placement: placement(pos12, flipped)? })
}

impl SurfacePair<'_> {
    pub(super) fn parts(&self) -> impl Iterator<Item = Part<'_>> {
        self.surface.tiles().iter().flat_map(|tile| {
            self.pieces.iter().filter_map(|piece| {
                let in_surface = self.placement.b_in_a.compose(piece.place).ok()?;
                Some(Part { tile, piece, b_in_a: Pose::relative(tile.place(), in_surface).ok()? })
            })
        })
    }

    /// The box of the body in the frame of the surface.
    pub(super) fn body_bounds(&self) -> Aabb {
        self.body.compute_aabb(&narrow_pose(&self.placement.b_in_a))
    }

    pub(super) fn intersects(&self) -> bool {
        self.parts().any(|Part { tile, piece, b_in_a }| {
            hullmap::intersects(tile, piece.shape(), b_in_a, &mut Cache::with_pairs(1)).is_hit()
        })
    }

    /// The distance in the frame of the surface, with subshapes; `None` if no pose is in range.
    pub(super) fn distance(&self) -> Option<(Distance, [u32; 2])> {
        let mut best: Option<(Distance, [u32; 2])> = None;
        for part in self.parts() {
            let Part { tile, piece, b_in_a } = &part;
            let (settings, cache) = (Settings::default(), &mut Cache::with_pairs(1));
            let found = hullmap::distance(*tile, piece.shape(), *b_in_a, &settings, cache);
            // Overlapping ranks before touching, although both distances are 0.
            let rank = |found: &Distance| (found.distance, found.status != Status::Overlapping);
            if best.is_none_or(|(best, _)| rank(&found) < rank(&best)) {
                let place = tile.place();
                let found = Distance {
                    point_a: place.transform_point(found.point_a),
                    point_b: place.transform_point(found.point_b),
                    normal: place.transform_vector(found.normal),
                    ..found
                };
                best = Some((found, part.subshapes(found.parts[0])));
            }
        }
        best
    }

    /// The contact of the deepest triangle and piece, or the nearest points if there is none, in
    /// the frame of the surface, and their subshapes. `None` if no pose is in range.
    pub(super) fn nearest(&self) -> Option<(Nearest, [u32; 2])> {
        let mut deepest: Option<(Nearest, [u32; 2])> = None;
        for part in self.parts() {
            let Part { tile, piece, b_in_a } = &part;
            let (settings, cache) = (Settings::default(), &mut Cache::with_pairs(1));
            let found = hullmap::contact(*tile, piece.shape(), *b_in_a, &settings, cache);
            let Contact { hit, point_a, point_b, normal, depth, parts, .. } = found;
            if hit && deepest.as_ref().is_none_or(|(deepest, _)| -depth < deepest.dist) {
                let found_in_tile = Nearest { point_a, point_b, normal, dist: -depth };
                deepest = Some((part.nearest_in_surface(found_in_tile), part.subshapes(parts[0])));
            }
        }
        deepest.or_else(|| {
            let (Distance { point_a, point_b, normal, distance, .. }, subshapes) = self.distance()?;
            Some((Nearest { point_a, point_b, normal, dist: distance }, subshapes))
        })
    }

    pub(super) fn numbered(&self, hit: ShapeCastHit, [triangle, piece]: [u32; 2]) -> ShapeCastHit {
        let [subshape1, subshape2] = if self.placement.flipped { [piece, triangle] } else { [triangle, piece] };
        ShapeCastHit { subshape1, subshape2, ..hit }
    }
}

impl Part<'_> {
    /// Numbers of a triangle of the tile and of the piece.
    pub(super) fn subshapes(&self, triangle: u32) -> [u32; 2] {
        [self.tile.subshape(triangle as usize), self.piece.subshape]
    }

    /// Converts an answer from the frame of the tile to the frame of the surface.
    pub(super) fn nearest_in_surface(&self, found: Nearest) -> Nearest {
        let place = self.tile.place();
        Nearest {
            point_a: place.transform_point(found.point_a),
            point_b: place.transform_point(found.point_b),
            normal: place.transform_vector(found.normal),
            ..found
        }
    }

    /// Converts an impact from the frame of the tile to the frame of the surface.
    pub(super) fn in_surface(&self, impact: &Impact) -> Impact {
        let place = self.tile.place();
        Impact {
            point_a: place.transform_point(impact.point_a),
            point_b: place.transform_point(impact.point_b),
            normal: place.transform_vector(impact.normal),
            ..*impact
        }
    }
}
