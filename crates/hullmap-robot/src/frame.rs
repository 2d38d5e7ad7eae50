//! Frames: rigid placements, which are read right to left.

use glam::{DQuat, DVec3, EulerRot};

/// Placement of a frame in another one: a rotation, then a translation. `a * b` is b's in a's
/// parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The rotation, of unit length.
    pub rotation: DQuat,
    /// The origin, in the parent's frame.
    pub translation: DVec3,
}

impl Frame {
    /// The parent's frame itself.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, translation: DVec3::ZERO };

    /// A frame at a translation, rotated about the fixed axes x, y, z, in this order, in radians.
    pub fn of_xyz_rpy([x, y, z, roll, pitch, yaw]: [f64; 6]) -> Self {
        let rotation = DQuat::from_euler(EulerRot::ZYX, yaw, pitch, roll);
        Self { rotation, translation: DVec3::new(x, y, z) }
    }

    /// The parent's placement in this frame.
    pub fn inverse(self) -> Self {
        let rotation = self.rotation.inverse();
        Self { rotation, translation: rotation * -self.translation }
    }

    /// A point of this frame, in the parent's.
    pub fn apply(self, point: DVec3) -> DVec3 {
        self.rotation * point + self.translation
    }
}

impl std::ops::Mul for Frame {
    type Output = Self;

    fn mul(self, inner: Self) -> Self {
        let rotation = (self.rotation * inner.rotation).normalize();
        Self { rotation, translation: self.apply(inner.translation) }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    #[test]
    fn frames_are_read_right_to_left() {
        let turned = Frame::of_xyz_rpy([1.0, 0.0, 0.0, 0.0, 0.0, FRAC_PI_2]);
        assert!(turned.apply(DVec3::X).abs_diff_eq(DVec3::new(1.0, 1.0, 0.0), 1e-15));
        let both = turned * Frame::of_xyz_rpy([2.0, 0.0, 0.0, FRAC_PI_2, 0.0, 0.0]);
        assert!(both.apply(DVec3::Y).abs_diff_eq(DVec3::new(1.0, 2.0, 1.0), 1e-15));
        let back = both.inverse() * both;
        assert!(back.translation.length() < 1e-15 && back.rotation.abs_diff_eq(DQuat::IDENTITY, 1e-15));
        let rolled = Frame::of_xyz_rpy([0.0, 0.0, 0.0, FRAC_PI_2, 0.0, FRAC_PI_2]);
        assert!(rolled.apply(DVec3::Y).abs_diff_eq(DVec3::Z, 1e-15));
    }
}
