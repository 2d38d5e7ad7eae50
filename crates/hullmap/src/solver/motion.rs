//! Rays and motions: vectors that are checked once, so that no query has to test for NaN.

use glam::DVec3;

use crate::pose::{MAX_TRANSLATION, Pose};

/// A point, direction or velocity is NaN, infinite or too large.
///
/// # Examples
/// ```
/// use hullmap::{Ray, glam::DVec3};
///
/// let error = Ray::new(DVec3::ZERO, DVec3::new(1.0, f64::NAN, 0.0)).unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     "direction must be finite and within 3.4e38, found (1, NaN, 0): check its source for a division \
///      by zero or an overflow"
/// );
/// ```
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "{what} must be finite and within 3.4e38, found ({}, {}, {}): check its source for a division by zero or an overflow",
    found.x, found.y, found.z
)]
pub struct VectorError {
    /// Name of the vector, for example "direction".
    pub what: &'static str,
    /// The vector as given.
    pub found: DVec3,
}

pub(crate) fn checked(what: &'static str, found: DVec3) -> Result<DVec3, VectorError> {
    // NaN takes the failing branch.
    let is_within = found.to_array().into_iter().all(|c| c.abs() <= MAX_TRANSLATION);
    if is_within { Ok(found) } else { Err(VectorError { what, found }) }
}

/// A ray: all points `origin + t direction` with t ≥ 0, in the frame and unit of a shape.
///
/// The direction need not be of unit length. t is a factor of it: if the direction is a velocity,
/// t is a time. If the direction is zero, the ray is a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    origin: DVec3,
    motion: Motion,
}

impl Ray {
    /// The ray from `origin` along `direction`.
    ///
    /// # Errors
    /// A component is NaN, infinite, or beyond [`MAX_TRANSLATION`].
    pub fn new(origin: DVec3, direction: DVec3) -> Result<Self, VectorError> {
        let (origin, direction) = (checked("origin", origin)?, checked("direction", direction)?);
        Ok(Self { origin, motion: Motion { velocity: direction } })
    }

    /// The origin.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The direction as given.
    pub fn direction(&self) -> DVec3 {
        self.motion.velocity
    }

    /// The point at `t`.
    pub fn point_at(&self, t: f64) -> DVec3 {
        self.origin + self.motion.velocity * t
    }

    pub(crate) fn motion(&self) -> Motion {
        self.motion
    }
}

/// A translation of B in A's frame at constant velocity: at time t, B has moved by t times the
/// velocity.
///
/// Time has the unit that the velocity implies. If the velocity is the displacement of a step, t
/// goes from 0 to 1 during the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    velocity: DVec3,
}

impl Motion {
    /// Translation by `velocity` per unit of time.
    ///
    /// # Errors
    /// A component is NaN, infinite, or beyond [`MAX_TRANSLATION`].
    pub fn new(velocity: DVec3) -> Result<Self, VectorError> {
        Ok(Self { velocity: checked("velocity", velocity)? })
    }

    /// The velocity, in A's frame.
    pub fn velocity(&self) -> DVec3 {
        self.velocity
    }

    /// The motion of A in the frame of B, which is at `b_in_a` at the start and moves by this
    /// motion.
    pub(crate) fn seen_from(&self, b_in_a: Pose) -> Self {
        Self { velocity: b_in_a.inverse_transform_vector(-self.velocity) }
    }

    /// The velocity times a power of two, and that power. No square of the product underflows.
    pub(crate) fn scaled(&self) -> (DVec3, f64) {
        let scale = if self.velocity.abs().max_element() < TINY_SPEED { SCALE } else { 1.0 };
        (self.velocity * scale, scale)
    }

    /// The path of the motion; `None` without motion.
    pub(crate) fn path(&self) -> Option<Path> {
        let (velocity, scale) = self.scaled();
        let greatest = velocity.abs().max_element();
        if greatest == 0.0 {
            return None;
        }
        let shape = velocity / greatest;
        let length = shape.length();
        Some(Path { direction: shape / length, speed: length * greatest, scale })
    }
}

/// Speeds below this are multiplied by [`SCALE`] first: their squares would underflow.
const TINY_SPEED: f64 = power_of_two(-400);

/// The smallest subnormal number times this has a square that is normal.
const SCALE: f64 = power_of_two(600);

const fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

/// The straight path of a motion: lengths along a unit direction stand for times.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Path {
    pub(crate) direction: DVec3,
    /// Length per unit of time, times `scale`.
    speed: f64,
    /// A power of two, 1 unless the speed is tiny.
    scale: f64,
}

impl Path {
    /// Length of the path until `t`, infinite if that is beyond the range of f64. The relative
    /// error is up to three roundings.
    pub(crate) fn length(&self, t: f64) -> f64 {
        t / self.scale * self.speed
    }

    /// Time for a length of the path, infinite if that is beyond the range of f64. The relative
    /// error is up to three roundings.
    pub(crate) fn time(&self, length: f64) -> f64 {
        length / self.speed * self.scale
    }
}

/// Limits and accuracy of [`ray`](crate::ray()) and [`cast`](crate::cast()).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CastSettings {
    /// Maximum t, in the unit of the ray or the motion. A shape that is reached later is not hit.
    /// NaN and negative values count as 0: then only a hit at the start counts. The default is
    /// infinite, which counts as [`f64::MAX`]: a shape that is reached later, at a speed of less
    /// than 1e-269, is not hit.
    pub max_t: f64,
    /// Maximum width of the interval as a length along the ray or the motion. It is relative to the
    /// outer radius of the shape, or to the sum of both radii. Dimensionless. The default is 1e-6.
    ///
    /// NaN and negative values count as 0: the interval becomes as narrow as rounding error allows.
    pub tolerance: f64,
    /// Maximum number of steps. The default is 1000.
    ///
    /// A query that reaches it returns [`Status::IterationLimit`](crate::Status::IterationLimit),
    /// and its interval still contains the true value. Larger values than the solver's own limits
    /// have no effect.
    pub max_iterations: u32,
}

impl Default for CastSettings {
    fn default() -> Self {
        Self { max_t: f64::INFINITY, tolerance: 1e-6, max_iterations: 1000 }
    }
}

impl CastSettings {
    /// Maximum t, finite, with 0 for NaN and for negative values.
    pub(crate) fn limit(&self) -> f64 {
        self.max_t.clamp(0.0, f64::MAX).max(0.0)
    }

    /// The tolerance, with 0 for NaN and for negative values.
    pub(super) fn relative_tolerance(&self) -> f64 {
        self.tolerance.max(0.0)
    }
}
