//! Manifolds of all pairs of parts of two geometries.

use super::{PairQuery, answer};
use crate::compound::{CompoundManifolds, ManifoldCounts, Parts};
use crate::geometry::Geometry;
use crate::manifold::ManifoldSettings;
use crate::pose::Pose;
use crate::shapes::{HalfSpace, Shape};

impl CompoundManifolds {
    /// Updates the manifolds of all pairs of parts of `a` and `b`, with `b` placed at `b_in_a`.
    ///
    /// Afterwards every pair of parts that touches has a manifold, as from
    /// [`Manifold::update`](crate::Manifold::update), unless it was dropped. Manifolds of the last
    /// frame keep what the caller stored in their points. Two convex shapes have one manifold.
    ///
    /// # Complexity
    /// Compares all pairs of boxes within the prediction of each other, with one update of a
    /// manifold for each pair of parts in such leaves: at most G H for G and H parts, and one for
    /// two convex shapes. Finding the entry of a pair takes logarithmic time. No allocation.
    pub fn update<A, B>(&mut self, a: &A, b: &B, b_in_a: Pose, settings: &ManifoldSettings) -> ManifoldCounts
    where
        A: Geometry + ?Sized,
        B: Geometry + ?Sized,
    {
        answer(a, b, Update { manifolds: self, b_in_a, settings })
    }
}

struct Update<'q> {
    manifolds: &'q mut CompoundManifolds,
    b_in_a: Pose,
    settings: &'q ManifoldSettings,
}

impl PairQuery for Update<'_> {
    type Answer = ManifoldCounts;

    #[inline(always)]
    fn shapes<A: Shape + ?Sized, B: Shape + ?Sized>(self, a: &A, b: &B) -> ManifoldCounts {
        self.manifolds.update_shapes(a, b, self.b_in_a, self.settings)
    }

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> ManifoldCounts {
        self.manifolds.update_parts(a, b, self.b_in_a, self.settings)
    }

    fn half_space<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> ManifoldCounts {
        self.manifolds.update_half_space(a, b, self.b_in_a, self.settings)
    }

    fn half_space_as_b<A: Parts + ?Sized>(self, a: &A, b: &HalfSpace) -> ManifoldCounts {
        let Self { manifolds, b_in_a, settings } = self;
        let a_in_b = b_in_a.inverse();
        // The points of the last frame are exchanged for the update, and all points after it.
        manifolds.exchange(a_in_b);
        let counts = manifolds.update_half_space(b, a, a_in_b, settings);
        manifolds.exchange(b_in_a);
        counts
    }
}
