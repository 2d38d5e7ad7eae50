//! Many motions in one call, for planners.
//!
//! They are searched one after the other on each thread: a search makes several queries of the same
//! two shapes, so there is no memory to wait for after the first.

use super::{BatchError, map};
use crate::continuous::{ClearSettings, Clearance, RigidMotion};
use crate::geometry::Geometry;
use crate::solver::Cache;

/// Two bodies and their motions in a common frame, over the times 0 to 1. For a batch of shapes of
/// several types, use `dyn Shape + Sync`.
#[derive(Debug)]
pub struct MovingPair<'s, A: ?Sized, B: ?Sized> {
    /// The first body.
    pub a: &'s A,
    /// Its motion.
    pub motion_a: RigidMotion,
    /// The second body.
    pub b: &'s B,
    /// Its motion.
    pub motion_b: RigidMotion,
}

impl<A: ?Sized, B: ?Sized> Clone for MovingPair<'_, A, B> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<A: ?Sized, B: ?Sized> Copy for MovingPair<'_, A, B> {}

/// Writes whether each `pairs[i]` is [`clear`](crate::clear()) to `out[i]`, using `caches[i]`. For
/// pairs with parts, caches may be small: [`Cache::with_pairs(1)`](Cache::with_pairs).
///
/// # Errors
/// [`BatchError`] if the slices differ in length. Nothing is written in that case.
///
/// # Complexity
/// The sum over the single queries, divided among the threads. No allocation per pair.
pub fn clear<A, B>(
    pairs: &[MovingPair<'_, A, B>],
    settings: &ClearSettings,
    caches: &mut [Cache],
    out: &mut [Clearance],
) -> Result<(), BatchError>
where
    A: Geometry + Sync + ?Sized,
    B: Geometry + Sync + ?Sized,
{
    map(pairs, caches, out, |pair, cache| crate::clear(pair.a, &pair.motion_a, pair.b, &pair.motion_b, settings, cache))
}
