//! Simplified hulls, whose vertices are rounded to f32: how far they are pushed outward before.

use crate::hull::Hull;

/// A simplified hull.
#[derive(Clone, Debug)]
pub struct Simplified {
    /// The hull, without source vertices. Its containment error is 0 unless it is flat.
    pub hull: Hull,
    /// Maximum distance by which it exceeds the original hull, in the points' units.
    pub outer_error: f64,
}

/// Distance of the outward push, relative to the largest coordinate. Rounding to f32 moves each
/// coordinate by up to 6e-8, and a point by up to 1.04e-7.
pub(super) const PUSH: f64 = 1.1e-7;

/// Number of margins tried, each twice the previous one, before the hull is left as it is.
pub(super) const MAX_TRIES: i32 = 8;

/// Bound on the rounding error of a measured distance, relative to the diameter.
pub(super) const ROUNDING: f64 = 1e-14;
