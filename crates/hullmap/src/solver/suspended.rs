//! Queries that are suspended wherever they wait for memory, so that a batch can keep several of
//! them in flight.
//!
//! Each is a state machine over support queries: it states a direction, and continues with the
//! support point. `intersection`, `distance` and `contact` implement it beside the query itself,
//! which is the twin in tests.

use super::cache::Cache;
use crate::pose::Pose;

/// A suspended query of two shapes without convex radii.
pub(crate) trait Suspended<'s, A: ?Sized, B: ?Sized>: Sized {
    /// What the query needs to know.
    type Settings;
    /// What it returns.
    type Answer;
    /// Memory that it uses until it has ended.
    type Room: Default;

    /// Starts a query of `a`, of `b` and of b's pose in a's frame.
    ///
    /// # Errors
    /// The answer, if it takes no support query that has to wait.
    fn start(
        pair: (&'s A, &'s B, Pose),
        settings: &Self::Settings,
        cache: &mut Cache,
        room: &mut Self::Room,
    ) -> Result<Self, Self::Answer>;

    /// Continues up to the next memory that the query reads. Returns the answer as soon as it is
    /// known. The arguments are those of [`start`](Self::start).
    fn step(&mut self, settings: &Self::Settings, cache: &mut Cache, room: &mut Self::Room) -> Option<Self::Answer>;
}
