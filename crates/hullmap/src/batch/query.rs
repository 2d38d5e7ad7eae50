//! The queries that a batch answers for each pair.

use super::pair::Pair;
use crate::shapes::Shape;
use crate::solver::{
    Cache, Contact, ContactQuery, Distance, DistanceQuery, Intersection, IntersectionQuery, Settings, SteppedQuery,
    queries,
};

/// A query in steps, and the public query that it is the larger part of: that also solves rounded
/// shapes.
pub(super) trait BatchQuery: SteppedQuery<Settings: Sync, Answer: Send> {
    fn answer<A, B>(pair: &Pair<'_, A, B>, settings: &Self::Settings, cache: &mut Cache) -> Self::Answer
    where
        A: Shape + ?Sized,
        B: Shape + ?Sized;
}

impl BatchQuery for IntersectionQuery {
    fn answer<A, B>(pair: &Pair<'_, A, B>, (): &(), cache: &mut Cache) -> Intersection
    where
        A: Shape + ?Sized,
        B: Shape + ?Sized,
    {
        queries::intersects(pair.a, pair.b, pair.b_in_a, cache)
    }
}

impl BatchQuery for DistanceQuery {
    fn answer<A, B>(pair: &Pair<'_, A, B>, settings: &Settings, cache: &mut Cache) -> Distance
    where
        A: Shape + ?Sized,
        B: Shape + ?Sized,
    {
        queries::distance(pair.a, pair.b, pair.b_in_a, settings, cache)
    }
}

impl BatchQuery for ContactQuery {
    fn answer<A, B>(pair: &Pair<'_, A, B>, settings: &Settings, cache: &mut Cache) -> Contact
    where
        A: Shape + ?Sized,
        B: Shape + ?Sized,
    {
        queries::contact(pair.a, pair.b, pair.b_in_a, settings, cache)
    }
}
