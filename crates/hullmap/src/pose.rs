//! Rigid pose of one shape in the frame of another.
//!
//! Read a pose from right to left: `b_in_a` maps points of B's local frame into A's local frame,
//! `p_in_a = rotation * p_in_b + translation`. A pose is checked once, when it is made. Queries
//! therefore never test whether a number is finite or a quaternion has unit length.

#![forbid(unsafe_code)]

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Quat, Vec3};

/// Largest magnitude of a translation's coordinate, the same as for the shapes' own f32
/// coordinates.
///
/// The solver multiplies up to six lengths. Lengths within this limit cannot overflow f64 there.
pub const MAX_TRANSLATION: f64 = f32::MAX as f64;

/// Largest deviation of a rotation matrix from an orthonormal one, per entry of `mᵀ m`.
///
/// A matrix that was composed in f32 deviates by about 1e-6; a scale or shear of 0.1 % deviates by
/// 2e-3.
const MAX_SHEAR: f64 = 1e-4;

/// A rigid transform `b_in_a`, which maps B's local frame into A's.
///
/// The translation is in A's frame and units, finite and within [`MAX_TRANSLATION`]. The rotation
/// has unit length. There is no scale: see [`Scaled`](crate::shapes::Scaled) for scaled shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    rotation: DQuat,
    translation: DVec3,
}

/// Why numbers are not a valid [`Pose`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PoseError {
    /// A component of the translation is NaN, infinite, or beyond [`MAX_TRANSLATION`].
    #[error(
        "translation must be finite and within 3.4e38, found ({:?}, {:?}, {:?}): \
         check the pose's source for a division by zero or an overflow",
        found.x, found.y, found.z
    )]
    Translation {
        /// The translation as given.
        found: DVec3,
    },
    /// A component of the rotation is NaN or infinite.
    #[error(
        "rotation must be finite, found ({:?}, {:?}, {:?}, {:?}): check the pose's source for a division by zero or an overflow",
        found.x, found.y, found.z, found.w
    )]
    Rotation {
        /// The quaternion as given, x y z w.
        found: DQuat,
    },
    /// The rotation is the zero quaternion, which is not a rotation.
    #[error("rotation must not be the zero quaternion; the identity is (0, 0, 0, 1), in the order x y z w")]
    ZeroRotation,
    /// A matrix is not a rotation: it scales, shears, mirrors or projects.
    #[error(
        "matrix must be a rotation and a translation, found one that scales, shears, mirrors or projects: \
         scale the shape instead (`shapes::Scaled`)"
    )]
    NotRigid {
        /// The linear part of the matrix as given.
        found: DMat3,
    },
}

impl Pose {
    /// The identity: B's frame coincides with A's.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, translation: DVec3::ZERO };

    /// The pose that rotates by `rotation`, then translates by `translation` (in A's frame and
    /// units).
    ///
    /// `rotation` may have any finite non-zero length; it is normalised here.
    ///
    /// # Errors
    /// A component is NaN or infinite, the translation is beyond [`MAX_TRANSLATION`], or `rotation`
    /// is zero.
    pub fn new(translation: DVec3, rotation: DQuat) -> Result<Self, PoseError> {
        if !rotation.is_finite() {
            return Err(PoseError::Rotation { found: rotation });
        }
        // Divide by the largest component first: squares of tiny or huge components would underflow
        // or overflow.
        let greatest = rotation.to_array().into_iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        if greatest == 0.0 {
            return Err(PoseError::ZeroRotation);
        }
        let rotation = DQuat::from_array(rotation.to_array().map(|c| c / greatest)).normalize();
        Ok(Self { rotation, ..Self::from_translation(translation)? })
    }

    /// The pose that only translates, by `translation` in A's frame and units.
    ///
    /// # Errors
    /// A component is NaN, infinite, or beyond [`MAX_TRANSLATION`].
    pub fn from_translation(translation: DVec3) -> Result<Self, PoseError> {
        // NaN takes the failing branch.
        let within = translation.to_array().into_iter().all(|c| c.abs() <= MAX_TRANSLATION);
        if !within {
            return Err(PoseError::Translation { found: translation });
        }
        Ok(Self { rotation: DQuat::IDENTITY, translation })
    }

    /// [`Pose::new`] from single precision. Numbers are widened first and normalised in double
    /// precision.
    ///
    /// # Errors
    /// As [`Pose::new`].
    pub fn from_f32(translation: Vec3, rotation: Quat) -> Result<Self, PoseError> {
        Self::new(translation.as_dvec3(), rotation.as_dquat())
    }

