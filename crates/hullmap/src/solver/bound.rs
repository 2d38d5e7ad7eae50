//! Upper bound of the penetration depth: a support plane with its witness points.

use glam::DVec3;

use super::barycentric::{blend, on_triangle};
use super::minkowski::Point;

/// The minimum support value so far, with its normal and its witness points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    /// Support value of the Minkowski difference along `normal`, without allowance for rounding
    /// error.
    pub(super) upper: f64,
    /// Of unit length, from A to B.
    pub(super) normal: DVec3,
    /// Witness point of A, in A's frame.
    pub(super) point_a: DVec3,
    /// Witness point of B, in A's frame.
    pub(super) point_b: DVec3,
}

impl Bound {
    /// The infinite bound, before any plane was tried.
    pub(super) fn none() -> Self {
        Self { upper: f64::INFINITY, normal: DVec3::ZERO, point_a: DVec3::ZERO, point_b: DVec3::ZERO }
    }

    /// A bound whose witness points belong to the point of `face` closest to the origin.
    pub(super) fn at(upper: f64, normal: DVec3, face: [&Point; 3]) -> Self {
        let [p, q, r] = face.map(|v| v.w);
        let weights = on_triangle(p, q, r).weights;
        let (point_a, point_b) = (blend(&weights, face.map(|v| v.a)), blend(&weights, face.map(|v| v.b())));
        Self { upper, normal, point_a, point_b }
    }
}
