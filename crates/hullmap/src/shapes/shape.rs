//! `Shape`: a support mapping that also returns the feature (vertex, edge or face) facing a
//! direction. To add a shape, follow the recipe in CONTRIBUTING.md.

#![forbid(unsafe_code)]

use glam::DVec3;

use super::feature::{Feature, ring};
use crate::solver::Ray;
use crate::solver::ray::entry;
use crate::support::SupportMap;

/// A convex shape with features, as contact manifolds require.
///
/// For a [`SupportMap`] of your own, `impl Shape for Mine {}` is enough: the default finds the
/// feature by support queries.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not one convex shape",
    label = "a convex shape is expected here",
    note = "a pack of parts, a triangle mesh, a height field or a half-space is queried by the functions of the crate, \
            such as `hullmap::contacts`, and keeps its manifolds in `CompoundManifolds` or `BodyManifold`",
    note = "for a support mapping of your own, `impl Shape for Mine {{}}` is enough"
)]
pub trait Shape: SupportMap {
    /// Writes the feature that faces `dir` to `out`.
    ///
    /// `dir` is in the local frame and non-zero; it need not be of unit length. A face or an edge
    /// counts as facing `dir` within an angle of [`TILT`](crate::shapes::TILT). The default calls
    /// [`ring`].
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        ring(self, dir, out);
    }

    /// Writes the feature that faces `dir` to `out`, if surfaces up to `reach` below the support
    /// plane matter.
    ///
    /// The support plane is the plane perpendicular to `dir` through the support point, and `reach`
    /// is a length: a contact manifold passes its prediction. A face counts as facing `dir` if
    /// three of its corners are within `reach` of the support plane, an edge if both ends are,
    /// whatever their angle. So a body that is small compared with the prediction keeps its face
    /// while it rocks. Features within [`TILT`](crate::shapes::TILT) count in any case.
    ///
    /// The default ignores `reach` and calls [`feature`](Self::feature).
    fn feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        // The parameter has this name for the documentation.
        let _ = reach;
        self.feature(dir, out);
    }

    /// As [`feature_within`](Self::feature_within), at less cost: a face may be represented by a
    /// few of its corners, and [`Feature::is_reduced`] is true if it is.
    ///
    /// The corners that remain are in order, in the plane of the face, and span at least half of
    /// its area. A contact manifold starts from reduced features, and needs the whole ones only if
    /// a corner lies outside the other feature.
    ///
    /// The default calls [`feature_within`](Self::feature_within).
    fn reduced_feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        self.feature_within(dir, reach, out);
    }

    /// The t at which `ray` enters the shape; `None` if it misses or grazes it. If t is more than
    /// `until`, it may be `None` as well.
    ///
    /// The ray starts outside of the shape. `near` is a vertex of a feature close to the ray, and
    /// changes the time alone. The answer is exact up to 1e-10 of the outer radius. A contact
    /// manifold finds points on surfaces that are not flat with it.
    ///
    /// The default casts the ray by support queries. A hull walks over its faces, which
    /// is faster if the vertex is close.
    fn entry(&self, ray: &Ray, near: u32, until: f64) -> Option<f64> {
        // The parameters have these names for the documentation.
        let _ = (near, until);
        // A reference, since `Self` need not have a size.
        entry(&self, ray)
    }

    /// The corners, if the shape is a triangle. Queries of meshes use them to rule triangles out
    /// before they search. The default is `None`.
    fn triangle(&self) -> Option<[DVec3; 3]> {
        None
    }
}

/// Passes every method of [`Shape`] on to `$inner`.
macro_rules! forward_shape {
    ($this:ident => $inner:expr) => {
        fn feature(&$this, dir: DVec3, out: &mut Feature) {
            $inner.feature(dir, out);
        }
        fn feature_within(&$this, dir: DVec3, reach: f64, out: &mut Feature) {
            $inner.feature_within(dir, reach, out);
        }
        fn reduced_feature_within(&$this, dir: DVec3, reach: f64, out: &mut Feature) {
            $inner.reduced_feature_within(dir, reach, out);
        }
        fn entry(&$this, ray: &Ray, near: u32, until: f64) -> Option<f64> {
            $inner.entry(ray, near, until)
        }
        fn triangle(&$this) -> Option<[DVec3; 3]> {
            $inner.triangle()
        }
    };
}
pub(crate) use forward_shape;

/// A reference to a shape is the same shape.
impl<S: Shape + ?Sized> Shape for &S {
    forward_shape!(self => (**self));
}
