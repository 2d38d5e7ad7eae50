//! Rays against a baked hull.

use super::BakedHull;
use super::parry::math::Real;
use super::parry::query::details::local_ray_intersection_with_support_map_with_params;
use super::parry::query::gjk::VoronoiSimplex;
use super::parry::query::{Ray, RayCast, RayIntersection};

impl RayCast for BakedHull {
    fn cast_local_ray_and_get_normal(
        &self,
        ray: &Ray,
        max_time_of_impact: Real,
        solid: bool,
    ) -> Option<RayIntersection> {
        let simplex = &mut VoronoiSimplex::new();
        local_ray_intersection_with_support_map_with_params(self, simplex, ray, max_time_of_impact, solid)
    }
}
