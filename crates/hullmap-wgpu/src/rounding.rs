//! Bound on every rounding error of the kernels, which the record of each pair holds
//! (`records.rs`).
//! docs/contributors/intervals.md, section 13, derives it.

/// Bound on the relative error of one operation in f32, whichever way it is rounded: 2⁻²³.
pub(crate) const EPSILON: f64 = 1.0 / (1 << 23) as f64;

/// Maximum shortfall of the dot product of a support vertex from the GPU, relative to the length of
/// the direction and the radius of the ball around the hull.
pub const SUPPORT_SHORTFALL: f64 = 1.0 / (1 << 18) as f64;

mod units {
    /// For the sum of the outer radii.
    pub(super) const RADII: f64 = 54.0;
    /// For the length of the centre v₀.
    pub(super) const CENTER: f64 = 20.0;
    /// For the lengths that only the preparation in f64 rounds, in units of `f64::EPSILON`: the
    /// largest coefficient, `rounding_units::RADII`, of `crates/hullmap/src/solver/minkowski.rs`.
    pub(super) const DOUBLE: f64 = 68.0;
}

/// Bound on all rounding errors of a support value or of a point: a length. `radii` is the sum of
/// the outer radii, `center` the length of the centre v₀, and `double` the sum of the lengths that
/// only the preparation in f64 rounds.
pub(crate) fn rounding_error(radii: f64, center: f64, double: f64) -> f64 {
    EPSILON * (units::RADII * radii + units::CENTER * center) + f64::EPSILON * units::DOUBLE * double
}
