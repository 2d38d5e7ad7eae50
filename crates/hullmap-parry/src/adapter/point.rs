//! parry's point queries of a baked hull, by hullmap's
//! [`signed_distance`](hullmap::signed_distance()).

use hullmap::glam::DVec3;
use hullmap::shapes::Sphere;
use hullmap::{Cache, Settings, SignedDistance};

use super::BakedHull;
use super::convert::{narrow, wide};
use super::parry::math::Vector;
use super::parry::query::{PointProjection, PointQuery};
use super::parry::shape::FeatureId;

impl PointQuery for BakedHull {
    fn project_local_point(&self, point: Vector, solid: bool) -> PointProjection {
        if solid && self.contains_local_point(point) {
            return PointProjection::new(true, point);
        }
        self.surface(point).map_or(PointProjection::new(false, point), |found| projection(&found))
    }

    /// The feature is the face whose normal is closest to the projection's. At an edge or a vertex,
    /// it need not contain the projection.
    fn project_local_point_and_get_feature(&self, point: Vector) -> (PointProjection, FeatureId) {
        let Some(found) = self.surface(point) else {
            return (PointProjection::new(false, point), FeatureId::Unknown);
        };
        let feature = self.face_towards(found.normal).map_or(FeatureId::Unknown, FeatureId::Face);
        (projection(&found), feature)
    }

    fn contains_local_point(&self, point: Vector) -> bool {
        let place = hullmap::Pose::from_translation(wide(point));
        let (Ok(place), Ok(dot)) = (place, Sphere::new(0.0)) else { return false };
        // For most points outside, this needs fewer support calls than the distance does.
        hullmap::intersects(self, &dot, place, &mut Cache::new()).is_hit()
    }
}

impl BakedHull {
    /// The closest point of the surface; `None` for a point that is not finite or too far away.
    fn surface(&self, point: Vector) -> Option<SignedDistance> {
        let point: DVec3 = wide(point);
        hullmap::signed_distance(self, point, &Settings::default(), &mut Cache::new()).ok()
    }
}

fn projection(found: &SignedDistance) -> PointProjection {
    PointProjection::new(found.distance < 0.0, narrow(found.point))
}
