//! Queries of a geometry and a ray, or a point.

use glam::DVec3;

use crate::compound::{self, Parts};
use crate::geometry::{Geometry, Visitor};
use crate::shapes::{HalfSpace, Shape};
use crate::solver::{self, Cache, CastSettings, Ray, RayHit, Settings, SignedDistance, VectorError};

/// Where `ray` first enters `a`.
///
/// Points and directions are in its frame and unit, and t is a factor of the direction. A ray that
/// starts inside hits at t = 0, with the status [`Overlapping`](crate::Status::Overlapping). A ray
/// whose direction is zero hits only what its origin is in.
///
/// A shape is closed, and so is the ray at both ends, from t = 0 to `max_t`. If rounding error
/// might decide, the vertices of a hull, a box or a triangle decide exactly. So a ray through an
/// edge, a vertex or a seam hits every triangle and every hull there, with certainty, and cannot
/// slip between them to the surface behind. Other shapes, such as spheres, may be grazed, where
/// rounding error decides. A grazed part that is nearer than the first certain hit is the answer,
/// with the status [`Stalled`](crate::Status::Stalled), and the interval extends to the certain
/// hit. If only grazed parts were found, the interval contains the intervals of all of them.
///
/// # Complexity
/// A shape: no support call if the ray misses its bounding ball, 10 to 20 for most hits. The number
/// of steps is bounded by `settings`. A ray that grazes a polytope takes a few passes over its
/// vertices more. Parts: branch and bound, none for parts farther away than the first hit. No
/// allocation.
///
/// # Reference
/// Snethen, "XenoCollide" (portal refinement along a ray). docs/contributors/intervals.md proves
/// the interval.
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Cuboid;
/// use hullmap::{CastSettings, Pose, Ray, ray};
///
/// let cube = Cuboid::new(DVec3::ONE)?;
/// let down = Ray::new(DVec3::new(0.2, 0.3, 5.0), DVec3::new(0.0, 0.0, -2.0))?;
/// let hit = ray(&cube, &down, &CastSettings::default());
/// assert!(hit.hit && (hit.t - 2.0).abs() < 1e-9);
/// assert!(hit.t_lower <= 2.0 && 2.0 <= hit.t_upper);
/// assert!(hit.point.distance(DVec3::new(0.2, 0.3, 1.0)) < 1e-9);
/// assert!(hit.normal.distance(DVec3::Z) < 1e-9);
///
/// // A ray in the world, at a shape with a pose in the world:
/// let placed = Pose::from_translation(DVec3::new(7.0, 0.0, 0.0))?;
/// let [origin, direction] = [DVec3::new(0.0, 0.3, 0.2), DVec3::X];
/// let own = Ray::new(placed.inverse_transform_point(origin), placed.inverse_transform_vector(direction))?;
/// let hit = ray(&cube, &own, &CastSettings::default());
/// assert!(placed.transform_point(hit.point).distance(DVec3::new(6.0, 0.3, 0.2)) < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[inline]
pub fn ray<G: Geometry + ?Sized>(a: &G, ray: &Ray, settings: &CastSettings) -> RayHit {
    a.visit(Cast { ray, settings })
}

/// Signed distance of `point` from the surface of `a`: positive outside, negative inside, with the
/// closest point of the surface.
///
/// Lengths are in the geometry's unit, points and directions in its frame. `cache` belongs to it
/// and to points near this one; the query reads and updates it.
///
/// With parts, it is the minimum of the signed distances from all parts. Outside, it is the
/// distance from the union. Inside, it is the depth in the part in which the point is deepest, so a
/// ball of radius `-distance` around the point is inside the union. Where parts overlap or touch,
/// the surface of the union may be farther away, and `point` of the answer may be inside another
/// part. Triangles have no inside: [`surface_distance`](crate::compound::surface_distance) is the
/// signed distance from the surface of a watertight mesh. The interval contains this minimum. A
/// positive lower bound proves that the point is outside of the union, a negative upper bound that
/// it is inside.
///
/// # Errors
/// A component of `point` is NaN, infinite, or beyond
/// [`MAX_TRANSLATION`](crate::pose::MAX_TRANSLATION).
///
/// # Complexity
/// For a point outside, the cost of [`distance`](crate::distance()): 3 to 8 support calls. For a
/// point inside, also the cost of [`contact`](crate::contact()): 20 to 60. Parts: usually one such
/// query for a point outside, and one for each part whose box contains a point inside. No
/// allocation.
#[inline]
pub fn signed_distance<G: Geometry + ?Sized>(
    a: &G,
    point: DVec3,
    settings: &Settings,
    cache: &mut Cache,
) -> Result<SignedDistance, VectorError> {
    a.visit(Locate { point, settings, cache })
}

struct Cast<'q> {
    ray: &'q Ray,
    settings: &'q CastSettings,
}

impl Visitor for Cast<'_> {
    type Output = RayHit;

    #[inline(always)]
    fn shape<S: Shape + ?Sized>(self, shape: &S) -> RayHit {
        solver::ray::ray(shape, self.ray, self.settings)
    }

    fn parts<P: Parts + ?Sized>(self, parts: &P) -> RayHit {
        compound::motion::ray(parts, self.ray, self.settings)
    }

    fn half_space(self, half_space: &HalfSpace) -> RayHit {
        half_space.ray(self.ray, self.settings)
    }
}

struct Locate<'q> {
    point: DVec3,
    settings: &'q Settings,
    cache: &'q mut Cache,
}

impl Visitor for Locate<'_> {
    type Output = Result<SignedDistance, VectorError>;

    #[inline(always)]
    fn shape<S: Shape + ?Sized>(self, shape: &S) -> Self::Output {
        solver::signed_distance::signed_distance(shape, self.point, self.settings, self.cache)
    }

    fn parts<P: Parts + ?Sized>(self, parts: &P) -> Self::Output {
        compound::signed_distance::signed_distance(parts, self.point, self.settings, self.cache)
    }

    fn half_space(self, half_space: &HalfSpace) -> Self::Output {
        half_space.signed_distance(self.point)
    }
}
