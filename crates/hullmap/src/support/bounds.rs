//! Axis-aligned bounds: the box that a broad phase uses.

use glam::{DVec3, Vec3};

/// An axis-aligned box that contains a shape, in the frame that its pose maps to and in the shape's
/// unit.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    /// Minimum of each coordinate.
    pub min: DVec3,
    /// Maximum of each coordinate.
    pub max: DVec3,
}

impl Bounds {
    /// The smallest box with f32 coordinates that contains this one: minimum and maximum.
    ///
    /// The box is infinite where this one extends beyond the range of f32.
    pub fn to_f32(&self) -> [Vec3; 2] {
        let below = |c: f64| {
            let nearest = c as f32;
            if f64::from(nearest) > c { nearest.next_down() } else { nearest }
        };
        let above = |c: f64| -below(-c);
        let [a, b] = [self.min.to_array().map(below), self.max.to_array().map(above)];
        [Vec3::from_array(a), Vec3::from_array(b)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_precision_bounds_contain_and_are_the_smallest() {
        for c in [0.0, 1.0, 0.1, -0.1, 1.0 / 3.0, 1e-46, -1e-46, 3.5e38, 1e300, 16_777_217.0, -16_777_217.0] {
            let [min, max] = Bounds { min: DVec3::splat(c), max: DVec3::splat(c) }.to_f32();
            assert!(f64::from(min.x) <= c && c <= f64::from(max.y), "{c}: {min} {max}");
            assert!(max.z == min.z || max.z == min.z.next_up(), "{c}: {min} {max}");
        }
        let [min, max] = Bounds { min: DVec3::NAN, max: DVec3::NAN }.to_f32();
        assert!(min.is_nan() && max.is_nan());
    }
}
