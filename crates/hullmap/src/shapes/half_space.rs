//! Half-space: everything below a plane. Its queries have closed forms, with one support query.
//!
//! # Steps
//! 1. Query the support point of the other shape in the direction opposite to the normal: its
//!    lowest point.
//! 2. The signed height of this point above the plane is the distance or the negative depth.
//!
//! # Deviations
//! - A half-space is unbounded, so it has no support mapping and does not implement [`SupportMap`].
//!   In the direction of the normal it acts as one point of its plane, and the rounding error is
//!   the same as for the Minkowski difference of this point and the other shape.

use super::error::{MAX_LENGTH, ShapeError, point};
use crate::pose::Pose;
use crate::solver::motion::checked;
use crate::solver::{
    CastSettings, Contact, Distance, Impact, Intersection, Minkowski, Motion, Overlap, Ray, RayHit, SignedDistance,
    Status, VectorError,
};
use crate::support::{SupportMap, SupportPoint};
use crate::vector::unit;
use glam::DVec3;

/// Everything below a plane: the points p with `normal` · p ≤ `offset`. Unbounded, for floors and
/// walls.
///
/// Queries of a half-space need no cache, and of their settings, `cast` and `ray` use only
/// [`max_t`](CastSettings::max_t). The normal of an answer is always the plane's. Two half-spaces
/// have no common query: the answer claims nothing.
///
/// # Examples
/// ```
/// use hullmap::glam::{DQuat, DVec3};
/// use hullmap::shapes::{Cuboid, HalfSpace};
/// use hullmap::{Cache, Pose, Settings, Status};
///
/// let (floor, cube) = (HalfSpace::new(DVec3::Z, 0.0)?, Cuboid::new(DVec3::ONE)?);
/// // The cube stands on an edge, which reaches √2 below its centre.
/// let tilted = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_4);
/// let at = Pose::new(DVec3::new(5.0, 0.0, 1.0), tilted)?;
/// let contact = hullmap::contact(&floor, &cube, at, &Settings::default(), &mut Cache::new());
/// assert!(contact.hit && (contact.depth - (2_f64.sqrt() - 1.0)).abs() < 1e-12);
/// assert_eq!((contact.normal, contact.status), (DVec3::Z, Status::Exact));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    normal: DVec3,
    offset: f64,
}

/// Rounding error of the point `normal * offset` along the normal, in units of `f64::EPSILON` times
/// the offset. The stored normal has a length within 5 units of 1, which counts twice; the product
/// adds half a unit.
const OFFSET_UNITS: f64 = 12.0;

/// Rounding error of the speed towards the plane, in units of `f64::EPSILON` times the speed: a dot
/// product, and the length of the normal.
const SPEED_UNITS: f64 = 8.0;

/// A point as a shape. In the direction of the normal, a half-space is one point of its plane.
#[derive(Debug)]
pub(crate) struct Foot(DVec3);

impl SupportMap for Foot {
    fn support_point(&self, _: DVec3) -> SupportPoint {
        SupportPoint { point: self.0, feature: 0 }
    }
    fn interior_point(&self) -> DVec3 {
        self.0
    }
    fn inner_radius(&self) -> f64 {
        0.0
    }
    fn outer_radius(&self) -> f64 {
        0.0
    }
}

/// The lowest point of a shape, relative to the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lowest {
    normal: DVec3,
    /// Depth below the plane; negative above.
    pub(crate) depth: f64,
    lower: f64,
    upper: f64,
    point_b: DVec3,
    pub(crate) support_calls: u32,
    /// Index of the shape among the parts that it is one of.
    pub(crate) part: u32,
}

impl Lowest {
    /// Higher than the lowest point of any shape.
    pub(crate) const NONE: Self = Self {
        normal: DVec3::X,
        depth: f64::NEG_INFINITY,
        lower: f64::NEG_INFINITY,
        upper: f64::NEG_INFINITY,
        point_b: DVec3::ZERO,
        support_calls: 0,
        part: 0,
    };

