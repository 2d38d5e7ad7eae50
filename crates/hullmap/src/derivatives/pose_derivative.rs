//! Derivative of a length or a time by the poses of two shapes.

use glam::DVec3;

use crate::fields::words;
use crate::pose::Pose;

/// Derivative of a length or a time by the pose of a shape: how much it changes when the shape
/// moves by a small twist.
///
/// A twist moves the shape by `v` and turns it by the rotation vector `w` about the origin of its
/// own frame. Both are in the frame of the answer, so the turn is applied on the left of the
/// shape's rotation. The change is `linear · v + angular · w`, to first order.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseDerivative {
    /// By the translation: per unit of length.
    pub linear: DVec3,
    /// By the rotation about the origin of the shape's frame: per radian.
    pub angular: DVec3,
}

impl PoseDerivative {
    /// Derivative of the height of a point of the shape along `direction`, for a shape whose frame
    /// has its origin at `origin`.
    pub(super) fn of_height(direction: DVec3, point: DVec3, origin: DVec3) -> Self {
        Self { linear: direction, angular: (point - origin).cross(direction) }
    }

    pub(super) fn times(self, factor: f64) -> Self {
        Self { linear: self.linear * factor, angular: self.angular * factor }
    }

    /// The linear part and the angular part.
    pub fn to_array(&self) -> [f64; 6] {
        let (l, a) = (self.linear, self.angular);
        [l.x, l.y, l.z, a.x, a.y, a.z]
    }

    fn rotated(&self, pose: &Pose) -> Self {
        Self { linear: pose.transform_vector(self.linear), angular: pose.transform_vector(self.angular) }
    }
}

/// Whether a length or a time has a derivative, or the reason why it has none.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Differentiability {
    /// There is one pair of points and one normal within the interval of the answer.
    Unique = 0,
    /// The shapes touch, or it is not certain that they do not: distance and depth have a kink at
    /// 0.
    Touching = 1,
    /// Faces or edges are parallel within the interval, so several pairs of points have the same
    /// distance: a rotation moves each of them differently.
    Parallel = 2,
    /// Several normals have the same depth within the interval, or a line meets a vertex or an
    /// edge.
    Normals = 3,
    /// A ray or a motion is parallel to the surface that it meets, within rounding error.
    Grazing = 4,
    /// There is nothing to differentiate: no hit, an overlap at the start of a motion, or the depth
    /// of a separated pair.
    Missing = 5,
    /// The answer is less accurate than its settings require.
    Inaccurate = 6,
    /// Only of normals and points: a point is on the border of its face or edge, or the normal is
    /// on the border of the normals of its edge or vertex, within the interval. Other features are
    /// nearest beyond.
    Feature = 7,
    /// Only of normals and points: the shape is curved there, and no feature describes how.
    Curved = 8,
}

words!(
    Differentiability {
        Unique = "unique" Touching = "touching" Parallel = "parallel" Normals = "normals"
        Grazing = "grazing" Missing = "missing" Inaccurate = "inaccurate" Feature = "feature"
        Curved = "curved"
    }
);

/// Derivatives of a length or a time by the poses of A and of B, in the frame of the answer.
///
/// If the status is not [`Unique`](Differentiability::Unique), they belong to the normal and the
/// points of the answer, which are some of several: a direction for an optimiser, and no
/// derivative. They are 0 if there is nothing to differentiate.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Derivatives {
    /// Whether these are derivatives.
    pub status: Differentiability,
    /// By the pose of A.
    pub by_a: PoseDerivative,
    /// By the pose of B, or of the point or the ray.
    pub by_b: PoseDerivative,
}

impl Default for Derivatives {
    /// No derivatives of a missing answer.
    fn default() -> Self {
        Self::none(Differentiability::Missing)
    }
}

impl Derivatives {
    pub(super) fn none(status: Differentiability) -> Self {
        Self { status, by_a: PoseDerivative::default(), by_b: PoseDerivative::default() }
    }

    /// The same in a common frame, in which A is at `a_in_world`.
    #[must_use]
    pub fn in_world(&self, a_in_world: Pose) -> Self {
        Self { by_a: self.by_a.rotated(&a_in_world), by_b: self.by_b.rotated(&a_in_world), ..*self }
    }
}
