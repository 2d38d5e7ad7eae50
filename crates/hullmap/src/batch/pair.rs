//! Input of a batch: pairs of shapes, and shapes with directions.

use glam::DVec3;

use crate::pose::Pose;
use crate::shapes::Shape;

/// Two shapes and their relative pose. For a batch of shapes of several types, use `dyn Shape +
/// Sync`.
///
/// # Examples
/// ```
/// use hullmap::batch::Pair;
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::{Cuboid, Sphere};
/// use hullmap::{Pose, Shape, SupportMap};
///
/// let (ball, cube) = (Sphere::new(1.0)?, Cuboid::new(DVec3::ONE)?);
/// type AnyPair<'s> = Pair<'s, dyn Shape + Sync, dyn Shape + Sync>;
/// let pair: AnyPair = Pair { a: &ball, b: &cube, b_in_a: Pose::IDENTITY };
/// assert_eq!(pair.b.inner_radius(), 1.0);
/// # Ok::<(), hullmap::ShapeError>(())
/// ```
#[derive(Debug)]
pub struct Pair<'s, A: ?Sized, B: ?Sized> {
    /// The first shape.
    pub a: &'s A,
    /// The second shape.
    pub b: &'s B,
    /// Pose of B in A's frame.
    pub b_in_a: Pose,
}

impl<A: ?Sized, B: ?Sized> Clone for Pair<'_, A, B> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<A: ?Sized, B: ?Sized> Copy for Pair<'_, A, B> {}

/// A shape and a direction, for [`support_points`](super::support_points).
///
/// # Examples
/// ```
/// use hullmap::batch::SupportQuery;
/// use hullmap::glam::DVec3;
/// use hullmap::{SupportMap, shapes::Sphere};
///
/// let ball = Sphere::new(2.0)?;
/// let query = SupportQuery { shape: &ball, dir: DVec3::Y };
/// assert_eq!(query.shape.support_point(query.dir).point, DVec3::new(0.0, 2.0, 0.0));
/// # Ok::<(), hullmap::ShapeError>(())
/// ```
#[derive(Debug)]
pub struct SupportQuery<'s, S: ?Sized> {
    /// The shape.
    pub shape: &'s S,
    /// Direction in the shape's frame, as for
    /// [`SupportMap::support_point`](crate::SupportMap::support_point).
    pub dir: DVec3,
}

impl<S: ?Sized> Clone for SupportQuery<'_, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: ?Sized> Copy for SupportQuery<'_, S> {}

/// Whether the separating axis test may answer a contact.
pub(super) fn has_facets<A: Shape + ?Sized, B: Shape + ?Sized>(pair: &Pair<'_, A, B>) -> bool {
    pair.a.facets().is_some() && pair.b.facets().is_some()
}