    /// The same point, of a part.
    pub(crate) fn of_part(self, index: usize) -> Self {
        Self { part: index as u32, ..self }
    }

    /// `lower`, with an interval that contains the depth of the lower of two shapes.
    pub(crate) fn wider(self, lower: Self) -> Self {
        Self { lower: lower.lower.max(self.lower), upper: lower.upper.max(self.upper), ..lower }
    }

    fn overlap(&self) -> Overlap {
        match (self.lower > 0.0, self.upper < 0.0) {
            (true, _) => Overlap::Overlapping,
            (_, true) => Overlap::Separated,
            _ if self.depth.is_finite() && self.upper.is_finite() => Overlap::Touching,
            _ => Overlap::Undecided,
        }
    }

    /// The projection of the point onto the plane.
    fn point_a(&self) -> DVec3 {
        self.point_b + self.normal * self.depth
    }

    pub(crate) fn intersection(&self) -> Intersection {
        Intersection {
            status: self.overlap(),
            iterations: self.support_calls,
            support_calls: self.support_calls,
            parts: [0, self.part],
        }
    }

    pub(crate) fn contact(&self) -> Contact {
        let found = Contact {
            hit: true,
            status: Status::Exact,
            depth: self.depth,
            depth_lower: self.lower,
            depth_upper: self.upper,
            normal: self.normal,
            point_a: self.point_a(),
            point_b: self.point_b,
            iterations: self.support_calls,
            support_calls: self.support_calls,
            parts: [0, self.part],
            ..Contact::default()
        };
        let none = Contact { depth: 0.0, depth_lower: 0.0, ..found };
        match self.overlap() {
            Overlap::Overlapping => found,
            Overlap::Touching => Contact { status: Status::Touching, depth_upper: self.upper.max(0.0), ..none },
            Overlap::Separated => Contact { hit: false, status: Status::Separated, depth_upper: 0.0, ..none },
            Overlap::Undecided => Contact { status: Status::Stalled, depth_upper: f64::INFINITY, ..none },
        }
    }

    /// When the shape reaches the plane by this motion.
    pub(crate) fn impact(&self, motion: Motion, settings: &CastSettings) -> Impact {
        // All times are in the unit of the scaled velocity, except those in the answer.
        let (velocity, scale) = motion.scaled();
        let (limit, latest) = (settings.limit() / scale, f64::MAX / scale);
        // Gap at the start, and the speed at which it closes, as intervals. Divisions add an error
        // of one unit each.
        let speed = -self.normal.dot(velocity);
        let speed_error = SPEED_UNITS * f64::EPSILON * velocity.length();
        let (slowest, fastest) = (speed - speed_error, speed + speed_error);
        let overlap = self.overlap();
        let t_lower = if self.upper < 0.0 { -self.upper / fastest * (1.0 - 2.0 * f64::EPSILON) } else { 0.0 };
        let t_upper = (-self.lower).max(0.0) / slowest * (1.0 + 2.0 * f64::EPSILON);
        let at = |t: f64, t_lower: f64, t_upper: f64, status: Status| {
            let point_b = self.point_b + velocity * t;
            let height = -self.depth - speed * t;
            let [t, t_lower, t_upper] = [t, t_lower, t_upper].map(|t| t * scale);
            Impact {
                hit: true,
                status,
                t,
                t_lower,
                t_upper,
                normal: self.normal,
                point_a: point_b - self.normal * height,
                point_b,
                iterations: 1,
                support_calls: self.support_calls,
                parts: [0, self.part],
            }
        };
        let miss = Impact {
            hit: false,
            t: f64::INFINITY,
            point_a: DVec3::ZERO,
            point_b: DVec3::ZERO,
            ..at(0.0, f64::INFINITY, f64::INFINITY, Status::Separated)
        };
        match overlap {
            Overlap::Undecided => at(0.0, 0.0, f64::INFINITY, Status::Stalled),
            // The deepest point of the shape is in the half-space too.
            Overlap::Overlapping => Impact { point_a: self.point_b, ..at(0.0, 0.0, 0.0, Status::Overlapping) },
            // Not moving towards the plane.
            Overlap::Separated if !(fastest > 0.0) || t_lower > limit => miss,
            Overlap::Touching if !(fastest > 0.0) => at(0.0, 0.0, 0.0, Status::Touching),
            // Nearly parallel to the plane.
            _ if !(slowest > 0.0) => at(t_lower, t_lower, f64::INFINITY, Status::Touching),
            _ => {
                let t = (-self.depth / speed).max(t_lower).min(t_upper).min(latest);
                let status = if t_upper > limit { Status::Touching } else { Status::Exact };
                at(t, t_lower, t_upper.min(latest), status)
            }
        }
    }

