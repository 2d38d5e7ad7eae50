//! Points against a baked hull.

use super::BakedHull;
use super::convert::wide;
use super::parry::math::Vector;
use super::parry::query::details::local_point_projection_on_support_map;
use super::parry::query::gjk::VoronoiSimplex;
use super::parry::query::{PointProjection, PointQuery};
use super::parry::shape::FeatureId;

impl PointQuery for BakedHull {
    fn project_local_point(&self, point: Vector, solid: bool) -> PointProjection {
        local_point_projection_on_support_map(self, &mut VoronoiSimplex::new(), point, solid)
    }

    /// The feature is the face towards the point.
    fn project_local_point_and_get_feature(&self, point: Vector) -> (PointProjection, FeatureId) {
        let projection = self.project_local_point(point, false);
        let away = wide(point) - wide(projection.point);
        let normal = if projection.is_inside { -away } else { away };
        let feature = self.face_towards(normal).map_or(FeatureId::Unknown, FeatureId::Face);
        (projection, feature)
    }
}
