//! Vectors and numbers in parry's precision and in f64, in which hullmap computes.

// One of the two precisions makes each cast a no-op.
#![allow(clippy::unnecessary_cast)]

use hullmap::glam::DVec3;

use super::parry::math::{Real, Vector};

/// A vector in f64. Exact.
#[inline]
pub(super) fn wide(v: Vector) -> DVec3 {
    DVec3::new(v.x as f64, v.y as f64, v.z as f64)
}

/// A vector in parry's precision, rounded.
#[inline]
pub(super) fn narrow(v: DVec3) -> Vector {
    Vector::new(v.x as Real, v.y as Real, v.z as Real)
}

/// A number in parry's precision, rounded.
#[inline]
pub(super) fn real(x: f64) -> Real {
    x as Real
}

/// A number in f64. Exact.
#[inline]
pub(super) fn double(x: Real) -> f64 {
    x as f64
}