    /// The pose of an affine transform that rotates and translates.
    ///
    /// The rotation is taken from the matrix and normalised, so rounding errors in the matrix are
    /// harmless.
    ///
    /// # Errors
    /// [`PoseError::NotRigid`] if the matrix scales, shears or mirrors by more than 1e-4, or is not
    /// finite; else as [`Pose::new`].
    ///
    /// # Examples
    /// ```
    /// use hullmap::glam::{DAffine3, DVec3};
    /// use hullmap::{Pose, PoseError};
    ///
    /// let turned = DAffine3::from_rotation_x(0.5);
    /// let error = Pose::from_affine(turned)?.rotation_matrix() - turned.matrix3;
    /// assert!(error.to_cols_array().iter().all(|e| e.abs() < 1e-15));
    /// let doubled = DAffine3::from_scale(DVec3::splat(2.0));
    /// assert!(matches!(Pose::from_affine(doubled), Err(PoseError::NotRigid { .. })));
    /// # Ok::<(), PoseError>(())
    /// ```
    pub fn from_affine(b_in_a: DAffine3) -> Result<Self, PoseError> {
        let turn = b_in_a.matrix3;
        let error = (turn.transpose() * turn - DMat3::IDENTITY).to_cols_array();
        // NaN takes the failing branch.
        let is_rotation = error.iter().all(|e| e.abs() <= MAX_SHEAR) && turn.determinant() > 0.0;
        if !is_rotation {
            return Err(PoseError::NotRigid { found: turn });
        }
        Self::new(b_in_a.translation, DQuat::from_mat3(&turn))
    }

