//! Input of a batch: pairs of shapes, and shapes with directions.

use glam::DVec3;

use crate::pose::Pose;
use crate::shapes::Shape;

/// Two shapes and their relative pose. For a batch of shapes of several types, use `dyn Shape +
/// Sync`.
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
