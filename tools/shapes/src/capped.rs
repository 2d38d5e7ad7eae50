//! Solids with a face of many corners whose normal is near an axis: prisms, and rocks cut flat.
//!
//! The normal cones around such a face lie side by side around its normal. A direction index
//! arranges them by their angle, which makes a full turn.

use std::f64::consts::TAU;

use crate::rng::SplitMix64;

/// Points on the rounded side of a solid that is not a prism.
const SIDE_POINTS: usize = 60;

/// How a capped solid looks.
#[derive(Clone, Copy, Debug)]
pub struct Capped {
    /// Number of corners of the cap.
    pub corners: usize,
    /// Axis near which the cap's normal lies: 0 to 2; negative direction if `is_negative`.
    pub axis: usize,
    /// Whether the cap faces the axis' negative direction.
    pub is_negative: bool,
    /// Angle between the cap's normal and the axis, in radians. If it is not 0, rounding to f32
    /// leaves the corners nearly in one plane.
    pub tilt_rad: f64,
    /// Rotation about the axis, in radians.
    pub turn_rad: f64,
    /// Whether the solid is a prism. Otherwise the opposite side is round.
    pub is_prism: bool,
    /// Whether the corners are evenly spaced.
    pub is_regular: bool,
}

impl Capped {
    /// A random one, with 9 to 500 corners.
    pub fn random(rng: &mut SplitMix64) -> Self {
        // As many hulls with 9 to 20 corners as with 200 to 500.
        let corners = libm::exp(rng.between(libm::log(9.0), libm::log(500.5))) as usize;
        let tilt_rad = [0.0, 0.0, 1e-7, 1e-5, 1e-3, 0.1][rng.below(6)];
        // Among others, corners at the diagonals, at which a turn ends.
        let turn_rad = match rng.below(3) {
            0 => TAU / 8.0 * rng.below(8) as f64,
            1 => TAU / corners as f64 * 0.5 * rng.below(2 * corners) as f64,
            _ => TAU * rng.unit(),
        };
        Self {
            corners,
            axis: rng.below(3),
            is_negative: rng.below(2) == 0,
            tilt_rad,
            turn_rad,
            is_prism: rng.below(2) == 0,
            is_regular: rng.below(2) == 0,
        }
    }

    /// Its points.
    pub fn points(self, rng: &mut SplitMix64) -> Vec<[f32; 3]> {
        let corner = |index: usize, shift: f64| {
            let angle_rad = (index as f64 + shift) / self.corners as f64 * TAU + self.turn_rad;
            [libm::cos(angle_rad), libm::sin(angle_rad)]
        };
        let mut points = Vec::new();
        for index in 0..self.corners {
            let shift = if self.is_regular { 0.0 } else { rng.between(-0.4, 0.4) };
            let [x, y] = corner(index, shift);
            points.push([x, y, 0.5]);
            if self.is_prism {
                points.push([x, y, -0.5]);
            }
        }
        if !self.is_prism {
            let round = std::iter::repeat_with(|| rng.direction()).filter(|p| p[2] < 0.3);
            points.extend(round.take(SIDE_POINTS).map(|[x, y, z]| [1.2 * x, 1.1 * y, 0.9 * z]));
        }
        points.into_iter().map(|p| self.placed(p)).collect()
    }

    /// Tilts a point about the first axis, and lets the third axis become the cap's.
    fn placed(self, [x, y, z]: [f64; 3]) -> [f32; 3] {
        let (sin, cos) = (libm::sin(self.tilt_rad), libm::cos(self.tilt_rad));
        let (y, z) = if self.tilt_rad == 0.0 { (y, z) } else { (cos * y - sin * z, sin * y + cos * z) };
        let z = if self.is_negative { -z } else { z };
        let mut point = [0.0; 3];
        point[self.axis] = z as f32;
        point[(self.axis + 1) % 3] = x as f32;
        point[(self.axis + 2) % 3] = y as f32;
        point
    }
}
