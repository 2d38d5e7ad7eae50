//! parry's ray casts of a baked hull, by hullmap's [`ray`](hullmap::ray()).

use hullmap::CastSettings;
use hullmap::glam::DVec3;

use super::BakedHull;
use super::convert::{double, narrow, real, wide};
use super::parry::math::Real;
use super::parry::query::{Ray, RayCast, RayIntersection};
use super::parry::shape::FeatureId;

struct Meeting {
    time: f64,
    /// Outward where the ray enters the hull, inward where a ray from inside leaves it.
    normal: DVec3,
    /// Outward normal of the surface.
    outward: DVec3,
}

impl RayCast for BakedHull {
    fn cast_local_ray(&self, ray: &Ray, max_time_of_impact: Real, solid: bool) -> Option<Real> {
        Some(real(self.meet(ray, max_time_of_impact, solid)?.time))
    }

    /// The feature is the hit face. From inside, a `solid` hull is hit at time 0 with a normal
    /// opposite to the direction; otherwise, the ray hits the surface, and the normal points
    /// inward.
    fn cast_local_ray_and_get_normal(
        &self,
        ray: &Ray,
        max_time_of_impact: Real,
        solid: bool,
    ) -> Option<RayIntersection> {
        let Meeting { time, normal, outward } = self.meet(ray, max_time_of_impact, solid)?;
        let feature = self.face_towards(outward).map_or(FeatureId::Unknown, FeatureId::Face);
        Some(RayIntersection::new(real(time), narrow(normal), feature))
    }
}

impl BakedHull {
    fn meet(&self, ray: &Ray, max_time_of_impact: Real, solid: bool) -> Option<Meeting> {
        let (origin, dir) = (wide(ray.origin), wide(ray.dir));
        let max_t = double(max_time_of_impact);
        let settings = CastSettings { max_t, ..CastSettings::default() };
        let hit = hullmap::ray(self, &hullmap::Ray::new(origin, dir).ok()?, &settings);
        if !hit.hit {
            return None;
        }
        let inside = hit.status == hullmap::Status::Overlapping;
        if !inside || solid {
            return Some(Meeting { time: hit.t, normal: hit.normal, outward: hit.normal });
        }
        // Cast a ray back from a point beyond the hull: it enters where this ray leaves.
        let reach = hullmap::SupportMap::support_point(self, dir).point.dot(dir) - origin.dot(dir);
        let beyond = 2.0 * reach / dir.length_squared();
        let back = hullmap::Ray::new(origin + dir * beyond, -dir).ok()?;
        let hit = hullmap::ray(self, &back, &CastSettings::default());
        let time = (beyond - hit.t).max(0.0);
        (hit.hit && time <= max_t).then_some(Meeting { time, normal: -hit.normal, outward: hit.normal })
    }
}
