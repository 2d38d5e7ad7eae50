//! Queries in steps: a query states a direction, and continues with the support point in that
//! direction.
//!
//! Each algorithm of the solver is written once, as such a search. A single query is driven to its
//! end ([`at_once`]). A batch drives several in turns, each until its next wait for memory
//! ([`Suspended`]). The bits are the same.

use super::cache::Cache;
use super::minkowski::{Interrupted, Minkowski, Point, Step};
use crate::pose::Pose;
use crate::support::SupportMap;

/// A query of two shapes without convex radii, in steps.
pub(crate) trait SteppedQuery<A: ?Sized, B: ?Sized>: Sized {
    type Settings;
    type Answer;
    /// Memory that it uses until it has ended.
    type Workspace: Default;

    fn new() -> Self;

    /// The next step: the first one, or with the support point in the direction requested by the
    /// last one. The other arguments are the same for all steps.
    fn advance(
        &mut self,
        point: Option<Point>,
        m: &mut Minkowski<'_, A, B>,
        settings: &Self::Settings,
        cache: &mut Cache,
        workspace: &mut Self::Workspace,
    ) -> Step<Self::Answer>;
}

/// Drives a query to its end.
#[inline(always)]
pub(super) fn at_once<A: SupportMap + ?Sized, B: SupportMap + ?Sized, Q: SteppedQuery<A, B>>(
    m: &mut Minkowski<'_, A, B>,
    settings: &Q::Settings,
    cache: &mut Cache,
) -> Q::Answer {
    let (mut query, mut workspace) = (Q::new(), Q::Workspace::default());
    let mut step = query.advance(None, m, settings, cache, &mut workspace);
    loop {
        match step {
            Step::Answer(answer) => return answer,
            Step::Ask(dir) => step = query.advance(Some(m.point(dir)), m, settings, cache, &mut workspace),
        }
    }
}

/// A query that is suspended wherever it waits for memory.
#[derive(Debug)]
pub(crate) struct Suspended<'s, A: ?Sized, B: ?Sized, Q> {
    m: Minkowski<'s, A, B>,
    query: Q,
    next: Interrupted,
}

impl<'s, A: SupportMap + ?Sized, B: SupportMap + ?Sized, Q: SteppedQuery<A, B>> Suspended<'s, A, B, Q> {
    /// Starts a query of `a`, of `b` and of b's pose in a's frame.
    ///
    /// # Errors
    /// The answer, if it takes no support query.
    #[inline(always)]
    pub(crate) fn start(
        (a, b, b_in_a): (&'s A, &'s B, Pose),
        settings: &Q::Settings,
        cache: &mut Cache,
        workspace: &mut Q::Workspace,
    ) -> Result<Self, Q::Answer> {
        let (mut m, mut query) = (Minkowski::new(a, b, b_in_a), Q::new());
        match query.advance(None, &mut m, settings, cache, workspace) {
            Step::Answer(answer) => Err(answer),
            Step::Ask(dir) => {
                let next = m.start(dir);
                Ok(Self { m, query, next })
            }
        }
    }

    /// Continues until the query's next read from memory. Returns the answer as soon as it is
    /// known. The arguments are the same as of [`start`](Self::start).
    #[inline(always)]
    pub(crate) fn resume(
        &mut self,
        settings: &Q::Settings,
        cache: &mut Cache,
        workspace: &mut Q::Workspace,
    ) -> Option<Q::Answer> {
        if !self.next.is_ready() {
            self.m.resume(&mut self.next);
            return None;
        }
        let point = self.m.finish(&self.next);
        match self.query.advance(Some(point), &mut self.m, settings, cache, workspace) {
            Step::Answer(answer) => Some(answer),
            Step::Ask(dir) => {
                self.next = self.m.start(dir);
                None
            }
        }
    }
}
