//! parry's ray casts of a surface, by hullmap's [`ray`](hullmap::ray()).

use hullmap::CastSettings;
use hullmap::glam::DVec3;

use super::super::convert::{double, narrow, real, wide};
use super::super::parry::math::Real;
use super::super::parry::query::{Ray, RayCast, RayIntersection};
use super::super::parry::shape::FeatureId;
use super::BakedSurface;

struct Meeting {
    time: f64,
    /// Unit normal on the side that the ray comes from.
    normal: DVec3,
    subshape: u32,
}

impl RayCast for BakedSurface {
    fn cast_local_ray(&self, ray: &Ray, max_time_of_impact: Real, _solid: bool) -> Option<Real> {
        Some(real(self.meet(ray, max_time_of_impact)?.time))
    }

    /// The feature is a face with the number of the triangle, which is the subshape, too.
    fn cast_local_ray_and_get_normal(
        &self,
        ray: &Ray,
        max_time_of_impact: Real,
        _solid: bool,
    ) -> Option<RayIntersection> {
        let Meeting { time, normal, subshape } = self.meet(ray, max_time_of_impact)?;
        let hit = RayIntersection::new(real(time), narrow(normal), FeatureId::Face(subshape));
        Some(hit.with_subshape(subshape))
    }
}

impl BakedSurface {
    fn meet(&self, ray: &Ray, max_time_of_impact: Real) -> Option<Meeting> {
        let (origin, dir) = (wide(ray.origin), wide(ray.dir));
        let mut first: Option<Meeting> = None;
        for tile in self.tiles() {
            let (place, max_t) = (tile.place(), first.as_ref().map_or(double(max_time_of_impact), |found| found.time));
            let (origin, dir) = (place.inverse().transform_point(origin), place.inverse_transform_vector(dir));
            let local = hullmap::Ray::new(origin, dir).ok()?;
            let settings = CastSettings { max_t, ..CastSettings::default() };
            let hit = hullmap::ray(tile, &local, &settings);
            // NaN takes the failing branch. Ties go to the first tile.
            if hit.hit && hit.t <= max_t && first.as_ref().is_none_or(|first| hit.t < first.time) {
                let normal = place.transform_vector(hit.normal);
                first = Some(Meeting { time: hit.t, normal, subshape: tile.subshape(hit.part as usize) });
            }
        }
        first
    }
}
