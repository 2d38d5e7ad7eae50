//! Errors of the constructors of shapes.

use glam::DVec3;

/// Maximum length: the maximum coordinate of a hull, which is f32. The square of a sum of such
/// lengths is finite in f64.
pub(super) const MAX_LENGTH: f64 = f32::MAX as f64;

/// A shape cannot be made, because a number is invalid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// A length is NaN, negative or above [`f32::MAX`].
    #[error("{what} must be from 0 to 3.4e38, found {found}: check where the value comes from")]
    Length {
        /// Name of the length, for example "radius".
        what: &'static str,
        /// The value found.
        found: f64,
    },
    /// A scale is NaN, or its magnitude is below 1e-38 or above [`f32::MAX`].
    #[error(
        "scale must have a magnitude from 1e-38 to 3.4e38 along each axis, found {found}: use a small scale to \
         flatten a shape; otherwise check where the value comes from"
    )]
    Scale {
        /// The value found.
        found: f64,
    },
    /// A coordinate of a point is NaN, or its magnitude is above [`f32::MAX`].
    #[error(
        "{what} must have coordinates from -3.4e38 to 3.4e38, found ({}, {}, {}): check where the values come from",
        found.x, found.y, found.z
    )]
    Point {
        /// Name of the point, for example "corner".
        what: &'static str,
        /// The point found.
        found: DVec3,
    },
    /// A normal is zero or not finite.
    #[error(
        "normal must be finite and not zero, found ({}, {}, {}): check where the values come from",
        found.x, found.y, found.z
    )]
    Normal {
        /// The vector found.
        found: DVec3,
    },
    /// The offset of a plane is NaN, or its magnitude is above [`f32::MAX`].
    #[error("offset must be from -3.4e38 to 3.4e38, found {found}: check where the value comes from")]
    Offset {
        /// The value found.
        found: f64,
    },
}

/// Returns `found` if it is a valid length.
pub(super) fn length(what: &'static str, found: f64) -> Result<f64, ShapeError> {
    // NaN takes the failing branch. `abs` turns −0 into 0.
    if (0.0..=MAX_LENGTH).contains(&found) { Ok(found.abs()) } else { Err(ShapeError::Length { what, found }) }
}

/// Returns `found` if its coordinates are valid.
pub(super) fn point(what: &'static str, found: DVec3) -> Result<DVec3, ShapeError> {
    // NaN takes the failing branch.
    let within = found.to_array().into_iter().all(|c| c.abs() <= MAX_LENGTH);
    if within { Ok(found) } else { Err(ShapeError::Point { what, found }) }
}
