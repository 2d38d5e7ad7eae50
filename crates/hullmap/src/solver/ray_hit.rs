//! Answer of a ray cast.

use glam::DVec3;

use super::motion::Ray;
use super::status::Status;
use crate::fields::fields;

/// Answer of [`ray`](crate::ray()): where a ray first enters a shape.
///
/// Points and directions are in the shape's frame. t is a factor of the ray's direction, which
/// need not be of unit length.
#[repr(C)]
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
    ///   between hit and miss. If it hits, it does so in the interval. Rays at hulls, boxes and
    ///   triangles never end so: they are decided exactly.
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
    /// Index of the part that decided the answer: the hull of a pack, the triangle of a mesh or a
    /// field. 0 for a shape without parts.
    pub part: u32,
}

fields!(RayHit { hit status t t_lower t_upper point normal iterations support_calls part });

impl Default for RayHit {
    /// A hit that claims nothing.
    fn default() -> Self {
        Self {
            hit: true,
            status: Status::Touching,
            t: 0.0,
            t_lower: 0.0,
            t_upper: f64::INFINITY,
            point: DVec3::ZERO,
            normal: DVec3::X,
            iterations: 0,
            support_calls: 0,
            part: 0,
        }
    }
}

impl RayHit {
    /// The answer for a ray that certainly misses.
    pub(crate) fn miss(ray: &Ray) -> Self {
        Self {
            hit: false,
            status: Status::Separated,
            t: f64::INFINITY,
            t_lower: f64::INFINITY,
            t_upper: f64::INFINITY,
            point: ray.origin(),
            ..Self::default()
        }
    }
}
