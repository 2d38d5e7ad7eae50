//! Ray cast: where a ray enters a shape. It is the shape cast of a point.

use glam::DVec3;

use super::cache::Cache;
use super::cast::{Impact, cast_by_support, cast_sharp};
use super::motion::{CastSettings, Ray};
use super::ray_hit::RayHit;
use super::ray_polytope::{NARROW, ray_polytope};
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

/// Where `ray` first enters `shape`.
///
/// Points and directions are in the shape's frame and unit, and t is a factor of the direction. A
/// ray that starts inside hits at t = 0, with the status [`Overlapping`](Status::Overlapping). A
/// ray whose direction is zero hits only the shape that its origin is in.
///
/// A shape is closed, and so is the ray at both ends, from t = 0 to `max_t`. If rounding error
/// might decide, the vertices of a hull, a box or a triangle decide exactly.
///
/// # Complexity
/// No support call if the ray misses the bounding ball of the shape, 10 to 20 for most hits. The
/// number of steps is bounded by `settings`. A ray that grazes a polytope takes a few passes over
/// its vertices more. No allocation.
///
/// # Reference
/// Snethen, "XenoCollide" (portal refinement along a ray). docs/contributors/intervals.md proves
/// the interval.
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Cuboid;
/// use hullmap::{CastSettings, Ray, Status, ray};
///
/// let cube = Cuboid::new(DVec3::ONE)?;
/// let down = Ray::new(DVec3::new(0.2, 0.3, 5.0), DVec3::new(0.0, 0.0, -2.0))?;
/// let hit = ray(&cube, &down, &CastSettings::default());
/// assert!(hit.hit && (hit.t - 2.0).abs() < 1e-9);
/// assert!(hit.t_lower <= 2.0 && 2.0 <= hit.t_upper);
/// assert!(hit.point.distance(DVec3::new(0.2, 0.3, 1.0)) < 1e-9);
/// assert!(hit.normal.distance(DVec3::Z) < 1e-9);
///
/// let up = Ray::new(DVec3::new(0.2, 0.3, 5.0), DVec3::Z)?;
/// assert_eq!(ray(&cube, &up, &CastSettings::default()).status, Status::Separated);
/// let out = Ray::new(DVec3::ZERO, DVec3::Z)?;
/// assert_eq!(ray(&cube, &out, &CastSettings::default()).status, Status::Overlapping);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn ray<S: SupportMap + ?Sized>(shape: &S, ray: &Ray, settings: &CastSettings) -> RayHit {
    let start = Pose::from_checked(ray.origin());
    let found = match ray.motion().path() {
        Some(path) if !(shape.convex_radius() > 0.0) => cast_sharp((shape, &Dot, start), path, settings, None),
        _ => cast_by_support((shape, &Dot, start), ray.motion(), settings, &mut Cache::new()),
    };
    let Impact { hit, status, t, t_lower, t_upper, normal, iterations, support_calls, .. } = found;
    let point = if hit { ray.point_at(t) } else { ray.origin() };
    let found = RayHit { hit, status, t, t_lower, t_upper, point, normal, iterations, support_calls };
    // Rounding error decides between hit and miss, whether the hit is before the end, or where
    // along an edge it is.
    let is_wide = t_upper - t_lower > NARROW * t_upper;
    let is_open = match status {
        Status::Touching => true,
        Status::Stalled | Status::IterationLimit if is_wide => true,
        _ => hit && t_upper > settings.limit(),
    };
    if is_open && shape.polytope_vertex(0).is_some() {
        return ray_polytope(&|index| shape.polytope_vertex(index), ray, settings, found);
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
