//! Ray cast: where a ray enters a shape. It is the shape cast of a point.

use glam::DVec3;

use super::cache::Cache;
use super::cast::{Impact, cast, cast_sharp};
use super::motion::{CastSettings, Ray};
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

/// Answer of [`ray`](crate::ray()): where a ray first enters a shape.
///
/// Points and directions are in the shape's frame. t is a factor of the ray's direction, which
/// need not be of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// False only if it is certain that the ray misses the shape up to
    /// [`CastSettings::max_t`](crate::CastSettings::max_t).
    pub hit: bool,
    /// How the query ended.
    ///
    /// - [`Separated`](Status::Separated): certainly no hit. t and its interval are infinite.
    /// - [`Overlapping`](Status::Overlapping): the origin is inside the shape. t is 0, the point is
    ///   the origin, and the normal is opposite to the direction. If the direction is zero, the
    ///   normal is any unit vector.
    /// - [`Exact`](Status::Exact), [`Within`](Status::Within): a hit in the interval.
    /// - [`Touching`](Status::Touching): the ray grazes the shape, and rounding error decides
    ///   between hit and miss. If it hits, it does so in the interval.
    /// - [`IterationLimit`](Status::IterationLimit), [`Stalled`](Status::Stalled): a hit, in an
    ///   interval that is wider than the tolerance.
    pub status: Status,
    /// The ray enters the shape at `origin + t direction`; infinite if there is no hit.
    pub t: f64,
    /// Lower bound of t, at least 0, with allowance for rounding error.
    pub t_lower: f64,
    /// Upper bound of t, with allowance for rounding error. It may exceed `max_t` if the interval
    /// does.
    pub t_upper: f64,
    /// The point at t. If the ray grazes the shape, the point need not be on the shape. The origin
    /// if there is no hit.
    pub point: DVec3,
    /// Unit outward normal of a support plane of the shape, which the ray crosses at `t_lower`. On
    /// a polytope, it is the normal of the face at the point. If there is no hit, normal of a plane
    /// that takes part in the proof.
    pub normal: DVec3,
    /// Number of steps of the search.
    pub iterations: u32,
    /// Number of support calls.
    pub support_calls: u32,
}

/// Where `ray` first enters `shape`.
///
/// Points and directions are in the shape's frame and unit, and t is a factor of the direction. A
/// ray that starts inside hits at t = 0, with the status [`Overlapping`](Status::Overlapping). A
/// ray whose direction is zero hits only the shape that its origin is in.
///
/// # Complexity
/// No support call if the ray misses the bounding ball of the shape, 10 to 20 for most hits. The
/// number of steps is bounded by `settings`. No allocation.
///
/// # Reference
/// Snethen, "XenoCollide" (portal refinement along a ray). docs/intervals.md proves the interval.
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
        _ => cast(shape, &Dot, start, ray.motion(), settings, &mut Cache::new()),
    };
    let Impact { hit, status, t, t_lower, t_upper, normal, iterations, support_calls, .. } = found;
    let point = if hit { ray.point_at(t) } else { ray.origin() };
    RayHit { hit, status, t, t_lower, t_upper, point, normal, iterations, support_calls }
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
