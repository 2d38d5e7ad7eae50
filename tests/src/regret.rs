//! Regret of a support query: the maximum dot product over all source points, in f64, independent
//! of the hull. The maximum is the judge's.

use glam::{DVec3, Vec3};
use hullmap_verify::truth::{Points, dot};

/// The source points.
pub struct Truth {
    points: Points,
    /// At most the maximum distance between two points, and nearly as much.
    pub diameter: f64,
    /// Greatest magnitude of a coordinate.
    pub reach: f64,
}

impl Truth {
    /// Takes the source points. Panics without points.
    pub fn new(positions: &[[f32; 3]]) -> Self {
        let points = Points::new(positions);
        let reach = positions.as_flattened().iter().fold(0.0, |reach: f64, c| reach.max(f64::from(c.abs())));
        Self { diameter: points.diameter(), points, reach }
    }

    /// Regret of a support query: maximum dot product minus `dir · got`, over |dir| · diameter.
    /// 0 for an invalid direction, and where all points are the same.
    pub fn regret(&self, dir: Vec3, got: Vec3) -> f64 {
        self.in_direction(dir.as_dvec3()).map_or(0.0, |truth| truth.regret(got.as_dvec3()))
    }

    /// The maximum dot product in one direction of any length; `None` for an invalid direction.
    pub fn in_direction(&self, d: DVec3) -> Option<Greatest> {
        if !d.is_finite() || d == DVec3::ZERO {
            return None;
        }
        // Scaling by a power of two is exact.
        let d = d * (-f64::from(d.abs().max_element().log2().floor() as i32)).exp2();
        Some(Greatest { d, greatest: self.points.greatest_dot(d.to_array()), size: d.length() * self.diameter })
    }
}

/// The maximum dot product in one direction.
pub struct Greatest {
    d: DVec3,
    greatest: f64,
    /// Length of the direction times the diameter.
    size: f64,
}

impl Greatest {
    /// (greatest − own dot product of `got`) / (|d| · diameter); 0 where all points are the same.
    pub fn regret(&self, got: DVec3) -> f64 {
        if self.size == 0.0 { 0.0 } else { (self.greatest - dot(got.to_array(), self.d.to_array())) / self.size }
    }
}
