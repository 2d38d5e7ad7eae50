//! Whether two geometries share a point.

use super::{PairQuery, answer};
use crate::compound::{self, Parts, half_space};
use crate::geometry::Geometry;
use crate::pose::Pose;
use crate::shapes::{HalfSpace, Shape};
use crate::solver::{Cache, Intersection, queries};

/// Whether `a` and `b`, with `b` at `b_in_a`, share a point.
///
/// `cache` belongs to this ordered pair; the query reads and updates it. After a miss of two shapes
/// it holds the separating axis and the points seen, so that [`distance`](crate::distance()) with
/// the same cache needs fewer steps.
///
/// With parts, the status is the strongest of all pairs of parts: overlapping, then touching, then
/// undecided, then separated. [`parts`](Intersection::parts) is a pair with that status. If all are
/// separated, it is the last pair queried, or the first two parts if no pair was queried.
///
/// # Complexity
/// Two shapes: no support call if the inner or outer balls decide, 1 to 4 for most separated pairs,
/// 3 to 7 for most that overlap. With the cache of the last query usually one for separated pairs,
/// and none for those that overlap. Bounded. Rounded shapes cost a [`distance`](crate::distance())
/// query. Parts: starts with the pair that decided the last query, and ends at the first pair that
/// overlaps. Geometries that are separated cost all pairs of overlapping boxes, and the pairs of
/// parts in overlapping leaves. Half-space: one support query for each part that may be the lowest.
/// Allocation: see [`Cache`].
///
/// # Reference
/// Kenwright, Algorithm 1.
#[inline]
pub fn intersects<A, B>(a: &A, b: &B, b_in_a: Pose, cache: &mut Cache) -> Intersection
where
    A: Geometry + ?Sized,
    B: Geometry + ?Sized,
{
    answer(a, b, Intersects { b_in_a, cache })
}

struct Intersects<'q> {
    b_in_a: Pose,
    cache: &'q mut Cache,
}

impl PairQuery for Intersects<'_> {
    type Answer = Intersection;

    #[inline(always)]
    fn shapes<A: Shape + ?Sized, B: Shape + ?Sized>(self, a: &A, b: &B) -> Intersection {
        queries::intersects(a, b, self.b_in_a, self.cache)
    }

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> Intersection {
        compound::intersects(a, b, self.b_in_a, self.cache)
    }

    fn half_space<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> Intersection {
        half_space::lowest(a, b, self.b_in_a).intersection()
    }

    fn half_space_as_b<A: Parts + ?Sized>(self, a: &A, b: &HalfSpace) -> Intersection {
        let found = half_space::lowest(b, a, self.b_in_a.inverse()).intersection();
        let [of_b, of_a] = found.parts;
        Intersection { parts: [of_a, of_b], ..found }
    }
}
