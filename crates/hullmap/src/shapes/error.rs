//! Why numbers do not make a shape.

/// Lengths are at most this: the greatest f32, as that is what hulls hold. Squares of sums of such lengths are finite in f64.
pub(super) const MAX_LENGTH: f64 = f32::MAX as f64;

/// Why numbers do not make a shape.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// A length is NaN, negative or too large.
    #[error("{what} must be from 0 to 3.4e38, found {found}: check the scene's source")]
    Length {
        /// Which length.
        what: &'static str,
        /// The number given.
        found: f64,
    },
    /// A scale is NaN, zero or out of range.
    #[error(
        "scale must be from 1e-38 to 3.4e38 along each axis, or the same below 0, found {found}: check the scene's source"
    )]
    Scale {
        /// The number given.
        found: f64,
    },
}

/// `found` if it is a length.
pub(super) fn length(what: &'static str, found: f64) -> Result<f64, ShapeError> {
    // NaN takes the failing branch. Zero loses its sign.
    if (0.0..=MAX_LENGTH).contains(&found) { Ok(found.abs()) } else { Err(ShapeError::Length { what, found }) }
}
