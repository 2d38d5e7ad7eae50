//! Distance of two geometries.

use super::{PairQuery, answer};
use crate::compound::{self, Parts, half_space};
use crate::geometry::Geometry;
use crate::pose::Pose;
use crate::shapes::{HalfSpace, Shape};
use crate::solver::{Cache, Distance, Settings, queries};

/// Distance of `a` and `b`, with `b` at `b_in_a`, and the witness points that realise it.
///
/// Lengths are in the geometries' unit, points and directions in A's frame. The distance is 0 if
/// they overlap or touch; [`contact`](crate::contact()) then computes the depth. `cache` belongs to
/// this ordered pair; the query reads and updates it.
///
/// With parts, points, normal and distance belong to the nearest pair of parts, and the interval
/// contains the distance of the whole: no pair is nearer than `lower`, and the distance of some
/// pair is at most `upper`. The nearest pair gives the status, unless another pair's interval
/// makes the whole wider than the settings allow. Then it is the status of that other pair. For a
/// half-space, the normal is the plane's; if they overlap, both points are the lowest point of the
/// other geometry.
///
/// # Complexity
/// Two shapes: 4 to 10 support calls for most pairs; bounded by `settings`. Rounded shapes cost up
/// to three distance queries of their cores. Parts: branch and bound, starting with the nearest
/// pair of the last query; at most all pairs of parts. Half-space: one support query for each part
/// that may be the lowest. Allocation: see [`Cache`].
///
/// # Reference
/// Gilbert, Johnson, Keerthi 1988 (GJK); Kenwright, section 4.6. docs/contributors/intervals.md
/// proves the interval.
#[inline]
pub fn distance<A, B>(a: &A, b: &B, b_in_a: Pose, settings: &Settings, cache: &mut Cache) -> Distance
where
    A: Geometry + ?Sized,
    B: Geometry + ?Sized,
{
    answer(a, b, DistanceOf { b_in_a, settings, cache })
}

struct DistanceOf<'q> {
    b_in_a: Pose,
    settings: &'q Settings,
    cache: &'q mut Cache,
}

impl PairQuery for DistanceOf<'_> {
    type Answer = Distance;

    #[inline(always)]
    fn shapes<A: Shape + ?Sized, B: Shape + ?Sized>(self, a: &A, b: &B) -> Distance {
        queries::distance(a, b, self.b_in_a, self.settings, self.cache)
    }

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> Distance {
        compound::distance(a, b, self.b_in_a, self.settings, self.cache)
    }

    fn half_space<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> Distance {
        half_space::lowest(a, b, self.b_in_a).distance()
    }

    fn half_space_as_b<A: Parts + ?Sized>(self, a: &A, b: &HalfSpace) -> Distance {
        half_space::lowest(b, a, self.b_in_a.inverse()).distance().exchanged(self.b_in_a)
    }
}
