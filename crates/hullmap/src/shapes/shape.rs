//! `Shape`: a support mapping that also returns the feature (vertex, edge or face) facing a
//! direction.

#![forbid(unsafe_code)]

use glam::DVec3;

use super::feature::{Feature, ring};
use crate::support::SupportMap;

/// A convex shape with features, as contact manifolds require.
///
/// For a [`SupportMap`] of your own, `impl Shape for Mine {}` is enough: the default finds the
/// feature by support queries.
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Cuboid;
/// use hullmap::{Feature, Shape};
///
/// let plate = Cuboid::new(DVec3::new(2.0, 2.0, 0.1))?;
/// let mut feature = Feature::new();
/// plate.feature(DVec3::Z, &mut feature);
/// assert_eq!(feature.corners().len(), 4);
/// plate.feature(DVec3::new(1.0, 0.0, 1.0), &mut feature);
/// assert_eq!(feature.corners().len(), 2);
/// # Ok::<(), hullmap::shapes::ShapeError>(())
/// ```
pub trait Shape: SupportMap {
    /// Writes the feature that faces `dir` to `out`.
    ///
    /// `dir` is in the local frame and non-zero; it need not be of unit length. A face or an edge
    /// counts as facing `dir` within an angle of [`TILT`](crate::shapes::TILT). The default calls
    /// [`ring`].
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        ring(self, dir, out);
    }
}

/// A reference to a shape is the same shape.
impl<S: Shape + ?Sized> Shape for &S {
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        (**self).feature(dir, out);
    }
}
