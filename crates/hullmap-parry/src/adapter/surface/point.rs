//! parry's point queries of a surface: the nearest point of the triangles.

use hullmap::glam::DVec3;
use hullmap::{Cache, Settings};

use super::super::convert::{narrow, wide};
use super::super::parry::math::Vector;
use super::super::parry::query::{PointProjection, PointQuery};
use super::super::parry::shape::FeatureId;
use super::BakedSurface;

impl PointQuery for BakedSurface {
    /// Nothing is inside a surface.
    fn project_local_point(&self, point: Vector, _solid: bool) -> PointProjection {
        self.project_local_point_and_get_feature(point).0
    }

    /// The feature is a face with the number of the triangle.
    fn project_local_point_and_get_feature(&self, point: Vector) -> (PointProjection, FeatureId) {
        match self.nearest(point) {
            Some((near, subshape)) => (PointProjection::new(false, narrow(near)), FeatureId::Face(subshape)),
            None => (PointProjection::new(false, point), FeatureId::Unknown),
        }
    }
}

impl BakedSurface {
    /// The nearest point and its triangle's number; `None` for a point not finite, or too far away.
    fn nearest(&self, point: Vector) -> Option<(DVec3, u32)> {
        let point = wide(point);
        let mut best: Option<(f64, DVec3, u32)> = None;
        for tile in self.tiles() {
            let local = tile.place().inverse().transform_point(point);
            let (settings, cache) = (Settings::default(), &mut Cache::with_pairs(1));
            let found = hullmap::signed_distance(tile, local, &settings, cache).ok()?;
            if best.is_none_or(|(least, ..)| found.distance < least) {
                let near = tile.place().transform_point(found.point);
                best = Some((found.distance, near, tile.subshape(found.part as usize)));
            }
        }
        best.map(|(_, near, subshape)| (near, subshape))
    }
}