    pub(crate) fn distance(&self) -> Distance {
        let found = Distance {
            status: Status::Exact,
            distance: -self.depth,
            lower: -self.upper,
            upper: -self.lower,
            normal: self.normal,
            point_a: self.point_a(),
            point_b: self.point_b,
            iterations: self.support_calls,
            support_calls: self.support_calls,
            parts: [0, self.part],
            ..Distance::default()
        };
        let none = Distance { distance: 0.0, lower: 0.0, ..found };
        match self.overlap() {
            Overlap::Separated => found,
            Overlap::Touching => Distance { status: Status::Touching, upper: (-self.lower).max(0.0), ..none },
            // The deepest point of the shape is in the half-space too.
            Overlap::Overlapping => Distance { status: Status::Overlapping, upper: 0.0, point_a: self.point_b, ..none },
            Overlap::Undecided => Distance { status: Status::Stalled, upper: f64::INFINITY, ..none },
        }
    }
}

impl HalfSpace {
    /// The points p with `normal` · p ≤ `offset`, after `normal` is normalised. The plane is at the
    /// signed distance `offset` from the origin, along the normal.
    ///
    /// # Errors
    /// [`ShapeError::Normal`] if `normal` is zero or not finite, [`ShapeError::Offset`] if `offset`
    /// is NaN or beyond [`f32::MAX`].
    pub fn new(normal: DVec3, offset: f64) -> Result<Self, ShapeError> {
        let largest = normal.abs().max_element();
        // Divided first: the square of a tiny or huge vector would underflow or overflow.
        let unit = unit(normal / largest).filter(|_| normal.is_finite());
        let normal = unit.ok_or(ShapeError::Normal { found: normal })?;
        // NaN takes the failing branch.
        if offset.abs() <= MAX_LENGTH { Ok(Self { normal, offset }) } else { Err(ShapeError::Offset { found: offset }) }
    }

    /// The half-space below the plane through `on_plane`, with this outward normal.
    ///
    /// # Errors
    /// [`ShapeError::Normal`] if `normal` is zero or not finite, [`ShapeError::Point`] or
    /// [`ShapeError::Offset`] if the point is not finite or too far from the origin.
    pub fn through(on_plane: DVec3, normal: DVec3) -> Result<Self, ShapeError> {
        let at_origin = Self::new(normal, 0.0)?;
        Self::new(at_origin.normal, at_origin.normal.dot(point("point of the plane", on_plane)?))
    }

    /// Unit normal of the plane, out of the half-space.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Distance of the plane from the origin along the normal.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// The point of the plane that is closest to the origin.
    pub(crate) fn foot(&self) -> Foot {
        Foot(self.normal * self.offset)
    }

    /// The lowest point of `b`, placed at `b_in_a`: one support query.
    pub(crate) fn lowest<B: SupportMap + ?Sized>(&self, b: &B, b_in_a: Pose) -> Lowest {
        let foot = self.foot();
        let mut m = Minkowski::new(&foot, b, b_in_a);
        let vertex = m.point(self.normal);
        let depth = vertex.w.dot(self.normal);
        let offset_error = OFFSET_UNITS * f64::EPSILON * self.offset.abs();
        // The point belongs to the shape. Only whether it is the lowest depends on the support
        // error.
        let (lower, upper) = (depth - m.noise() - offset_error, depth + m.rounding_error() + offset_error);
        Lowest { normal: self.normal, depth, lower, upper, point_b: vertex.b(), support_calls: 1, part: 0 }
    }

