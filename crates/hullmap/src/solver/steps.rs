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
use glam::DVec3;

/// A query of two shapes without convex radii, between two steps.
pub(crate) trait SteppedQuery: Sized {
    type Settings;
    type Answer;
    /// Memory that it uses until it has ended.
    type Workspace: Default;

    /// Runs a search with memory for it.
    #[inline(always)]
    fn with_workspace<R>(search: impl FnOnce(&mut Self::Workspace) -> R) -> R {
        search(&mut Self::Workspace::default())
    }

    /// The answer if it is known before the search: from balls inside of the shapes and around
    /// them, or the last separating axis, whose support point may be enough.
    fn glance<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        cache: &mut Cache,
    ) -> Option<Step<Self::Answer>>;

    /// The answer if `axis` separates the shapes, with its support `point`.
    fn separated<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        _m: &Minkowski<'_, A, B>,
        _cache: &mut Cache,
        _axis: DVec3,
        _point: &Point,
    ) -> Option<Self::Answer> {
        None
    }

    /// The answer without a search, from few support queries at most.
    fn shortcut<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        _m: &mut Minkowski<'_, A, B>,
        _settings: &Self::Settings,
        _cache: &mut Cache,
    ) -> Option<Self::Answer> {
        None
    }

    /// Starts the search, and returns the direction of its first support query.
    ///
    /// # Errors
    /// The answer, if it takes no further support query.
    fn start<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        solver: Solver<'_, '_, A, B, (), Self::Workspace>,
        settings: &Self::Settings,
    ) -> Result<(Self, DVec3), Self::Answer>;

    /// The next step, with the support point in the direction requested by the last one.
    fn advance<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        solver: Solver<'_, '_, A, B, Self, Self::Workspace>,
        point: Point,
    ) -> Step<Self::Answer>;
}

/// A query of a pair, with everything that its steps share.
///
/// The steps are methods, and are inlined: a call would move the whole state of the query into
/// memory. Functions that are not inlined take only what they need.
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
    let mut m = Minkowski::new(a, b, b_in_a);
    match Q::glance(&m, cache) {
        Some(Step::Answer(answer)) => return answer,
        Some(Step::Ask(axis)) => {
            let point = m.point(axis);
            if let Some(answer) = Q::separated(&m, cache, axis, &point) {
                return answer;
            }
        }
        None => {}
    }
    if let Some(answer) = Q::shortcut(&mut m, settings, cache) {
        return answer;
    }
    if size_of::<Q::Workspace>() == 0 {
        search::<A, B, Q>(&mut m, settings, cache, &mut Q::Workspace::default())
    } else {
        search_apart::<A, B, Q>(&mut m, settings, cache)
    }
}

/// [`search`], not inlined, with a workspace, which the pairs that are answered before need not
/// touch.
#[inline(never)]
fn search_apart<A: SupportMap + ?Sized, B: SupportMap + ?Sized, Q: SteppedQuery>(
    m: &mut Minkowski<'_, A, B>,
    settings: &Q::Settings,
    cache: &mut Cache,
) -> Q::Answer {
    Q::with_workspace(|workspace| search::<A, B, Q>(m, settings, cache, workspace))
}

/// Drives the search to its end.
#[inline(always)]
fn search<A: SupportMap + ?Sized, B: SupportMap + ?Sized, Q: SteppedQuery>(
    m: &mut Minkowski<'_, A, B>,
    settings: &Q::Settings,
    cache: &mut Cache,
    workspace: &mut Q::Workspace,
) -> Q::Answer {
    let started = Solver { query: &mut (), m: &mut *m, cache: &mut *cache, workspace: &mut *workspace };
    let (mut query, mut dir) = match Q::start(started, settings) {
        Ok(started) => started,
        Err(answer) => return answer,
    };
    loop {
        let point = m.point(dir);
        let (query, m, cache, workspace) = (&mut query, &mut *m, &mut *cache, &mut *workspace);
        match Q::advance(Solver { query, m, cache, workspace }, point) {
            Step::Ask(next) => dir = next,
            Step::Answer(answer) => return answer,
        }
    }
}

/// A query that is suspended wherever it waits for memory.
#[derive(Debug)]
pub(crate) struct Suspended<'s, A: ?Sized, B: ?Sized, Q> {
    m: Minkowski<'s, A, B>,
    /// `None` while the support point of the last separating axis is awaited.
    query: Option<Q>,
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
        let mut m = Minkowski::new(a, b, b_in_a);
        let (query, dir) = match Q::glance(&m, cache) {
            Some(Step::Answer(answer)) => return Err(answer),
            Some(Step::Ask(axis)) => (None, axis),
            None => {
                let (query, dir) = Self::search(&mut m, settings, cache, workspace)?;
                (Some(query), dir)
            }
        };
        let next = m.start(dir);
        Ok(Self { m, query, next })
    }

    #[inline(always)]
    fn search(
        m: &mut Minkowski<'s, A, B>,
        settings: &Q::Settings,
        cache: &mut Cache,
        workspace: &mut Q::Workspace,
    ) -> Result<(Q, DVec3), Q::Answer> {
        match Q::shortcut(m, settings, cache) {
            Some(answer) => Err(answer),
            None => Q::start(Solver { query: &mut (), m, cache, workspace }, settings),
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
        let (point, axis) = (self.m.finish(&self.next), self.next.dir());
        let m = &mut self.m;
        let dir = match &mut self.query {
            Some(query) => match Q::advance(Solver { query, m, cache, workspace }, point) {
                Step::Answer(answer) => return Some(answer),
                Step::Ask(dir) => dir,
            },
            none => {
                if let Some(answer) = Q::separated(m, cache, axis, &point) {
                    return Some(answer);
                }
                match Self::search(m, settings, cache, workspace) {
                    Err(answer) => return Some(answer),
                    Ok((query, dir)) => {
                        *none = Some(query);
                        dir
                    }
                }
            }
        };
        self.next = self.m.start(dir);
        None
    }
}
