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

/// A query of two shapes without convex radii, between two steps.
pub(crate) trait SteppedQuery: Sized {
    type Settings;
    type Answer;
    /// Memory that it uses until it has ended.
    type Workspace: Default;

    fn new(settings: &Self::Settings) -> Self;

    /// The next step: the first one, or with the support point in the direction requested by the
    /// last one.
    fn advance<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        solver: Solver<'_, '_, A, B, Self, Self::Workspace>,
        point: Option<Point>,
    ) -> Step<Self::Answer>;
}

/// A query of a pair, with everything that its steps share.
///
/// The steps are methods, and are inlined: a call would move the whole state of the query into
/// memory. What is not inlined takes only what it needs.
pub(crate) struct Solver<'q, 's, A: ?Sized, B: ?Sized, Q, W> {
    /// The state between two steps.
    pub(super) query: &'q mut Q,
    pub(super) m: &'q mut Minkowski<'s, A, B>,
    pub(super) cache: &'q mut Cache,
    pub(super) workspace: &'q mut W,
}

/// Drives a query to its end.
#[inline(always)]
pub(super) fn at_once<A: SupportMap + ?Sized, B: SupportMap + ?Sized, Q: SteppedQuery>(
    (a, b, b_in_a): (&A, &B, Pose),
    settings: &Q::Settings,
    cache: &mut Cache,
) -> Q::Answer {
    let (mut query, mut workspace, mut m) = (Q::new(settings), Q::Workspace::default(), Minkowski::new(a, b, b_in_a));
    let mut step =
        Q::advance(Solver { query: &mut query, m: &mut m, cache: &mut *cache, workspace: &mut workspace }, None);
    loop {
        match step {
            Step::Answer(answer) => return answer,
            Step::Ask(dir) => {
                let point = Some(m.point(dir));
                let (query, m, cache, workspace) = (&mut query, &mut m, &mut *cache, &mut workspace);
                step = Q::advance(Solver { query, m, cache, workspace }, point);
            }
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

impl<'s, A: SupportMap + ?Sized, B: SupportMap + ?Sized, Q: SteppedQuery> Suspended<'s, A, B, Q> {
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
        let (mut m, mut query) = (Minkowski::new(a, b, b_in_a), Q::new(settings));
        match Q::advance(Solver { query: &mut query, m: &mut m, cache, workspace }, None) {
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
    pub(crate) fn resume(&mut self, cache: &mut Cache, workspace: &mut Q::Workspace) -> Option<Q::Answer> {
        if !self.next.is_ready() {
            self.m.resume(&mut self.next);
            return None;
        }
        let point = self.m.finish(&self.next);
        match Q::advance(Solver { query: &mut self.query, m: &mut self.m, cache, workspace }, Some(point)) {
            Step::Answer(answer) => Some(answer),
            Step::Ask(dir) => {
                self.next = self.m.start(dir);
                None
            }
        }
    }
}