    pub(crate) fn ray(&self, ray: &Ray, settings: &CastSettings) -> RayHit {
        let found = self.lowest(&Foot(DVec3::ZERO), Pose::from_checked(ray.origin())).impact(ray.motion(), settings);
        found.ray_hit(if found.hit { ray.point_at(found.t) } else { ray.origin() })
    }

    pub(crate) fn signed_distance(&self, point: DVec3) -> Result<SignedDistance, VectorError> {
        let found = self.lowest(&Foot(DVec3::ZERO), Pose::from_checked(checked("point", point)?));
        let status = if found.overlap() == Overlap::Touching { Status::Touching } else { Status::Exact };
        Ok(SignedDistance {
            status,
            distance: -found.depth,
            lower: -found.upper,
            upper: -found.lower,
            point: found.point_a(),
            normal: self.normal,
            iterations: 1,
            support_calls: 1,
            ..SignedDistance::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{Cuboid, Sphere};
    use glam::DQuat;

    #[test]
    fn invalid_numbers_are_errors() {
        for bad in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY, DVec3::new(1.0, f64::NEG_INFINITY, 0.0)] {
            assert!(matches!(HalfSpace::new(bad, 0.0), Err(ShapeError::Normal { .. })), "{bad}");
        }
        for bad in [f64::NAN, f64::INFINITY, 1e39, -1e39] {
            assert!(matches!(HalfSpace::new(DVec3::Z, bad), Err(ShapeError::Offset { .. })), "{bad}");
            assert!(HalfSpace::through(DVec3::X * bad, DVec3::Z).is_err());
        }
        for size in [1e-300, 1e-3, 1.0, 1e300] {
            assert!((HalfSpace::new(DVec3::ONE * size, 1.0).unwrap().normal().length() - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn touching_is_neither_separated_nor_overlapping() {
        let turn = DQuat::from_xyzw(0.1, -0.3, 0.2, 0.9).normalize();
        let (cube, ball) = (Cuboid::new(DVec3::new(0.3, 0.7, 0.9)).unwrap(), Sphere::new(0.8).unwrap());
        for size in [1e-3, 1.0, 1e6] {
            let normal = DVec3::new(1.0, 2.0, -0.5).normalize();
            let plane = HalfSpace::new(normal, 3.0 * size).unwrap();
            // The centre of the ball is its radius above the plane, up to rounding error.
            let pose = Pose::new(normal * (3.0 * size + 0.8), turn).unwrap();
            assert_eq!(plane.lowest(&ball, pose).intersection().status, Overlap::Touching);
            let (c, d) = (plane.lowest(&ball, pose).contact(), plane.lowest(&ball, pose).distance());
            assert_eq!((c.status, c.hit, c.depth), (Status::Touching, true, 0.0));
            assert_eq!((d.status, d.lower, d.distance), (Status::Touching, 0.0, 0.0));
            assert!(d.upper < 1e-13 * (1.0 + size) && c.depth_upper < 1e-13 * (1.0 + size));
            let raised = plane.lowest(&cube, Pose::from_translation(normal * (3.0 * size + 5.0)).unwrap()).distance();
            assert!(raised.status == Status::Exact && raised.lower > 0.0);
            assert!((raised.point_b - raised.point_a).dot(normal) > 0.99 * raised.distance);
        }
    }

    /// A shape whose support points are NaN gets an answer that claims nothing.
    #[test]
    fn nan_is_undecided() {
        let half = HalfSpace::new(DVec3::Z, 0.0).unwrap();
        let lowest = half.lowest(&Foot(DVec3::NAN), Pose::IDENTITY);
        assert_eq!(lowest.intersection().status, Overlap::Undecided);
        let (c, d) = (lowest.contact(), lowest.distance());
        assert!(c.hit && c.depth_lower == 0.0 && c.depth_upper == f64::INFINITY && c.status == Status::Stalled);
        assert!(d.lower == 0.0 && d.upper == f64::INFINITY && d.status == Status::Stalled);
    }
}
