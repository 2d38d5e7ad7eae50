//! EPA as a state machine: it states a direction, and continues with the support point in that
//! direction.
//!
//! A batch keeps several expansions in flight: while the memory that one of them needs is on its
//! way, the others compute. The steps are those of [`run`](super::search::run), and the transitions
//! between the polytope sizes those of [`expand`](super::expand) and of
//! [`expand_again`](super::expand_again), which are the twin in tests. Polytopes of the last two
//! sizes are rare and are expanded at once.

use glam::DVec3;

use super::flat::settle;
use super::polytope::Polytope;
use super::search::{Aim, End, Expansion, Goal, Next, State, Terms, aim, continue_with};
use super::sizes::SIZES;
use super::{SPARE, THIN_ROUNDINGS, WORN_OUT, expand_large, finish, restore};
use crate::solver::bound::Bound;
use crate::solver::cache::Cache;
use crate::solver::minkowski::{Minkowski, Point};
use crate::support::SupportMap;

/// The polytopes of one expansion: the first two sizes.
#[derive(Clone, Debug)]
pub(crate) struct Room {
    small: Polytope<{ SIZES[0] }, { 2 * SIZES[0] }>,
    medium: Polytope<{ SIZES[1] }, { 2 * SIZES[1] }>,
}

impl Default for Room {
    fn default() -> Self {
        Self { small: Polytope::empty(0.0), medium: Polytope::empty(0.0) }
    }
}

/// An expansion to the depth that waits for a support point.
#[derive(Clone, Copy, Debug)]
pub(in crate::solver) struct Search {
    terms: Terms,
    state: State,
    aim: Aim,
    is_medium: bool,
    /// It has started from the polytope of the cache.
    again: bool,
    /// The polytope is stored in the cache while it grows.
    keeps: bool,
}

/// How far an expansion has come.
pub(in crate::solver) enum Progress {
    /// It needs the support point in this direction.
    Query(DVec3),
    /// It has ended. `None` if it started from the polytope of the cache and has stalled.
    Ended(Option<Expansion>),
}

impl Search {
    fn new(terms: Terms, state: State) -> Self {
        Self { terms, state, aim: Aim::NOTHING, is_medium: false, again: false, keeps: true }
    }

    /// [`expand`](super::expand) to the depth, from a tetrahedron. `None` if it has no volume;
    /// nothing has changed then.
    pub(in crate::solver) fn start<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        tetrahedron: [Point; 4],
        tolerance: f64,
        max_expansions: u32,
        cache: &mut Cache,
        room: &mut Room,
    ) -> Option<Self> {
        room.small.clear(m.noise());
        if !room.small.start(tetrahedron, THIN_ROUNDINGS * m.rounding_error()) {
            return None;
        }
        let mut state = State::new(Bound::none());
        state.encloses = room.small.encloses();
        cache.forget_polytope();
        Some(Self::new(Terms::new(m, Goal::Depth { tolerance }, max_expansions), state))
    }

    /// [`expand_again`](super::expand_again) to the depth. `None` if the cache has no polytope that
    /// encloses the origin under the new pose.
    pub(in crate::solver) fn start_again<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        tolerance: f64,
        max_expansions: u32,
        cache: &Cache,
        room: &mut Room,
    ) -> Option<Self> {
        let points = cache.polytope()?.points().len();
        let is_medium = points + SPARE > SIZES[0];
        let state = if is_medium {
            room.medium.clear(m.noise());
            restore(m, &mut room.medium, cache)?
        } else {
            room.small.clear(m.noise());
            restore(m, &mut room.small, cache)?
        };
        let terms = Terms::new(m, Goal::Depth { tolerance }, max_expansions);
        Some(Self { is_medium, again: true, keeps: false, ..Self::new(terms, state) })
    }

    /// Continues up to the next support query.
    #[inline(always)]
    pub(in crate::solver) fn aim<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &mut self,
        m: &mut Minkowski<'_, A, B>,
        cache: &mut Cache,
        room: &mut Room,
    ) -> Progress {
        let Self { terms, state, is_medium, keeps, .. } = self;
        let kept_in = keeps.then_some(&mut *cache);
        let next = if *is_medium {
            aim(&mut room.medium, state, terms, kept_in)
        } else {
            match aim(&mut room.small, state, terms, kept_in) {
                Next::Full => {
                    room.small.overwrite(&mut room.medium);
                    (*is_medium, *keeps) = (true, true);
                    aim(&mut room.medium, state, terms, Some(&mut *cache))
                }
                next => next,
            }
        };
        match next {
            Next::Query(aim) => {
                self.aim = aim;
                Progress::Query(aim.direction())
            }
            Next::Ended => self.end(m, cache, room),
            Next::Full => {
                let expansion = expand_large(m, &room.medium, &mut self.state, &self.terms, cache.scratch());
                self.settle(m, expansion, cache)
            }
        }
    }

    /// Continues with the support point in the direction that was stated last, up to the next
    /// support query.
    #[inline(always)]
    pub(in crate::solver) fn continue_with<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &mut self,
        point: Point,
        m: &mut Minkowski<'_, A, B>,
        cache: &mut Cache,
        room: &mut Room,
    ) -> Progress {
        let Self { terms, state, aim, .. } = self;
        let has_ended = if self.is_medium {
            continue_with(&mut room.medium, state, terms, aim, point)
        } else {
            continue_with(&mut room.small, state, terms, aim, point)
        };
        if has_ended { self.end(m, cache, room) } else { self.aim(m, cache, room) }
    }

    fn end<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &mut self,
        m: &mut Minkowski<'_, A, B>,
        cache: &mut Cache,
        room: &Room,
    ) -> Progress {
        let Self { terms, state, .. } = self;
        let expansion = if self.is_medium {
            finish(m, &room.medium, state, terms, Some(&mut *cache))
        } else {
            finish(m, &room.small, state, terms, Some(&mut *cache))
        };
        self.settle(m, expansion, cache)
    }

    fn settle<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &self,
        m: &mut Minkowski<'_, A, B>,
        expansion: Expansion,
        cache: &mut Cache,
    ) -> Progress {
        if self.again && self.state.out.iterations > WORN_OUT {
            cache.forget_polytope();
        }
        let is_useless = self.again && expansion.end == End::Stalled;
        Progress::Ended((!is_useless).then(|| settle(m, expansion)))
    }
}
