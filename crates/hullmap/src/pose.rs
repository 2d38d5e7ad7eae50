//! Rigid pose of one shape in the frame of another.
//!
//! A pose is read right to left: `b_in_a` maps points of B's local frame into A's local frame,
//! `p_in_a = rotation * p_in_b + translation`. It is checked once, when it is made, so that no query has
//! to ask again whether a number is finite or a quaternion of unit length.

#![forbid(unsafe_code)]

use glam::{DMat3, DQuat, DVec3, Quat, Vec3};

/// Greatest magnitude of a translation's coordinate: that of the shapes' own coordinates, which are in single precision. The
/// solver multiplies up to six lengths; of this size they are still numbers.
pub const MAX_TRANSLATION: f64 = f32::MAX as f64;

/// A rigid transform `b_in_a`: it maps B's local frame into A's.
///
/// The translation is finite and within [`MAX_TRANSLATION`], in A's frame and units; the rotation is of unit length. There is no scale:
/// scaled shapes are other shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    rotation: DQuat,
    translation: DVec3,
}

/// Why numbers do not make a [`Pose`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PoseError {
    /// A component of the translation is NaN, infinite, or beyond [`MAX_TRANSLATION`].
    #[error(
        "translation must be finite and within {MAX_TRANSLATION:e}, found ({}, {}, {}): \
         check the pose's source for a division by zero or an overflow",
        found.x, found.y, found.z
    )]
    Translation {
        /// The translation as given.
        found: DVec3,
    },
    /// A component of the rotation is NaN or infinite.
    #[error(
        "rotation must be finite, found ({}, {}, {}, {}): check the pose's source for a division by zero or an overflow",
        found.x, found.y, found.z, found.w
    )]
    Rotation {
        /// The quaternion as given, x y z w.
        found: DQuat,
    },
    /// The rotation is the zero quaternion, which turns nothing into nothing.
    #[error("rotation must not be the zero quaternion: for no rotation give (0, 0, 0, 1), in the order x y z w")]
    ZeroRotation,
}

impl Pose {
    /// B's frame lies on A's.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, translation: DVec3::ZERO };

    /// The pose that first turns by `rotation`, then moves by `translation` (in A's frame and units).
    ///
    /// `rotation` is normalised here, so it may have any finite length but zero.
    ///
    /// # Errors
    /// When a component is NaN or infinite, when the translation is beyond [`MAX_TRANSLATION`], or when `rotation` is zero.
    pub fn new(translation: DVec3, rotation: DQuat) -> Result<Self, PoseError> {
        if !rotation.is_finite() {
            return Err(PoseError::Rotation { found: rotation });
        }
        // Divide by the greatest component first: squares of tiny or huge ones would vanish or overflow.
        let greatest = rotation.to_array().into_iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        if greatest == 0.0 {
            return Err(PoseError::ZeroRotation);
        }
        let rotation = DQuat::from_array(rotation.to_array().map(|c| c / greatest)).normalize();
        Ok(Self { rotation, ..Self::from_translation(translation)? })
    }

    /// The pose that only moves, by `translation` in A's frame and units.
    ///
    /// # Errors
    /// When a component is NaN, infinite, or beyond [`MAX_TRANSLATION`].
    pub fn from_translation(translation: DVec3) -> Result<Self, PoseError> {
        // NaN takes the failing branch.
        let within = translation.to_array().into_iter().all(|c| c.abs() <= MAX_TRANSLATION);
        if !within {
            return Err(PoseError::Translation { found: translation });
        }
        Ok(Self { rotation: DQuat::IDENTITY, translation })
    }

    /// [`Pose::new`] from single precision: widened first, normalised in double precision.
    ///
    /// # Errors
    /// As [`Pose::new`].
    pub fn from_f32(translation: Vec3, rotation: Quat) -> Result<Self, PoseError> {
        Self::new(translation.as_dvec3(), rotation.as_dquat())
    }

    /// The rotation, of unit length.
    #[inline]
    pub fn rotation(&self) -> DQuat {
        self.rotation
    }

    /// The translation: where B's origin lies in A's frame.
    #[inline]
    pub fn translation(&self) -> DVec3 {
        self.translation
    }

    /// The rotation as a matrix, for those who turn many vectors.
    #[inline]
    pub fn rotation_matrix(&self) -> DMat3 {
        DMat3::from_quat(self.rotation)
    }

    /// The pose the other way, `a_in_b`.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.conjugate();
        Self { rotation, translation: -(rotation * self.translation) }
    }

    /// A point of B's frame, in A's.
    pub fn transform_point(&self, point_in_b: DVec3) -> DVec3 {
        self.rotation * point_in_b + self.translation
    }

    /// A direction of B's frame, in A's: turned, not moved.
    pub fn transform_vector(&self, vector_in_b: DVec3) -> DVec3 {
        self.rotation * vector_in_b
    }

    /// A direction of A's frame, in B's.
    pub fn inverse_transform_vector(&self, vector_in_a: DVec3) -> DVec3 {
        self.rotation.conjugate() * vector_in_a
    }
}

impl Default for Pose {
    fn default() -> Self {
        Self::IDENTITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some_pose() -> Pose {
        Pose::new(DVec3::new(1.0, -2.0, 3.0), DQuat::from_xyzw(0.3, -0.2, 0.9, 0.4)).unwrap()
    }

    #[test]
    fn there_and_back() {
        let pose = some_pose();
        let p = DVec3::new(0.7, 5.0, -2.5);
        assert!((pose.inverse().transform_point(pose.transform_point(p)) - p).length() < 1e-14);
        assert!((pose.inverse_transform_vector(pose.transform_vector(p)) - p).length() < 1e-14);
        assert!((pose.rotation_matrix() * p + pose.translation() - pose.transform_point(p)).length() < 1e-14);
    }

    #[test]
    fn rotation_is_normalised_whatever_its_length() {
        let unit = some_pose().rotation();
        for scale in [1e-300, 1e-6, 1.0, 1e6, 1e300] {
            let scaled = DQuat::from_array(unit.to_array().map(|c| c * scale));
            let pose = Pose::new(DVec3::ZERO, scaled).unwrap();
            assert!((pose.rotation().length() - 1.0).abs() < 1e-15);
            assert!(pose.rotation().dot(unit) > 1.0 - 1e-14);
        }
    }

    #[test]
    fn bad_numbers_are_errors_that_say_what_was_found() {
        let nan = Pose::from_translation(DVec3::new(0.0, f64::NAN, 0.0)).unwrap_err();
        assert!(nan.to_string().contains("(0, NaN, 0)"), "{nan}");
        for far in [1e39, 1e154, -1e308] {
            assert!(Pose::from_translation(DVec3::new(0.0, 0.0, far)).is_err());
        }
        assert!(Pose::from_translation(DVec3::splat(-3e38)).is_ok());
        let infinite = Pose::new(DVec3::ZERO, DQuat::from_xyzw(0.0, 0.0, f64::INFINITY, 1.0)).unwrap_err();
        assert!(matches!(infinite, PoseError::Rotation { .. }));
        let zero = Pose::new(DVec3::ZERO, DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)).unwrap_err();
        assert_eq!(zero, PoseError::ZeroRotation);
        assert!(Pose::from_f32(Vec3::new(f32::NAN, 0.0, 0.0), Quat::IDENTITY).is_err());
    }
}