    /// The pose of a 4×4 matrix in glam's convention: column vectors, translation in the last
    /// column.
    ///
    /// # Errors
    /// As [`from_affine`](Self::from_affine). A last row other than (0, 0, 0, 1) is a projection
    /// and not rigid.
    pub fn from_matrix(b_in_a: DMat4) -> Result<Self, PoseError> {
        let affine = DAffine3::from_mat4(b_in_a);
        if b_in_a.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
            return Err(PoseError::NotRigid { found: affine.matrix3 });
        }
        Self::from_affine(affine)
    }

    /// The pose of B in A, `b_in_a`, from the poses of both in a common frame.
    ///
    /// Translations are subtracted before they are rotated, so two bodies near each other keep
    /// their digits however far they are from the common origin.
    ///
    /// # Errors
    /// [`PoseError::Translation`] if B is more than [`MAX_TRANSLATION`] away from A.
    ///
    /// # Examples
    /// ```
    /// use hullmap::Pose;
    /// use hullmap::glam::{DQuat, DVec3};
    ///
    /// let a_in_world = Pose::new(DVec3::new(1e9, 0.0, 0.0), DQuat::from_rotation_z(1.0))?;
    /// let b_in_world = Pose::new(DVec3::new(1e9, 0.0, 2.0), DQuat::from_rotation_z(1.0))?;
    /// let b_in_a = Pose::relative(a_in_world, b_in_world)?;
    /// assert_eq!(b_in_a.translation(), DVec3::new(0.0, 0.0, 2.0));
    /// # Ok::<(), hullmap::PoseError>(())
    /// ```
    pub fn relative(a_in_world: Self, b_in_world: Self) -> Result<Self, PoseError> {
        let world_to_a = a_in_world.rotation.conjugate();
        Self::new(world_to_a * (b_in_world.translation - a_in_world.translation), world_to_a * b_in_world.rotation)
    }

    /// The composition `b_in_a.compose(c_in_b)`, which is `c_in_a`.
    ///
    /// There is no operator `*`, because it could not return an error: the sum of two valid
    /// translations may be out of range.
    ///
    /// # Errors
    /// [`PoseError::Translation`] if C is more than [`MAX_TRANSLATION`] away from A.
    pub fn compose(&self, c_in_b: Self) -> Result<Self, PoseError> {
        Self::new(self.transform_point(c_in_b.translation), self.rotation * c_in_b.rotation)
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

    /// The rotation as a matrix, which is faster for rotating many vectors.
    #[inline]
    pub fn rotation_matrix(&self) -> DMat3 {
        DMat3::from_quat(self.rotation)
    }

    /// The pose as a 4×4 matrix: column vectors, translation in the last column.
    pub fn to_matrix(&self) -> DMat4 {
        DMat4::from_rotation_translation(self.rotation, self.translation)
    }

    /// The pose as an affine transform.
    pub fn to_affine(&self) -> DAffine3 {
        DAffine3::from_rotation_translation(self.rotation, self.translation)
    }

    /// The inverse pose, `a_in_b`.
    #[inline]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.conjugate();
        Self { rotation, translation: -(rotation * self.translation) }
    }

    /// The pose that translates to a point which has been checked already.
    #[inline]
    pub(crate) fn from_checked(translation: DVec3) -> Self {
        Self { rotation: DQuat::IDENTITY, translation }
    }

    /// The pose of a rotation of unit length and a translation, which have been checked already.
    #[inline]
    pub(crate) fn from_parts(rotation: DQuat, translation: DVec3) -> Self {
        Self { rotation, translation }
    }

    /// The pose after a translation by `by` in A's frame, which may lead beyond
    /// [`MAX_TRANSLATION`].
    #[inline]
    pub(crate) fn moved(&self, by: DVec3) -> Self {
        Self { rotation: self.rotation, translation: self.translation + by }
    }

    /// Maps a point from B's frame into A's.
    #[inline]
    pub fn transform_point(&self, point_in_b: DVec3) -> DVec3 {
        self.rotation * point_in_b + self.translation
    }

    /// Maps a direction from B's frame into A's: rotates it and does not translate it.
    #[inline]
    pub fn transform_vector(&self, vector_in_b: DVec3) -> DVec3 {
        self.rotation * vector_in_b
    }

    /// Maps a point from A's frame into B's.
    #[inline]
    pub fn inverse_transform_point(&self, point_in_a: DVec3) -> DVec3 {
        self.inverse_transform_vector(point_in_a - self.translation)
    }

    /// Maps a direction from A's frame into B's.
    #[inline]
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
    use glam::DVec4;

    fn some_pose() -> Pose {
        Pose::new(DVec3::new(1.0, -2.0, 3.0), DQuat::from_xyzw(0.3, -0.2, 0.9, 0.4)).unwrap()
    }

    #[test]
    fn inverse_undoes_the_pose() {
        let pose = some_pose();
        let p = DVec3::new(0.7, 5.0, -2.5);
        assert!((pose.inverse().transform_point(pose.transform_point(p)) - p).length() < 1e-14);
        assert!((pose.inverse_transform_point(pose.transform_point(p)) - p).length() < 1e-14);
        assert!((pose.inverse_transform_vector(pose.transform_vector(p)) - p).length() < 1e-14);
        assert!((pose.rotation_matrix() * p + pose.translation() - pose.transform_point(p)).length() < 1e-14);
    }

    #[test]
    fn rotations_of_any_length_are_normalised() {
        let unit = some_pose().rotation();
        for scale in [1e-300, 1e-6, 1.0, 1e6, 1e300] {
            let scaled = DQuat::from_array(unit.to_array().map(|c| c * scale));
            let pose = Pose::new(DVec3::ZERO, scaled).unwrap();
            assert!((pose.rotation().length() - 1.0).abs() < 1e-15);
            assert!(pose.rotation().dot(unit) > 1.0 - 1e-14);
        }
    }

    #[test]
    fn errors_name_the_number_found() {
        let nan = Pose::from_translation(DVec3::new(0.0, f64::NAN, 0.0)).unwrap_err();
        assert!(nan.to_string().contains("(0.0, NaN, 0.0)"), "{nan}");
        let far = Pose::from_translation(DVec3::new(1e300, 0.0, 0.0)).unwrap_err();
        assert!(far.to_string().contains("found (1e300, 0.0, 0.0)"), "{far}");
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

    #[test]
    fn relative_is_the_composition_with_the_inverse() {
        let a_in_world = some_pose();
        let b_in_world = Pose::new(DVec3::new(4.0, 0.5, -1.0), DQuat::from_xyzw(-0.1, 0.7, 0.2, 0.5)).unwrap();
        let b_in_a = Pose::relative(a_in_world, b_in_world).unwrap();
        let expected = a_in_world.inverse().compose(b_in_world).unwrap();
        assert!((b_in_a.translation() - expected.translation()).length() < 1e-14);
        assert!(b_in_a.rotation().angle_between(expected.rotation()) < 1e-7);
        let back = a_in_world.compose(b_in_a).unwrap();
        for point in [DVec3::ZERO, DVec3::X, DVec3::new(-3.0, 2.0, 9.0)] {
            assert!((back.transform_point(point) - b_in_world.transform_point(point)).length() < 1e-13);
        }
    }

    #[test]
    fn poses_too_far_from_each_other_are_errors() {
        let far = Pose::from_translation(DVec3::X * MAX_TRANSLATION).unwrap();
        let other = Pose::from_translation(-DVec3::X * MAX_TRANSLATION).unwrap();
        assert!(matches!(Pose::relative(far, other), Err(PoseError::Translation { .. })));
        assert!(matches!(far.compose(far), Err(PoseError::Translation { .. })));
        assert_eq!(Pose::relative(far, far).unwrap().translation(), DVec3::ZERO);
    }

    #[test]
    fn matrices_round_trip_and_only_rigid_ones_pass() {
        let pose = some_pose();
        for back in [Pose::from_matrix(pose.to_matrix()).unwrap(), Pose::from_affine(pose.to_affine()).unwrap()] {
            assert_eq!(back.translation(), pose.translation());
            assert!(back.rotation().dot(pose.rotation()).abs() > 1.0 - 1e-15);
        }
        let f32_matrix = pose.to_matrix().as_mat4().as_dmat4();
        assert!(Pose::from_matrix(f32_matrix).is_ok());
        let linear = |m: DMat3| Pose::from_affine(DAffine3 { matrix3: m, translation: DVec3::ZERO });
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.01, 1.0, 0.0), DVec3::Z);
        for m in [DMat3::IDENTITY * 1.001, -DMat3::IDENTITY, shear, DMat3::ZERO, DMat3::IDENTITY * f64::NAN] {
            assert!(matches!(linear(m), Err(PoseError::NotRigid { .. })), "{m}");
        }
        let projection = DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::new(0.0, 0.0, 1.0, -1.0), DVec4::W);
        assert!(matches!(Pose::from_matrix(projection), Err(PoseError::NotRigid { .. })));
    }
}
