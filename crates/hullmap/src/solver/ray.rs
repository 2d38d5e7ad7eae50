//! Ray cast: where a ray enters a shape. It is the shape cast of a point.

use glam::DVec3;

use super::cache::Cache;
use super::cast::{cast_by_support, cast_dot};
use super::motion::{CastSettings, Ray};
use super::ray_hit::RayHit;
use super::ray_polytope::ray_polytope;
use super::status::Status;
use crate::pose::Pose;
use crate::support::{SupportMap, SupportPoint};

/// A point as a shape.
pub(crate) struct Dot;

impl SupportMap for Dot {
    #[inline(always)]
    fn support_point(&self, _: DVec3) -> SupportPoint {
        SupportPoint { point: DVec3::ZERO, feature: 0 }
    }
    #[inline(always)]
    fn interior_point(&self) -> DVec3 {
        DVec3::ZERO
    }
    #[inline(always)]
    fn inner_radius(&self) -> f64 {
        0.0
    }
    #[inline(always)]
    fn outer_radius(&self) -> f64 {
        0.0
    }
    #[inline(always)]
    fn point(&self, _: u32) -> Option<DVec3> {
        Some(DVec3::ZERO)
    }
}

/// [`ray`](crate::ray()) on a convex shape.
pub(crate) fn ray<S: SupportMap + ?Sized>(shape: &S, ray: &Ray, settings: &CastSettings) -> RayHit {
    if let Some(shape) = shape.erased() {
        return self::ray(shape, ray, settings);
    }
    let start = Pose::from_checked(ray.origin());
    let found = match ray.motion().path() {
        Some(path) if !(shape.convex_radius() > 0.0) => cast_dot((shape, &Dot, start), path, settings),
        _ => cast_by_support((shape, &Dot, start), ray.motion(), settings, &mut Cache::new()),
    };
    let found = found.ray_hit(if found.hit { ray.point_at(found.t) } else { ray.origin() });
    // Rounding error decides between hit and miss, whether the hit is before the end, or where
    // along an edge it is.
    let is_open = match found.status {
        Status::Touching | Status::Stalled | Status::IterationLimit => true,
        _ => found.hit && found.t_upper > settings.limit(),
    };
    if is_open && shape.polytope_vertex(0).is_some() {
        return ray_polytope(&|index| shape.polytope_vertex(index), ray, settings, shape.outer_radius(), found);
    }
    found
}

/// Tolerance of an entry, relative to the outer radius: the other shape of a manifold may be a
/// thousand times smaller. Polytopes are exact in a few steps whatever it is.
const TOLERANCE: f64 = 1e-10;

/// The t at which `line` enters `shape`, by support queries; `None` if it misses or grazes it. It
/// starts outside.
///
/// Not generic: each `dyn Shape` calls it, and would take a solver of its own into the program.
pub(crate) fn entry(shape: &dyn SupportMap, line: &Ray) -> Option<f64> {
    let settings = CastSettings { tolerance: TOLERANCE, ..CastSettings::default() };
    let hit = ray(shape, line, &settings);
    // One entry of a hundred stalls just above the tolerance.
    let width = (hit.t_upper - hit.t_lower) * line.direction().length();
    let is_narrow = hit.status == Status::Stalled && width <= 10.0 * TOLERANCE * shape.outer_radius();
    (is_narrow || matches!(hit.status, Status::Exact | Status::Within)).then_some(hit.t)
}
